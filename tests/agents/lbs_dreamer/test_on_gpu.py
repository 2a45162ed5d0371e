"""What only a GPU can show; a CPU shows all else in kernels/test_cuda_graphs.py and test_device_replay.py."""

import numpy as np
import pytest
import torch

from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer
from curionav_cli.agents.lbs_dreamer.device_replay import DeviceReplay
from curionav_cli.agents.lbs_dreamer.kernels.cuda_graphs import Recorded

pytestmark = [pytest.mark.gpu, pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device"),
              pytest.mark.filterwarnings("default")]  # torch's compiler has some of its own


@pytest.fixture
def on_gpu(tiny, a_plan):
    """on_gpu(compile, **changes): a tiny agent."""
    return lambda compile="auto", seed=0, **changes: LBSDreamer(tiny(**changes), seed, "cuda", a_plan(), compile)


def weights(agent):
    return torch.cat([tensor.flatten().double() for tensor in agent.learner.networks.state_dict().values()])


def learn(agent, replay, updates):
    return agent.learn(replay, updates, lambda done: None)


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
@pytest.mark.parametrize("compile", ["graph", "fused"])
def test_graphs_learn_what_kernels_one_by_one_do(on_gpu, replay, compile, precision):
    """Losses within 2 %, weights within 5 % of the way they went, after 12 updates."""
    agents = [on_gpu(way, precision=precision) for way in ("none", compile)]
    start, store = weights(agents[0]), replay()
    eager, graph = (learn(agent, store, 12) for agent in agents)
    assert all(isinstance(run, Recorded) and run.run for run in agents[1].learner.run.values())
    for name in ("model_loss", "kl", "curiosity_loss", "critic_loss", "actor_entropy", "model_norm"):
        assert graph[name] == pytest.approx(eager[name], rel=0.02), name
    eager_end, graph_end = (weights(agent) for agent in agents)
    assert (graph_end - eager_end).norm() < 0.05 * (eager_end - start).norm()


def test_a_gpu_learns_what_a_cpu_does(on_gpu, agent, replay):
    """The first update from the same weights on the same windows; noise differs, so losses only roughly."""
    store = replay()
    ours, cpu = learn(on_gpu(), store, 1), learn(agent(), store, 1)
    assert ours["model_loss"] == pytest.approx(cpu["model_loss"], rel=0.05)
    assert ours.keys() == cpu.keys()


def test_acting_by_graph_is_acting(on_gpu, replay):
    walks = []
    for compile in ("none", "graph"):
        made, walks = on_gpu(compile), [*walks, []]
        for episode in (replay().episode(0), replay().episode(1)):
            made.begin()
            walks[-1] += [made.act({"image": image}, {"episode_index": 0}) for image in episode.image]
    assert walks[0] == walks[1]


def test_a_resumed_agent_goes_on_to_the_bit(on_gpu, replay, tmp_path):
    straight, store = on_gpu(), replay()
    learn(straight, store, 5)
    straight.save(tmp_path)
    resumed, used = on_gpu(seed=7), on_gpu(seed=8)
    learn(used, store, 3)  # what it recorded must go on with what it loads
    for made in (resumed, used):
        made.load(tmp_path)
    for made in (straight, resumed, used):
        learn(made, store, 6)
    assert torch.equal(weights(straight), weights(resumed))
    assert torch.equal(weights(straight), weights(used))


def test_memory_does_not_grow(on_gpu, replay):
    made, store, taken = on_gpu(), replay(), []
    for _ in range(2):
        learn(made, store, 500)
        torch.cuda.synchronize()
        taken.append((torch.cuda.memory_allocated(), torch.cuda.memory_reserved()))
    assert taken[0] == taken[1]


def test_the_papers_scale_is_recorded_and_learns(hyper, a_plan, replay):
    made = LBSDreamer(hyper("paper"), 0, "cuda", a_plan())
    losses = [learn(made, replay(steps=80), 20)["model_loss"] for _ in range(2)]
    assert losses[1] < losses[0]


@pytest.mark.parametrize("room", [0, 30, 1000], ids=["none", "one", "all"])
def test_a_batch_on_the_gpu_is_what_the_host_samples(replay, room):
    store, rng = replay(), np.random.default_rng(5)
    frames = DeviceReplay(store, torch.device("cuda"), room * 64 * 64 * 3)
    frames.follow()
    kept = [frames.windows(*store.draw(6, 7, rng), 7) for _ in range(12)]
    rng = np.random.default_rng(5)
    for found in kept:
        assert found.is_cuda
        np.testing.assert_array_equal(found.transpose(0, 1).cpu(), store.sample(6, 7, rng)["image"])
