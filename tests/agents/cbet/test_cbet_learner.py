"""One update: on-policy ratios, how losses are reduced, scale, and the rewards that learn beside the policy."""

import dataclasses

import numpy as np
import pytest
import torch
import torch.nn.functional as F
from torch import nn

from curionav_cli.agents.cbet.learner import Learner, build_networks
from curionav_cli.agents.cbet.rewards.choose import reward_class
from curionav_cli.agents.cbet.rewards.reward import RewardContext
from curionav_cli.agents.cbet.rms import RunningRMS
from curionav_cli.agents.cbet.settings import Reward
from curionav_cli.agents.cbet.unrolls import Batch, stack_unrolls


@pytest.fixture
def learner(small_room):
    def make(hyper, seed=0):
        networks = build_networks(hyper, torch.Generator().manual_seed(seed), torch.device("cpu"))
        context = RewardContext(hyper, small_room, "numpy", 0, 5)
        return Learner(hyper, networks, reward_class(hyper.reward)(context, networks.reward))
    return make


@pytest.fixture
def batch():
    """T = 5, B = 4, for the tiny network; log mu as of a policy near the uniform one."""
    rng = np.random.default_rng(0)
    tensors = (rng.integers(0, 256, (24, 64, 64, 3), np.uint8), np.arange(24).reshape(6, 4), rng.integers(0, 3, (5, 4)),
               rng.normal(-1.1, 0.1, (5, 4)), rng.random((5, 4)) / 2, rng.integers(0, 3, (5, 4)),
               rng.normal(size=(2, 4, 6)) / 3, rng.normal(size=(2, 4, 6)) / 3, np.array([True, False, False, True]))
    return Batch(*(torch.from_numpy(part.astype(np.float32) if part.dtype == float else part) for part in tensors))


@pytest.mark.parametrize("shifted", [False, True])
def test_the_first_pass_is_on_policy(agent, room, shifted):
    """Two episodes of two unrolls. It also says that frames, actions and memories belong stack_unrolls."""
    made, place = agent(view="ego", batch_size=4), room()
    with torch.no_grad():
        made.learner.networks.policy.policy.weight.mul_(20)
    place.run(made, 1)
    image = place.episode(made).image
    if shifted:
        image[:-1] = image[1:].copy()
    row = made.learn(place.replay, 1, lambda done: None)
    assert row["updates"] == 1 and (row["ratio_off_one"] > 1e-4) == shifted
    assert shifted or row["ratio_off_one"] < 1e-5


def test_losses_are_summed_over_time_and_averaged_over_unrolls(tiny, learner, batch):
    made = learner(tiny(reward="motion"))
    reward = torch.rand(5, 4)
    whole, _ = made.policy_loss(batch, reward)
    pick = lambda b: Batch(batch.image, *(part[b:b + 1] if part.dim() == 1 else part[:, b:b + 1] for part in batch[1:]))
    single = [made.policy_loss(pick(b), reward[:, b:b + 1])[0] for b in range(4)]
    torch.testing.assert_close(whole, torch.stack(single).mean())


def test_entropy_lowers_the_loss_and_value_errors_raise_it(tiny, learner, batch):
    def loss(**changes):
        return learner(tiny(reward="motion", **{"entropy": 0.0, "value_cost": 0.0, **changes})).policy_loss(
            batch, torch.rand(5, 4, generator=torch.Generator().manual_seed(0)))
    plain, metrics = loss()
    torch.testing.assert_close(plain, metrics["policy_loss"])
    torch.testing.assert_close(loss(entropy=0.3)[0], plain - 0.3 * 5 * metrics["entropy"])
    torch.testing.assert_close(loss(value_cost=0.3)[0], plain + 0.3 * metrics["value_loss"])
    assert 0 < metrics["entropy"] <= np.log(3) and metrics["value_loss"] > 0


def test_scales_of_reward_entropy_epsilon_and_clip_go_together(tiny, learner, batch):
    """From a value head of zeros; afterwards the squared value loss makes the larger one learn values faster."""
    weights = []
    for scale in (1.0, 10.0):
        coefficient = {"motion": 0.1 * scale}
        made = learner(tiny(reward="motion", coefficient=coefficient, entropy=0.01 * scale,
                            rmsprop_epsilon=1e-3 * scale, clip=0.3 * scale))
        with torch.no_grad():
            made.networks.policy.value.weight.zero_()
        made.update(batch)
        weights.append(torch.cat([weight.detach().flatten() for weight in made.networks.policy.parameters()]))
    torch.testing.assert_close(*weights, atol=1e-6, rtol=1e-4)


