"""Recorded updates are the same to the bit as eager ones; on a GPU, within rounding."""

from functools import partial

import pytest
import torch
from tape import tape

from curionav_cli.agents.lbs_dreamer import agent as agent_module
from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.checkpoint import load_learner, save_learner
from curionav_cli.agents.lbs_dreamer.compile import fuse
from curionav_cli.agents.lbs_dreamer.kernels.cuda_graphs import Recorded
from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser
from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.agents.meter import Meter
from curionav_cli.errors import RunFailed

CPU = torch.device("cpu")


@pytest.fixture
def learner(tiny, networks):
    """learner(record, **changes)"""
    def make(*record, **changes):
        settings = tiny(**changes)
        return Learner(settings, networks(settings), torch.Generator().manual_seed(1), *record)
    return make


def everything(learner):
    """Weights, buffers, Adam's state and the generator's, by name."""
    moments = {f"{name}/{path}": tensor for name, optimiser in learner.optimisers.items()
               for path, tensor in optimiser.state().items()}
    found = {**learner.networks.state_dict(), **moments, "generator": learner.generator.get_state()}
    return {name: tensor.clone() for name, tensor in found.items()}


def train(learner, data, updates):
    meter = Meter()
    for _ in range(updates):
        meter.add(learner.update(data))
    return meter.read()


def assert_same(left, right):
    left, right = everything(left), everything(right)
    assert [name for name in left if not torch.equal(left[name], right[name])] == []


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
def test_recorded_updates_are_eager_ones_to_the_bit(learner, data, precision, tmp_path):
    eager = learner(precision=precision)
    recorded = learner(partial(Recorded, tape, CPU), precision=precision)
    assert train(eager, data, 13) == train(recorded, data, 13)
    save_learner(recorded, tmp_path)
    for made in (recorded, learner(partial(Recorded, tape, CPU), precision=precision)):
        train(made, data, 2)  # a load must reach what was recorded
        load_learner(made, tmp_path)
        meters = train(made, data, 14)
    assert meters == train(eager, data, 14)
    assert recorded.behaviour_updates == eager.behaviour_updates == 14
    assert_same(eager, recorded)
    assert_same(eager, made)


@pytest.mark.parametrize("curiosity", [kind.value for kind in lbs_settings.Curiosity])
def test_a_recorded_agent_acts_and_learns_as_an_eager_one(agent, replay, monkeypatch, curiosity):
    monkeypatch.setattr(agent_module, "fuse_on", lambda *_: None)  # the tape sees torch's operations only
    store, eager = replay(), agent(curiosity=curiosity)
    monkeypatch.setattr(agent_module, "recorder", lambda *_: partial(Recorded, tape, CPU))
    recorded = agent(curiosity=curiosity)
    for _ in range(2):
        assert walk(recorded, store) == walk(eager, store)
        assert recorded.learn(store, 5, lambda done: None) == eager.learn(store, 5, lambda done: None)
    assert_same(eager.learner, recorded.learner)


@pytest.mark.parametrize("curiosity", ["lbs", "disagreement"])
def test_a_recorded_planner_acts_as_an_eager_one(agent, replay, monkeypatch, curiosity):
    store, plans = replay(), {"curiosity": curiosity, "behaviour": "plan"}
    eager = agent(**plans)
    monkeypatch.setattr(agent_module, "recorder", lambda *_: partial(Recorded, tape, CPU))
    recorded = agent(**plans)
    for _ in range(2):
        assert walk(recorded, store) == walk(eager, store) and recorded.report() == eager.report() != {}
        assert recorded.learn(store, 3, lambda done: None) == eager.learn(store, 3, lambda done: None)


def walk(agent, replay):
    """Two episodes: the second must start afresh."""
    actions = []
    for episode in (replay.episode(0), replay.episode(1)):
        agent.begin()
        actions += [agent.act({"image": image}, {"episode_index": 0}) for image in episode.image]
    return actions


def test_inputs_of_another_shape_or_kind_are_refused(learner, data):
    made = learner(partial(Recorded, tape, CPU))
    made.update(data)
    made.update(data)
    with pytest.raises(AssertionError):
        made.update(Sequences(*(tensor[..., :1] for tensor in data[:3])))
    with pytest.raises(AssertionError):
        made.update(data._replace(action=data.action.int()))


def test_what_cannot_be_recorded_ends_the_run_and_names_the_way_out(learner, data):
    def broken(function, state):
        raise RuntimeError("CUDA error: operation not permitted when stream is capturing\nCompile with ...")

    with pytest.raises(RunFailed, match=r"operation not permitted when stream is capturing .*compile=none without"):
        learner(partial(Recorded, broken, CPU)).update(data)


def test_an_update_that_asks_the_device_is_found_out(learner, data, monkeypatch):
    """The tape notices what a CUDA graph could not record."""
    made = learner(partial(Recorded, tape, CPU))
    step = Optimiser.step
    monkeypatch.setattr(Optimiser, "step", lambda self, loss: step(self, loss) if loss.item() else loss)
    with pytest.raises(AssertionError, match="the host waits for the device"):
        made.update(data)


@pytest.mark.parametrize("imagines", [True, False])
def test_an_update_stays_on_its_device(learner, data, imagines):
    """On torch's meta device, which has no numbers: what mixes devices or asks for a value fails there."""
    made = learner()
    noise = made.draw(data.action.shape, imagines)
    meta = torch.device("meta")
    bare = Learner(made.hyper, made.networks.to(meta), torch.Generator())
    scalars = bare.compute(*(type(group)(*(None if tensor is None else tensor.to(meta) for tensor in group))
                             for group in (data, noise)))
    assert {tensor.device for tensor in scalars.values()} == {meta}


@pytest.mark.parametrize("precision, apart", [("float32", 1e-4), ("bfloat16", 5e-3)])
def test_fused_steps_learn_what_plain_ones_do(learner, data, precision, apart):
    """By the way that torch.compile takes on a GPU too, but for the kernels that it writes there."""
    plain, fused = learner(precision=precision), learner(precision=precision)
    fuse(fused.networks.world_model.rssm, "aot_eager")
    left, right = train(plain, data, 4), train(fused, data, 4)
    for name in left:
        assert right[name] == pytest.approx(left[name], rel=apart, abs=apart), name
    left, right = (made.networks.state_dict() for made in (plain, fused))
    for name in left:
        torch.testing.assert_close(right[name], left[name], rtol=0, atol=apart)


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # torch's compiler has some of its own
def test_fused_by_the_compiler_itself(learner, data):
    plain, fused = learner(), learner()
    fuse(fused.networks.world_model.rssm)
    left, right = train(plain, data, 3), train(fused, data, 3)
    for name in left:
        assert right[name] == pytest.approx(left[name], rel=1e-4, abs=1e-4), name
