"""Our C-BET against numbers that the released code made of the same inputs (docs/fidelity.md).

Inputs are drawn here. What the released code made of them stands in tests/agents/fixtures/cbet.json.
"""

from types import SimpleNamespace

import numpy as np
import pytest
import torch
from originals import Draw
from torch import nn

from curionav_cli.agents.cbet.learner import Learner
from curionav_cli.agents.cbet.network import Memory, PolicyNetwork
from curionav_cli.agents.cbet.rewards.cbet import CBET
from curionav_cli.agents.cbet.rewards.reward import RewardContext
from curionav_cli.agents.cbet.rms import RunningRMS
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.cbet.unrolls import Batch
from curionav_cli.agents.cbet.vtrace import vtrace
from curionav_cli.agents.image_hash import SignKeys
from curionav_cli.records import Episode

T, B, FEATURES = 6, 3, 5
SETTINGS = {"lr": 0.01, "clip": 0.4, "entropy": 0.1, "coefficient": {"cbet": 2.5}}


@pytest.fixture
def theirs(original):
    return lambda case: original("cbet", case)


def close(ours, stored):
    torch.testing.assert_close(ours.detach().double(), stored, atol=2e-6, rtol=2e-5)


def chosen(logits, action):
    return logits.log_softmax(-1).gather(-1, action[..., None]).squeeze(-1)


def vtrace_inputs():
    """Logits of the behaviour and of the policy, actions, rewards, discounts with one end, values."""
    draw = Draw(1)
    discount = torch.full((T, B), 0.99, dtype=torch.float64)
    discount[3, 1] = 0
    return (draw.uniform(T, B, 3), draw.uniform(T, B, 3), draw.integers(3, T, B), draw.uniform(T, B), discount,
            draw.uniform(T + 1, B))


def test_vtrace(theirs):
    behaviour, policy, action, reward, discount, value = vtrace_inputs()
    ratio = (chosen(policy, action) - chosen(behaviour, action)).exp()
    assert ratio.min() < 1 < ratio.max()
    target, advantage = vtrace(ratio, reward, discount, value)
    close(target, theirs("vtrace")["target"])
    close(advantage, theirs("vtrace")["advantage"])


class Linear(nn.Module):
    """A policy whose pictures are features already."""

    def __init__(self):
        super().__init__()
        self.policy, self.value = nn.Linear(FEATURES, 3), nn.Linear(FEATURES, 1)

    def unroll(self, image, frame, memory, respawned):
        seen = image[frame]
        return self.policy(seen[:-1]), self.value(seen).squeeze(-1)


def update_inputs():
    """A policy, and features, logits of the behaviour, actions and counts of two updates."""
    draw = Draw(2)
    return draw.fill(Linear()), [
        (draw.uniform(T + 1, B, FEATURES).float(), draw.uniform(T, B, 3).float(), draw.integers(3, T, B),
         draw.integers(4, T, B) + 2) for _ in range(2)]


def test_two_updates(theirs, hyper):
    """Losses, and weights after RMSprop: the first reward is clipped, so are the gradients."""
    policy, updates = update_inputs()
    networks = SimpleNamespace(policy=policy, reward={}, rms=RunningRMS(0.9))
    none = SimpleNamespace(learned_bonus=lambda batch: (torch.ones_like(batch.bonus), torch.zeros(())))
    learner = Learner(hyper("paper", **SETTINGS), networks, none)
    for number, (features, behaviour, action, counts) in enumerate(updates):
        frame = torch.arange((T + 1) * B).view(T + 1, B)
        batch = Batch(features.flatten(0, 1), frame, action, chosen(behaviour, action), 1 / counts, torch.zeros(T, B),
                      *[torch.zeros(1)] * 3)
        metrics = learner.update(batch)
        close(metrics["policy_loss"], theirs("update")["policy_loss"][number])
        close(0.5 * metrics["value_loss"], theirs("update")["value_loss"][number])
        close(-SETTINGS["entropy"] * T * metrics["entropy"], theirs("update")["entropy_loss"][number])
        assert metrics["policy_norm"] > SETTINGS["clip"] and metrics["reward_clipped"] > 0
        close(torch.cat([p.flatten() for p in policy.parameters()]), theirs("update")["weights"][number])


def network_inputs(settings):
    """The published network, three frames of two environments, a memory, and who is put back before the last."""
    draw = Draw(3)
    network = draw.fill(PolicyNetwork(settings), scale=0.05)
    memory = Memory(draw.uniform(2, 2, 1024).float(), draw.uniform(2, 2, 1024).float())
    return network, draw.image(3, 2), memory, torch.tensor([False, True])


def test_the_network_of_18_million_weights(theirs, hyper):
    """The released one swaps rows and columns of a picture, so it is shown the mirrored one here."""
    network, image, memory, respawned = network_inputs(hyper("paper"))
    with torch.no_grad():
        frame = torch.arange(6).view(3, 2)
        logits, value = network.unroll(image.transpose(2, 3).flatten(0, 1), frame, memory, respawned)
    close(logits, theirs("network")["logits"])
    close(value, theirs("network")["value"])


def key_inputs():
    """Projections, and differences of pictures modulo 256, the last of them none."""
    draw = Draw(4)
    pictures = draw.image(6).numpy()
    changes = (pictures[1:] - pictures[:-1]).reshape(5, -1)
    return SignKeys(12288, 16, np.random.default_rng(0)), 2 * draw.integers(2, 12288, 16) - 1, np.append(
        changes, np.zeros((1, 12288), np.uint8), axis=0)


def test_a_digit_of_a_key_is_the_sign_of_a_projection(theirs):
    """The released digit, of tanh(a x) + b beyond +-0.5, is another name for it; of a sum of zero it is b's."""
    keys, signs, changes = key_inputs()
    keys.signs = signs.numpy().astype(np.float32)
    ours, digits = np.sign(keys.sums(changes)), theirs("keys")["digits"].numpy()
    some = slice(0, 5)
    assert (ours[some] != 0).all() and 0 < (ours[some] > 0).mean() < 1
    assert ((ours[some, None] == ours[None, some]) == (digits[some, None] == digits[None, some])).all()
    assert not ours[5].any() and set(digits[5]) == {-1, 0, 1}


def walk_inputs():
    """Which of five pictures each of 20 frames shows, and the pictures."""
    draw = Draw(5)
    return draw.integers(5, 20).numpy(), draw.image(5).numpy()


@pytest.fixture
def rewarded(hyper):
    """rewarded(extra): our rewards of the walk, the first picture counted `extra` times more."""
    def make(extra):
        shown, pictures = walk_inputs()
        settings = hyper("paper", view="ego", reset="never")
        reward = CBET(RewardContext(settings, None, "numpy", 0, 5), nn.ModuleDict())
        image = pictures[np.append(shown, shown[0])]
        episode = Episode(image, np.zeros(20, np.int64), np.zeros((21, 3)), np.zeros(20, bool))
        for _ in range(extra):
            reward.counts["states"].add(0, reward.state_keys(image[:1])[0])
        return reward.episode_bonus(Transitions(episode, 0, 0))[0], shown
    return make


def test_rewards_are_the_released_ones_but_for_a_second_count_where_an_unroll_begins(theirs, rewarded):
    stored = theirs("rewards")["bonus"].numpy()
    assert rewarded(1)[0] == pytest.approx(stored, rel=1e-6)
    bonus, shown = rewarded(0)
    again = np.append(shown[1:], shown[0]) == shown[0]
    assert ((bonus > stored * (1 + 1e-6)) == again).all() and 1 < again.sum() < 20