def test_rewards_are_scaled_clipped_and_told_apart_by_kind(tiny, learner, batch):
    made = learner(tiny(reward="motion", coefficient={"motion": 3.0}, reward_clip=0.6))
    reward, metrics = made.scaled(batch.bonus)
    torch.testing.assert_close(reward, (3 * batch.bonus).clamp(max=0.6))
    assert metrics["reward_clipped"] == (3 * batch.bonus > 0.6).float().mean()
    kinds = made.by_kind(batch.kind, batch.bonus)
    torch.testing.assert_close(kinds["reward_moved"], batch.bonus[batch.kind == 1].mean())
    assert made.by_kind(torch.zeros_like(batch.kind), batch.bonus).keys() == {"reward_turned"}


def test_rewards_that_fade_keep_their_size(tiny, learner, batch):
    made = learner(tiny("cbet_lifelong", reward="motion", coefficient={"motion": 1.0}))
    for fade in (1.0, 0.1, 0.01):
        for _ in range(120):
            reward, _ = made.scaled(fade * batch.bonus)
        assert reward.square().mean().sqrt() == pytest.approx(0.25, rel=0.05)
    assert not made.scaled(torch.zeros(5, 4))[0].any()


def test_the_running_size_is_that_of_what_was_seen():
    rms = RunningRMS(0.5)
    assert rms(torch.tensor([3.0, -4.0])) == pytest.approx(12.5**0.5)
    assert rms(torch.tensor([1.0, 1.0])) == pytest.approx(((0.25 * 12.5 + 0.5) / 0.75) ** 0.5)


class Means(nn.Module):
    """Features that can be worked out by hand: the mean red and the mean green of a picture."""

    def forward(self, image):
        return image.float().mean(dim=(1, 2))[:, :2]


@pytest.fixture
def predicting(tiny, small_room):
    """predicting(name): one of the rewards that learn, with features of two numbers."""
    def make(name):
        hyper = tiny(reward=name, rnd_loss=0.1, forward_loss=10.0, inverse_loss=0.5)
        generator = torch.Generator().manual_seed(0)
        forward, inverse = nn.Linear(5, 2), nn.Linear(4, 3)
        with torch.no_grad():
            for weight in (*forward.parameters(), *inverse.parameters()):
                weight.copy_(0.01 * torch.randn(weight.shape, generator=generator))
        networks = {"rnd": {"predictor": nn.Sequential(Means(), nn.Linear(2, 2)), "target": Means()}}.get(
            name, {"features": Means(), "dynamics": forward, "inverse": inverse})
        return reward_class(Reward(name))(RewardContext(hyper, small_room, "numpy", 0, 5), nn.ModuleDict(networks))
    return make


def test_rnd_is_a_distance_and_its_loss(predicting, batch):
    made = predicting("rnd")
    distance, loss = made.learned_bonus(batch)
    seen = Means()(batch.image[batch.frame[1:].flatten()])
    truth = (made.networks["predictor"][1](seen) - seen).square().sum(-1).sqrt().view(5, 4)
    torch.testing.assert_close(distance, truth.detach())
    torch.testing.assert_close(loss, 0.1 * truth.sum(0).mean())
    assert loss.requires_grad and not distance.requires_grad


@pytest.mark.parametrize("name", ["icm", "ride"])
def test_icm_and_ride_by_hand(predicting, batch, name):
    made = predicting(name)
    novelty, loss = made.learned_bonus(batch)
    seen = Means()(batch.image)[batch.frame]
    forward, inverse, total = made.networks["dynamics"], made.networks["inverse"], 0.0
    for t in range(5):
        for b in range(4):
            action = torch.eye(3)[batch.action[t, b]]
            error = (forward(torch.cat([seen[t, b], action])) - seen[t + 1, b]).norm()
            step = (seen[t + 1, b] - seen[t, b]).norm()
            torch.testing.assert_close(novelty[t, b], (error if name == "icm" else step).detach())
            guess = inverse(torch.cat([seen[t, b], seen[t + 1, b]]))
            total = total + 10 * error + 0.5 * F.cross_entropy(guess, batch.action[t, b])
    torch.testing.assert_close(loss, total / 4)


@pytest.mark.parametrize("name, learns", [("rnd", {"predictor"}), ("icm", {"features", "dynamics", "inverse"}),
                                          ("motion", set())])
