"""The agent by its contract: acting, learning, exporting weights; the same seed gives the same bytes."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
import torch
from traces import fingerprint, ignore, walk

from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.decisions import Steps
from curionav_cli.errors import ConfigError, RunFailed, WeightsRefused


def test_it_acts_and_learns(agent, replay):
    made, store, done = agent(), replay(), []
    metrics = made.learn(store, 4, done.append)
    assert done == [1, 2, 3, 4]
    assert (metrics["updates"], metrics["frames_replayed"]) == (4, 4 * 3 * 8)
    assert {"model_loss", "image_loss", "kl", "curiosity_target", "curiosity_reward", "actor_entropy", "critic_value",
            "model_norm", "curiosity_norm", "actor_norm", "critic_norm"} <= metrics.keys()
    assert all(type(value) is float and np.isfinite(value) for value in metrics.values())
    actions = walk(made, store.episode(0))
    assert set(actions) <= {0, 1, 2} and all(type(action) is int for action in actions)


def test_no_iterations_change_nothing(agent, replay):
    made = agent()
    before = fingerprint(made)
    assert made.learn(replay(), 0, ignore) == {}
    assert fingerprint(made) == before


def test_same_seed_same_bytes_other_seed_other_bytes(agent, replay):
    prints = []
    for seed in (0, 0, 1):
        torch.manual_seed(len(prints))  # the global generator must not matter
        made = agent(seed)
        walk(made, replay().episode(0))
        made.learn(replay(), 3, ignore)
        prints.append((fingerprint(made), tuple(walk(made, replay().episode(1)))))
    assert prints[0] == prints[1] and prints[0][0] != prints[2][0]


def test_acting_is_filtering_with_the_same_noise(agent, replay):
    made, episode = agent(), replay().episode(0)
    noise = torch.rand(len(episode) + 1, 1, 5, generator=torch.Generator().manual_seed(3))
    draws = iter(noise)
    torch_rand, torch.rand = torch.rand, lambda *shape, **kw: next(draws)
    try:
        actions, states = [], []
        made.begin()
        for image in episode.image:
            actions.append(made.act({"image": image}, {"episode_index": 0}))
            states.append(made.state)
    finally:
        torch.rand = torch_rand
    model = made.learner.networks.world_model
    led_to = torch.tensor([-1, *actions[:-1]])[:, None]
    patches = model.patches(torch.from_numpy(episode.image))
    seen = model.observe(model.rssm.initial(1), patches, led_to, noise[..., :4])
    torch.testing.assert_close(torch.stack([state.deter for state in states]), seen.states.deter)
    assert (torch.stack([state.stoch for state in states]) == seen.states.stoch).all()


def test_an_episode_starts_afresh(agent, replay):
    made, episode = agent(), replay().episode(0)
    assert walk(made, episode) == walk(made, episode)


def test_what_acting_draws_depends_on_seed_and_episode_and_on_no_learning(agent, replay):
    """So that a robot acts as the learner itself would have, however far the two are apart."""
    made, store = agent(), replay()
    made.learner.generator.set_state(torch.Generator().manual_seed(9).get_state())
    with torch.no_grad():
        for parameter in (one := agent()).learner.networks.parameters():
            parameter.zero_()  # a uniform policy: its actions are what was drawn
    one.learn(store, 0, ignore)
    walks = []
    for index in (0, 0, 1):
        one.begin()
        walks.append([one.act({"image": image}, {"episode_index": index}) for image in store.episode(0).image])
    assert walks[0] == walks[1] != walks[2]
    before = fingerprint(made)
    walk(made, store.episode(0))
    assert fingerprint(made) == before


def test_shared_weights_make_another_agent_act_alike(agent, replay):
    learned, robot, store = agent(), agent(), replay()
    learned.learn(store, 3, ignore)
    assert robot.export_weights() != learned.export_weights()
    robot.import_weights(learned.export_weights())
    assert robot.export_weights() == learned.export_weights() and len(learned.export_weights()) < 0.6 * sum(
        tensor.nbytes for tensor in learned.learner.networks.state_dict().values())
    assert walk(robot, store.episode(1)) == walk(learned, store.episode(1))


def spoilt(agent, harm):
    """What a robot should not act with."""
    if harm == "nan":
        next(iter(agent.acting_weights().values())).view(-1)[-1] = torch.nan
    if harm == "huge":
        for tensor in agent.acting_weights().values():
            tensor.fill_(3e38)
    raw = agent.export_weights()
    return {"torn": raw[:-9], "empty": b"", "pickle": pickle.dumps({"a": 1})}.get(harm, raw)


@pytest.mark.parametrize(("harm", "said"), [
    ("nan", "holds numbers that are not finite"), ("huge", "no finite numbers for an image"),
    ("torn", "no whole safetensors file"), ("empty", "no whole safetensors file"),
    ("pickle", "no whole safetensors file"), ("foreign", r"is float32 \(.* there and float32 \(.* here"),
])
def test_weights_that_cannot_act_are_refused_and_change_nothing(agent, harm, said):
    robot = agent()
    before = fingerprint(robot)
    with pytest.raises(WeightsRefused, match=said):
        robot.import_weights(spoilt(agent(gru_units=24) if harm == "foreign" else agent(), harm))
    assert fingerprint(robot) == before


def test_episodes_that_are_too_short_are_named_with_the_cure(agent, replay):
    with pytest.raises(ConfigError, match=r"loop\.steps must be at least 7"):
        agent().learn(replay(steps=6), 1, ignore)
    agent().learn(replay(steps=7), 1, ignore)


def test_a_loss_that_is_not_finite_ends_the_run(agent, replay):
    made = agent()
    with torch.no_grad():
        made.learner.networks.world_model.decoder.dense.bias.fill_(torch.nan)
    with pytest.raises(RunFailed, match=r"training diverged: .*model_loss.* not finite after 2 updates"):
        made.learn(replay(), 2, ignore)


def test_a_wild_input_stays_finite(agent):
    """Logits of ten thousand: softmax, KL and returns must not overflow."""
    made = agent()
    with torch.no_grad():
        for parameter in made.learner.networks.world_model.rssm.parameters():
            parameter.mul_(1e4)
    white = torch.full((8, 3, 64, 64, 3), 255, dtype=torch.uint8)
    data = Sequences(white, torch.zeros(8, 3, dtype=torch.int64), torch.zeros(3, dtype=torch.bool))
    assert all(torch.isfinite(value).all() for value in made.learner.update(data).values())


def test_bfloat16_is_what_the_setting_says_and_close_to_float32(agent, replay):
    learned = {}
    for precision in ("float32", "bfloat16"):
        one = agent(precision=precision)
        seen = []
        one.learner.networks.world_model.encoder.register_forward_hook(lambda *call, s=seen: s.append(call[2].dtype))
        learned[precision] = one.learn(replay(), 1, lambda i: None)
        assert seen[0] == getattr(torch, precision)
    # Beside 2^-8 float32 is exact. Eight layers from frame to logits round three times each (inputs, weights, sums),
    # independently of each other; a divergence is of second order in what that changes.
    near = 2 * 2.0**-8 * (3 * 8)**0.5
    for name in ("model_loss", "curiosity_target", "kl"):
        assert learned["bfloat16"][name] == pytest.approx(learned["float32"][name], rel=near)


def test_an_action_is_held_and_what_comes_in_between_is_not_seen(agent, replay):
    episode = replay(1, 20).episode(0)
    held, seen = agent(action_repeat=3), replace(episode, image=episode.image[::3])
    other = replace(episode, image=episode.image.copy())
    other.image[1::3] = other.image[2::3] = 0
    assert walk(held, episode) == np.repeat(walk(agent(), seen), 3).tolist() == walk(held, other)
    assert held.every == Steps(3) and agent().every == Steps(1)
