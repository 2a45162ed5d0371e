"""Surprise: its target, its mask, and what the head makes of it."""

import pytest
import torch
from torch.distributions import Independent, OneHotCategorical, kl_divergence

from curionav_cli.agents.lbs_dreamer.lbs import LBS, correlation, settled
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser
from curionav_cli.agents.lbs_dreamer.rssm import Observed, State

T, B = 6, 3


@pytest.fixture
def lbs():
    made = LBS(features=5, units=16, layers=2, burn_in=2)
    initialise(made, torch.Generator().manual_seed(0))
    return made


@pytest.fixture
def seen():
    generator = torch.Generator().manual_seed(1)
    states = State(torch.randn(T, B, 3, generator=generator), torch.randn(T, B, 2, generator=generator))
    posterior, prior = (torch.randn(T, B, 2, 4, generator=generator) for _ in range(2))
    return Observed(states, posterior, prior)


def test_the_first_steps_of_a_cut_out_sequence_are_not_settled():
    mask = settled(4, torch.tensor([True, False]), burn_in=2)
    assert mask.T.tolist() == [[True] * 4, [False, False, True, True]]


def test_the_loss_is_half_the_squared_distance_to_the_plain_kl_where_settled(lbs, seen):
    is_start = torch.tensor([True, False, False])
    loss, metrics = lbs.loss(seen, is_start)
    q, p = (Independent(OneHotCategorical(logits=x), 1) for x in (seen.posterior, seen.prior))
    target = kl_divergence(q, p)
    error = (lbs.head(torch.cat([seen.states.stoch, seen.states.deter], -1)).squeeze(-1) - target) ** 2
    kept = torch.cat([error[:, 0], error[2:, 1], error[2:, 2]])
    torch.testing.assert_close(loss, kept.mean() / 2)
    torch.testing.assert_close(metrics["kl"], target.mean())
    settled_target = torch.cat([target[:, 0], target[2:, 1], target[2:, 2]])
    torch.testing.assert_close(metrics["lbs_target"], settled_target.mean())


def test_no_gradient_reaches_the_world_model(lbs, seen):
    leaves = [seen.states.deter, seen.states.stoch, seen.posterior, seen.prior]
    for leaf in leaves:
        leaf.requires_grad_()
    loss, _ = lbs.loss(seen, torch.zeros(B, dtype=torch.bool))
    assert torch.autograd.grad(loss, leaves, allow_unused=True) == (None,) * 4


def test_a_target_of_two_values_is_met_at_its_conditional_mean(lbs):
    """Two kinds of places; in one the KL is either 0 or log 4, at random."""
    generator = torch.Generator().manual_seed(2)
    kind = torch.arange(64) % 2
    features = State(torch.stack([kind, 1 - kind, torch.ones(64)], -1).float()[None], torch.zeros(1, 64, 2))
    optimiser = Optimiser(lbs, 0.01, 1e-5, 0.0, 100)
    for _ in range(300):
        sure = (torch.rand(1, 64, generator=generator) < 0.5) & (kind == 1)
        posterior = torch.zeros(1, 64, 1, 4)
        posterior[..., 0] = (sure * 50.0)[..., None]
        loss, _ = lbs.loss(Observed(features, posterior, torch.zeros_like(posterior)), torch.ones(64) > 0)
        optimiser.step(loss)
    reward = lbs.reward(features.features)[0].detach()
    assert reward[kind == 0].mean() == pytest.approx(0.0, abs=0.08)
    assert reward[kind == 1].mean() == pytest.approx(torch.tensor(4.0).log().item() / 2, abs=0.15)


def test_reward_is_never_below_zero(lbs):
    features = 10 * torch.randn(100, 5, generator=torch.Generator().manual_seed(3))
    assert (lbs.head(features) < 0).any() and (lbs.reward(features) >= 0).all()


def test_correlation_is_pearsons_where_the_mask_is_one():
    x, y = torch.randn(2, 50, generator=torch.Generator().manual_seed(4))
    mask = (torch.arange(50) < 30).float()
    torch.testing.assert_close(correlation(x, y, mask), torch.corrcoef(torch.stack([x[:30], y[:30]]))[0, 1])
    assert correlation(torch.ones(50), y, mask) == 0