def test_each_network_has_an_optimiser_and_learns(tiny, learner, batch, name, learns):
    made = learner(tiny(reward=name))
    assert made.optimisers.keys() == {"policy", *(f"reward_{part}" for part in learns)}
    before = {key: value.clone() for key, value in made.networks.state_dict().items()}
    metrics = made.update(batch)
    moved = {key.split(".")[1] for key, value in made.networks.state_dict().items()
             if key.startswith("reward.") and (value != before[key]).any()}
    assert moved == learns and made.updates == 1
    assert {f"{key}_norm" for key in made.optimisers} <= metrics.keys()


def test_rewards_with_counts_and_without(tiny, small_room, walk):
    def made(name):
        return reward_class(Reward(name))(RewardContext(tiny(reward=name), small_room, "numpy", 0, 5), nn.ModuleDict())

    rewards = {name: made(name) for name in ("count", "ride", "motion", "count_oracle", "rnd")}
    transitions = walk([0, 1, 2, 1, 2])
    bonus = {name: reward.episode_bonus(transitions)[0] for name, reward in rewards.items()}
    root, third = 2**-0.5, 3**-0.5
    assert bonus["count"] == pytest.approx([1, 1, root, root, 1]) == bonus["ride"]
    assert bonus["motion"].tolist() == [0.5, 0, 0, 0, 0] and bonus["rnd"].tolist() == [1] * 5
    assert bonus["count_oracle"] == pytest.approx([1, root, third, 0.5, 5**-0.5])
    assert rewards["count"].episode_bonus(transitions)[0] == pytest.approx([third, third, 0.5, 0.5, root])
    assert rewards["ride"].episode_bonus(transitions)[0] == pytest.approx(bonus["ride"])  # forgotten with the episode
    other = walk([0, 1, 2, 1, 2], environment=1)
    assert rewards["count"].episode_bonus(other)[0] == pytest.approx(bonus["count"])


def test_unrolls_side_by_side_are_time_first(agent, room):
    made, place = agent(view="ego", batch_size=99), room(steps=20)
    place.run(made, 2)
    batch, episode = stack_unrolls(made.waiting, torch.device("cpu")), place.replay.episode(1)
    image = batch.image[batch.frame]
    assert image.shape == (6, 8, 64, 64, 3) and batch.hidden.shape == (2, 8, 6)
    assert batch.respawned.tolist() == [False, False, False, True] * 2
    assert (image[:, 5].numpy() == episode.image[5:11]).all()
    assert (image[:5, 7].numpy() == episode.image[15:20]).all()
    assert (image[5, 7].numpy() == episode.image[0]).all()
    assert batch.action[:, 4].tolist() == episode.action[:5].tolist()
    assert not batch.hidden[:, 4].any() and batch.hidden[:, 5].any()


def test_equal_images_are_computed_once_and_give_the_same_update(agent, room, tiny, learner):
    """Against the same unrolls with every frame an image of its own: losses, and weights after RMSprop."""
    made, place = agent(view="ego", batch_size=99), room(steps=20)
    place.run(made, 1)
    batch = stack_unrolls(made.waiting, torch.device("cpu"))
    used = batch.frame.max() + 1
    assert used <= len(batch.image) < used + 8 and len(batch.image) % 8 == 0 and used < batch.frame.numel()
    assert len({image.numpy().tobytes() for image in batch.image[:used]}) == used
    apart = batch._replace(image=batch.image[batch.frame.flatten()],
                           frame=torch.arange(batch.frame.numel()).view_as(batch.frame))
    for reward in ("motion", "rnd", "ride"):
        one, other = (learner(tiny(reward=reward)) for _ in range(2))
        for _ in range(3):
            torch.testing.assert_close(one.update(batch), other.update(apart), rtol=1e-4, atol=1e-5)
        torch.testing.assert_close(one.networks.state_dict(), other.networks.state_dict(), rtol=1e-4, atol=1e-5)


def test_every_reward_is_one_file_and_one_name():
    classes = {reward_class(name) for name in Reward}
    assert len(classes) == len(Reward)


def test_a_reward_without_a_coefficient_is_used_as_it_is(tiny, learner):
    made = learner(dataclasses.replace(tiny(reward="motion", reward_clip=9.0), coefficient={}))
    scaled, _ = made.scaled(torch.tensor([[0.5, 0.0]]))
    assert scaled.tolist() == [[0.5, 0.0]]
    with pytest.raises(ValueError, match="no reward has the name rdn"):
        tiny(coefficient={"rdn": 1.0})
