"""Actor and critic on made-up worlds whose answers are known."""

import math

import pytest
import torch

from curionav_cli.agents.lbs_dreamer.behaviour import Behaviour, targets_and_advantage
from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser
from curionav_cli.agents.lbs_dreamer.rssm import State


@pytest.fixture
def behaviour():
    made = Behaviour(features=4, actions=3, units=8, layers=1)
    initialise(made, torch.Generator().manual_seed(0))
    return made


class OneState:
    """A world in which nothing ever changes."""

    def ones(self, state):
        return None

    def roll(self, state, action, noise, ones):
        return state, None


@pytest.fixture
def rollouts(behaviour):
    """rollouts(count, horizon=1) in OneState."""
    def make(count, horizon=1, seed=0):
        noise = torch.rand(horizon, count, 2, generator=torch.Generator().manual_seed(seed))
        return behaviour.imagine(OneState(), State(torch.ones(count, 2), torch.ones(count, 2)), noise)
    return make


def test_reinforce_is_the_gradient_of_the_expected_return(behaviour, rollouts):
    """Three arms that pay 1, 2 and 4: the estimate against autograd of sum pi(a) r(a)."""
    pay = torch.tensor([1.0, 2.0, 4.0])
    imagined = rollouts(200_000)
    features, action, *_ = imagined
    loss, _ = behaviour.actor_loss(imagined, pay[action] - 2.0, 0.99, 0.0)
    weights = tuple(behaviour.actor.parameters())
    estimate = torch.autograd.grad(loss, weights)
    exact = torch.autograd.grad(-(behaviour.actor(features[0, 0]).softmax(-1) * pay).sum(), weights)
    for ours, truth in zip(estimate, exact, strict=True):
        torch.testing.assert_close(ours, truth, atol=0.01, rtol=0.03)


def test_what_the_actor_made_in_imagination_is_what_it_makes_of_the_states(behaviour, rollouts):
    imagined = rollouts(5, horizon=3)
    assert len(imagined.actor_layers) == 2
    for known, truth in zip(imagined.actor_layers, behaviour.actor.activations(imagined.features[:3]), strict=True):
        torch.testing.assert_close(known, truth)


def test_entropy_bonus_and_its_scale(behaviour, rollouts):
    imagined = rollouts(5)
    nothing = torch.zeros(1, 5)
    loss, entropy = behaviour.actor_loss(imagined, nothing, 0.99, 0.5)
    probs = behaviour.actor(imagined.features[0, 0]).softmax(-1)
    torch.testing.assert_close(entropy, -(probs * probs.log()).sum())
    torch.testing.assert_close(loss, -0.5 * entropy)


def test_steps_count_less_the_later_they_come(behaviour, rollouts):
    imagined = rollouts(4, horizon=3)
    advantage = torch.tensor([[0.0], [0.0], [1.0]]).expand(3, 4)
    late, _ = behaviour.actor_loss(imagined, advantage, 0.5, 0.0)
    log_policy = behaviour.actor(imagined.features[2]).log_softmax(-1).gather(-1, imagined.action[2][:, None])
    torch.testing.assert_close(late, -0.25 * log_policy.mean() / 3)


def test_reward_on_arrival_belongs_to_the_action_before():
    reward = torch.zeros(5, 1)
    reward[2] = 1.0  # arriving in z_2, which action 1 led to
    target, advantage = targets_and_advantage(reward, torch.zeros(5, 1), gamma=0.5, lam=1.0)
    assert target.flatten().tolist() == [0.25, 0.5, 1.0, 0.0]
    assert advantage.flatten().tolist() == [0.5, 1.0, 0.0]


def test_the_actor_finds_the_arm_that_pays_and_without_pay_stays_open(behaviour, rollouts):
    for pays, settled in ((0.0, math.log(3)), (1.0, 0.0)):
        optimiser = Optimiser(behaviour.actor, 0.01, 1e-5, 1e-6, 100)
        for seed in range(150):
            imagined = rollouts(32, horizon=2, seed=seed)
            advantage = pays * (imagined.action == 0).float() - pays / 3
            loss, entropy = behaviour.actor_loss(imagined, advantage, 0.99, 1e-2)
            optimiser.step(loss)
        assert entropy.item() == pytest.approx(settled, abs=0.2)
    assert (imagined.action == 0).float().mean() > 0.9


def test_the_critic_learns_the_target(behaviour, rollouts):
    imagined = rollouts(8, horizon=3)
    target = torch.full((3, 8), 2.0)
    optimiser = Optimiser(behaviour.critic, 0.02, 1e-5, 1e-6, 100)
    losses = []
    for _ in range(100):
        loss = behaviour.critic_loss(imagined, target, 0.99)
        losses.append(loss.item())
        optimiser.step(loss)
    assert losses[-1] < 1e-3 * losses[0]


@pytest.fixture
def learner(tiny, networks):
    def make(**changes):
        settings = tiny(**changes)
        return Learner(settings, networks(settings), torch.Generator().manual_seed(1))
    return make


def weights(module):
    return [parameter.detach().clone() for parameter in module.parameters()]


def same(left, right):
    return all((a == b).all() for a, b in zip(left, right, strict=True))


def random_states(learner):
    rssm, generator = learner.networks.world_model.rssm, torch.Generator().manual_seed(2)
    return State(*(torch.rand(8, 3, size, generator=generator) for size in (rssm.deter, rssm.stoch)))


def learn_to_act(learner):
    noise = learner.draw(torch.Size((8, 3)), learner.count())
    learner.update_behaviour(random_states(learner), noise.starts, noise.imagined)


def test_slow_critic_is_copied_at_its_interval_and_only_then(learner):
    made = learner(slow_critic_interval=3, behaviour_interval=1)
    behaviour, copies = made.networks.behaviour, []
    for update in range(7):
        critic, slow = weights(behaviour.critic), weights(behaviour.slow_critic)
        learn_to_act(made)
        after = weights(behaviour.slow_critic)
        if update and same(after, critic) and not same(after, slow):
            copies.append(update)
    assert copies == [3, 6]


def test_learning_to_act_leaves_model_and_curiosity_alone(learner):
    made = learner()
    others = made.networks.world_model, made.networks.curiosity
    before = [weights(module) for module in others]
    actor = weights(made.networks.behaviour.actor)
    learn_to_act(made)
    assert all(same(old, weights(module)) for old, module in zip(before, others, strict=True))
    assert all(parameter.grad is None for module in others for parameter in module.parameters())
    assert not same(actor, weights(made.networks.behaviour.actor))


def test_curiosity_leaves_the_model_alone_and_the_model_curiosity(learner, data):
    made = learner()
    curiosity = weights(made.networks.curiosity)
    noise = made.draw(data.action.shape, False)
    seen, _ = made.update_world_model(data, noise)
    assert same(curiosity, weights(made.networks.curiosity))
    model = weights(made.networks.world_model)
    made.update_curiosity(seen, data, noise.curiosity)
    assert same(model, weights(made.networks.world_model))
    assert not same(curiosity, weights(made.networks.curiosity))
