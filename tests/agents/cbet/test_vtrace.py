"""V-trace against its definition, term by term, and against what it must become in simple cases."""

import pytest
import torch

from curionav_cli.agents.cbet.vtrace import vtrace

T, B = 13, 4


@pytest.fixture
def case():
    """Random ratios, rewards, discounts with terminals, values; float64."""
    generator = torch.Generator().manual_seed(1)
    draw = {"generator": generator, "dtype": torch.float64}
    ratio = (torch.randn(T, B, **draw)).exp()
    discount = 0.9 + 0.1 * torch.rand(T, B, **draw)
    discount[torch.rand(T, B, **draw) < 0.15] = 0
    return ratio, torch.randn(T, B, **draw), discount, torch.randn(T + 1, B, **draw)


def term_by_term(ratio, reward, discount, value):
    cut = ratio.clamp(max=1)
    target = value[:-1].clone()
    for b in range(value.shape[1]):
        for s in range(len(reward)):
            for t in range(s, len(reward)):
                weight = discount[s:t, b].prod() * cut[s:t, b].prod()
                target[s, b] += weight * cut[t, b] * (reward[t, b] + discount[t, b] * value[t + 1, b] - value[t, b])
    return target


def test_it_is_the_sum_of_its_terms(case):
    ratio, reward, discount, value = case
    target, advantage = vtrace(*case)
    truth = term_by_term(*case)
    torch.testing.assert_close(target, truth, atol=1e-10, rtol=0)
    following = torch.cat([truth[1:], value[-1:]])
    torch.testing.assert_close(advantage, ratio.clamp(max=1) * (reward + discount * following - value[:-1]),
                               atol=1e-10, rtol=0)


def test_on_policy_it_is_the_bootstrapped_return(case):
    _, reward, discount, value = case
    target, _ = vtrace(torch.ones_like(reward), reward, discount, value)
    returns, following = [], value[-1]
    for r, d in zip(reward.flip(0), discount.flip(0), strict=True):
        following = r + d * following
        returns.append(following)
    torch.testing.assert_close(target, torch.stack(returns[::-1]))


def test_without_a_future_only_the_reward_counts(case):
    ratio, reward, discount, value = case
    target, _ = vtrace(ratio, reward, torch.zeros_like(discount), value)
    torch.testing.assert_close(target, ratio.clamp(max=1) * (reward - value[:-1]) + value[:-1])


def test_one_step(case):
    ratio, reward, discount, value = (part[:2] if len(part) > T else part[:1] for part in case)
    target, advantage = vtrace(ratio, reward, discount, value)
    error = reward + discount * value[1:] - value[:-1]
    torch.testing.assert_close(target, value[:-1] + ratio.clamp(max=1) * error)
    torch.testing.assert_close(advantage, ratio.clamp(max=1) * error)


def test_a_terminal_cuts_the_sum_and_a_respawn_does_not(case):
    ratio, reward, _, value = case
    discount = torch.full_like(reward, 0.99)
    target, _ = vtrace(ratio, reward, discount, value)
    later = reward.clone()
    later[6:] += 5
    assert (vtrace(ratio, later, discount, value)[0][:6] != target[:6]).all()
    discount[5] = 0
    assert (vtrace(ratio, later, discount, value)[0][:6] == vtrace(ratio, reward, discount, value)[0][:6]).all()


def test_targets_carry_no_gradient(case):
    ratio, reward, discount, value = case
    target, advantage = vtrace(ratio.requires_grad_(), reward, discount, value.requires_grad_())
    assert not target.requires_grad and not advantage.requires_grad
