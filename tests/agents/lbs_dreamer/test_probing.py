"""A world model on a probe: the numbers are those of the definition, and the agent is left as it was."""

import numpy as np
import pytest
import torch
from torch.distributions import Categorical, kl_divergence

from curionav_cli.agents.baselines import Random
from curionav_cli.agents.lbs_dreamer import probing
from curionav_cli.constants import FORWARD, STEP_LENGTH, Stream
from curionav_cli.probe import CONTEXT, Probe


@pytest.fixture
def probe(replay):
    """Six sequences of nine actions."""
    episodes = replay(6, 9)
    image, action = (np.stack([getattr(episodes.episode(n), key) for n in range(6)]) for key in ("image", "action"))
    pose = np.zeros((6, 10, 3))
    pose[..., 0] = STEP_LENGTH * np.arange(10)
    pose[0, 7:] = pose[0, 6]  # what leads to frame 7 and later of the first sequence does not move
    action[0, 6] = FORWARD
    return Probe(image, action, pose, 1)


def test_the_error_is_that_of_the_definition(agent, probe, monkeypatch):
    made = agent()
    monkeypatch.setattr(made.learner.networks.world_model, "predict",
                        lambda frames, *rest: torch.full_like(frames, 51))
    seen = made.probe(probe)
    truth = probe.image[:, CONTEXT:] / 255
    np.testing.assert_allclose(seen.error, ((truth - 0.2) ** 2).mean((2, 3, 4)), rtol=1e-5)
    last = probe.image[:, CONTEXT - 1:CONTEXT] / 255
    np.testing.assert_allclose(seen.repeat, ((truth - last) ** 2).mean((2, 3, 4)), rtol=1e-5, atol=1e-9)
    assert seen.error.shape == seen.repeat.shape == seen.surprise.shape == (6, 5)
    free = np.ones((6, 5), bool)
    free[0, 7 - CONTEXT:] = False
    assert seen.metrics() == {"probe_error": pytest.approx(seen.error.mean()),
                              "probe_error_free": pytest.approx(seen.error[free].mean()),
                              "probe_repeat": pytest.approx(seen.repeat.mean()),
                              "probe_surprise": pytest.approx(seen.surprise.mean())}


def test_the_surprise_is_the_divergence_of_posterior_and_prior_step_by_step(agent, probe):
    made = agent()
    model, rssm = made.learner.networks.world_model, made.learner.networks.world_model.rssm
    noise = torch.from_numpy(np.random.default_rng(Stream.probe_latents).random((10, 6, rssm.latents), np.float32))
    state, action = rssm.initial(6), torch.full((6,), -1)
    for frame in range(10):
        embed = model.encoder(model.patches(torch.from_numpy(probe.image[:, frame])))
        prior = rssm.prior(rssm.recur(state, rssm.action_input(action)))
        state, posterior = rssm.filter(state, rssm.action_input(action), rssm.embed_input(embed), noise[frame])
        action = torch.from_numpy(probe.action[:, min(frame, 8)])
    by_hand = kl_divergence(Categorical(logits=posterior), Categorical(logits=prior)).sum(-1)
    np.testing.assert_allclose(made.probe(probe).surprise[:, -1], by_hand.detach().numpy(), rtol=1e-4)


def test_it_is_the_same_again_and_falls_by_learning(agent, probe, replay):
    made = agent(model_lr=1e-2)
    first, again = made.probe(probe), made.probe(probe)
    for key, values in vars(first).items():
        np.testing.assert_array_equal(values, getattr(again, key))
    made.learn(replay(6, 20), 30, lambda i: None)
    assert made.probe(probe).error.mean() < first.error.mean()


def test_a_few_sequences_at_once_are_as_good_as_all(agent, probe, monkeypatch):
    made = agent()
    whole = made.probe(probe)
    monkeypatch.setattr(probing, "AT_ONCE", 2)
    parts = made.probe(probe)
    np.testing.assert_array_equal(parts.repeat, whole.repeat)
    assert parts.error.shape == whole.error.shape and parts.error.mean() == pytest.approx(whole.error.mean(), rel=0.1)


def test_nothing_changes_in_the_agent(agent, probe, replay, tmp_path):
    """Neither weights nor random numbers, nor what it does next, in the middle of an episode too."""
    plain, probed = agent(), agent()
    observation, info = {"image": probe.image[0, 0]}, {"episode_index": 0}
    torch_state, numpy_state = torch.get_rng_state(), np.random.get_state()[1].tolist()  # noqa: NPY002
    acted = []
    for made in (plain, probed):
        made.learn(replay(), 2, lambda i: None)
        made.begin()
        acted.append([])
        for _ in range(4):
            acted[-1].append(made.act(observation, info))
            if made is probed:
                made.probe(probe)
    assert acted[0] == acted[1]
    assert torch.equal(torch_state, torch.get_rng_state())
    assert numpy_state == np.random.get_state()[1].tolist()  # noqa: NPY002
    for name, made in (("plain", plain), ("probed", probed)):
        (tmp_path / name).mkdir()
        made.learn(replay(), 2, lambda i: None)
        made.save(tmp_path / name)
    for file in (tmp_path / "plain").iterdir():
        assert file.read_bytes() == (tmp_path / "probed" / file.name).read_bytes(), file.name


def test_an_agent_without_a_model_has_nothing_to_measure(probe):
    assert not Random.has_model and Random(0).probe(probe) is None
