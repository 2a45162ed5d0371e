"""Planning: the search finds what trying every sequence by itself finds, and is all that acting then needs."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import torch
from traces import fingerprint, ignore, walk

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.planner import Planner, search
from curionav_cli.agents.lbs_dreamer.rssm import State
from curionav_cli.errors import WeightsRefused
from curionav_cli.options import Options
from curionav_cli.storage.replay import Replay

PLAN = {"behaviour": "plan", "options": "seven", "sequence_length": 3}


@pytest.fixture
def optional(replay):
    """optional(): a replay of options, on the frames of stripes."""
    def make():
        plain, text = replay(episodes=3, steps=40), [0, 0, 1, 1, 1, 0, 2, 2, 2, 2, 2, 2, 0, 0] * 3
        collided = np.array([0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1] * 3, bool)
        episodes = (replace(plain.episode(n), action=np.array(text[:40]), collided=collided[:40]) for n in range(3))
        return Replay(episodes, every=Options())
    return make


def state_of(networks, seed=0):
    generator = torch.Generator().manual_seed(seed)
    rssm = networks.world_model.rssm
    drawn = torch.randn(1, rssm.deter, generator=generator), torch.randint(2, (1, rssm.stoch), generator=generator)
    return State(drawn[0], drawn[1].float())


@pytest.mark.parametrize("name", list(lbs_settings.Curiosity))
@pytest.mark.parametrize(("depth", "options"), [(1, "seven"), (2, "seven"), (3, "none")])
def test_the_search_is_that_of_every_sequence_by_itself(tiny, networks, name, depth, options):
    made = networks(tiny(curiosity=name, options=options))
    rssm, start, noise = made.world_model.rssm, state_of(made), torch.rand(depth, 5, 4)
    best = {}
    with torch.no_grad():
        for sequence in product(range(rssm.actions), repeat=depth):
            state, value = State(*(part.repeat(5, 1) for part in start)), 0.0
            for step, action in enumerate(sequence):
                taken = torch.full((5,), action)
                after = rssm.imagine(state, rssm.action_input(taken), noise[step])
                imagined = Imagined(torch.stack([state.features, after.features]), taken[None])
                value += 0.9**step * float(made.curiosity.intrinsic_reward(imagined)[1].mean())
                state = after
            best[sequence[0]] = max(value, best.get(sequence[0], -np.inf))
    found = search(rssm, made.curiosity, start, noise, 0.9)
    assert found.shape == (rssm.actions,) and rssm.actions == (7 if options == "seven" else 3)
    np.testing.assert_allclose(found, [best[action] for action in range(rssm.actions)], rtol=1e-4, atol=1e-6)


def test_the_temperature_is_a_share_of_the_mean_value(tiny, networks):
    hyper = tiny(plan_temperature=0.5, **PLAN)
    made = networks(hyper)
    planner, noise = Planner(made, hyper), torch.rand(2, 8, 4)
    value = search(planner.rssm, planner.curiosity, state_of(made), noise, hyper.gamma)
    torch.testing.assert_close(planner.logits(state_of(made), noise), (value / (0.5 * value.abs().mean()))[None])


def test_without_a_reward_all_options_are_alike(tiny, networks):
    hyper = tiny(curiosity="none", **PLAN)
    made = networks(hyper)
    assert Planner(made, hyper).logits(state_of(made), torch.rand(2, 8, 4)).tolist() == [[0.0] * 7]


def test_a_planner_learns_its_model_and_no_actor(agent, optional):
    made, store = agent(**PLAN), optional()
    before = {name: tensor.clone() for name, tensor in made.learner.networks.state_dict().items()}
    metrics = made.learn(store, 4, ignore)
    after = made.learner.networks.state_dict()
    still = {name for name in after if torch.equal(before[name], after[name])}
    assert {name.partition(".")[0] for name in after.keys() - still} == {"world_model", "curiosity"}
    assert {name for name in after if name.startswith("behaviour.")} <= still
    assert not any("actor" in name or "critic" in name or "imagined" in name for name in metrics)
    assert metrics["updates"] == 4 and made.learner.behaviour_updates == 0


def test_an_actor_over_options_learns_too(agent, optional):
    made = agent(options="seven", sequence_length=3)
    metrics = made.learn(optional(), 2, ignore)
    assert [name for name in metrics if name.startswith("imagined_")] == [f"imagined_{name}" for name in Options.names]
    assert sum(metrics[f"imagined_{name}"] for name in Options.names) == pytest.approx(1)


def walked(made, episode):
    """Actions on the images of an episode in which every fifth forward move is cut short."""
    made.begin()
    actions, info = [], {"episode_index": 0, "collided": False}
    for step, image in enumerate(episode.image):
        actions.append(made.act({"image": image}, info))
        info = {**info, "collided": actions[-1] == 0 and step % 5 == 0}
    return actions


def test_same_seed_same_bytes_and_what_it_did_can_be_read(agent, optional, replay):
    walks = []
    for seed in (0, 0, 1):
        made = agent(seed, **PLAN)
        made.learn(optional(), 2, ignore)
        walks.append((walked(made, replay().episode(0)), fingerprint(made)))
    assert walks[0] == walks[1] and walks[0][1] != walks[2][1]
    assert 0 <= made.report()["plan_entropy"] <= np.log(7) + 1e-6
    made.begin()
    assert made.report() == {} == agent(0).report()
    collided = np.array([action == 0 and step % 5 == 0 for step, action in enumerate(walks[0][0])])
    assert len(Options().decisions(np.array(walks[0][0]), collided).action) > 1


def test_planning_needs_no_options(agent, replay):
    made = agent(behaviour="plan", action_repeat=2)
    assert set(walk(made, replay().episode(0))) <= {0, 1, 2}


def test_a_robot_that_plans_gets_the_curiosity_and_no_actor(agent, optional, replay):
    learned, robot = agent(**PLAN), agent(**PLAN)
    learned.learn(optional(), 3, ignore)
    robot.import_weights(learned.export_weights())
    assert {name.partition(".")[0] for name in robot.acting_weights()} == {"world_model", "curiosity"}
    assert robot.export_weights() == learned.export_weights()
    assert walked(robot, replay().episode(1)) == walked(learned, replay().episode(1))
    with torch.no_grad():
        for tensor in learned.learner.networks.curiosity.parameters():
            tensor.fill_(3e38)
    before = fingerprint(robot)
    with pytest.raises(WeightsRefused, match="no finite numbers for an image"):
        robot.import_weights(learned.export_weights())
    assert fingerprint(robot) == before
