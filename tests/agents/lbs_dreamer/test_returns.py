"""Lambda returns against the definition, the limits and a sum by hand."""

import pytest
import torch

from curionav_cli.agents.lbs_dreamer.returns import discount_weights, lambda_return


@pytest.fixture
def rollout():
    generator = torch.Generator().manual_seed(0)
    return (torch.randn(6, 3, generator=generator, dtype=torch.float64) for _ in range(2)), \
        torch.randn(3, generator=generator, dtype=torch.float64)


def n_step(reward, value, bootstrap, start, n, gamma):
    following = torch.cat([value[1:], bootstrap[None]])
    rewards = sum(gamma**i * reward[start + i] for i in range(n))
    return rewards + gamma**n * following[start + n - 1]


@pytest.mark.parametrize("lam", [0.0, 0.5, 0.95, 1.0])
def test_it_is_the_weighted_mean_of_all_n_step_returns(rollout, lam):
    (reward, value), bootstrap = rollout
    ours = lambda_return(reward, value, bootstrap, 0.9, lam)
    for start in range(6):
        left = 6 - start
        returns = [n_step(reward, value, bootstrap, start, n, 0.9) for n in range(1, left + 1)]
        weights = [(1 - lam) * lam ** (n - 1) for n in range(1, left)] + [lam ** (left - 1)]
        truth = sum(w * r for w, r in zip(weights, returns, strict=True))
        torch.testing.assert_close(ours[start], truth)


def test_three_steps_by_hand():
    reward, value = torch.tensor([[1.0], [2.0], [3.0]]), torch.tensor([[9.0], [4.0], [6.0]])
    ours = lambda_return(reward, value, torch.tensor([8.0]), 0.5, 0.5)
    last = 3 + 0.5 * 8
    middle = 2 + 0.5 * (0.5 * 6 + 0.5 * last)
    first = 1 + 0.5 * (0.5 * 4 + 0.5 * middle)
    assert ours.flatten().tolist() == [first, middle, last]


def test_unequal_shapes_are_refused():
    with pytest.raises(AssertionError):
        lambda_return(torch.zeros(3, 2), torch.zeros(4, 2), torch.zeros(2), 0.9, 0.9)


def test_weights_are_products_of_discounts():
    weights = discount_weights(4, 0.9, torch.zeros(()))
    torch.testing.assert_close(weights, torch.tensor([[1], [0.9], [0.81], [0.729]]))
