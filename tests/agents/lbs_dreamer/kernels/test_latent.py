"""Discrete latents against torch.distributions, closed forms and finite differences."""

import pytest
import torch
from torch.distributions import Independent, OneHotCategorical, kl_divergence

from curionav_cli.agents.lbs_dreamer.kernels import latent


@pytest.fixture
def logits():
    generator = torch.Generator().manual_seed(0)
    return lambda *shape: torch.randn(*shape, generator=generator) * 2


CLASSES = pytest.mark.parametrize("classes", [6, latent.FEW])  # few, and as many as are laid out otherwise


@CLASSES
def test_kl_is_that_of_torch_distributions(logits, classes):
    q, p = logits(5, 3, 4, classes), logits(5, 3, 4, classes)
    truth = kl_divergence(*(Independent(OneHotCategorical(logits=x), 1) for x in (q, p)))
    torch.testing.assert_close(latent.kl(q, p), truth)


def test_kl_of_equal_or_shifted_logits_is_zero_and_of_a_coin_is_known(logits):
    q = logits(2, 3, 4)
    torch.testing.assert_close(latent.kl(q, q + 5), torch.zeros(2), atol=1e-5, rtol=0)
    sure = torch.tensor([[50.0, 0.0]])
    torch.testing.assert_close(latent.kl(sure, torch.zeros(1, 2)), torch.tensor(2.0).log())


def gradients(posterior, prior, loss):
    posterior, prior = posterior.clone().requires_grad_(), prior.clone().requires_grad_()
    value = loss(posterior, prior)
    return value.detach(), *torch.autograd.grad(value, (posterior, prior))


@CLASSES
def test_the_gradient_of_kl_is_that_of_finite_differences_and_of_autograd(logits, classes):
    q, p = (logits(2, 3, classes).double().requires_grad_() for _ in range(2))
    assert torch.autograd.gradcheck(latent.kl, (q, p))
    weight = torch.tensor([2.0, -3.0])
    plain = (q.softmax(-1) * (q.log_softmax(-1) - p.log_softmax(-1))).sum((-2, -1))
    truth = torch.autograd.grad((plain * weight).sum(), (q, p))
    ours = torch.autograd.grad((latent.kl(q, p, 0.5, 4.0) * weight).sum(), (q, p))
    torch.testing.assert_close(ours, (0.5 * truth[0], 4 * truth[1]))


def test_balancing_sends_four_fifths_of_the_gradient_to_the_prior(logits):
    q, p = logits(6, 2, 4, 8), logits(6, 2, 4, 8)
    value, to_q, to_p = gradients(q, p, lambda q, p: latent.balanced_kl(q, p, 0.8, 1.0))
    plain, plain_q, plain_p = gradients(q, p, lambda q, p: latent.kl(q, p).mean())
    assert plain > 1
    torch.testing.assert_close(value, plain)
    torch.testing.assert_close(to_q, 0.2 * plain_q)
    torch.testing.assert_close(to_p, 0.8 * plain_p)


def test_below_the_free_nats_nothing_is_learned(logits):
    q = logits(6, 2, 4, 8)
    p = q + 0.01 * logits(6, 2, 4, 8)
    value, to_q, to_p = gradients(q, p, lambda q, p: latent.balanced_kl(q, p, 0.8, 1.0))
    assert value == 1 and not to_q.any() and not to_p.any()


def test_free_nats_are_taken_off_the_mean_and_not_off_each_step():
    q, p = torch.zeros(2, 1, 1, 2), torch.zeros(2, 1, 1, 2)
    q[1, ..., 0], p[1, ..., 1] = 10, 10
    p[0, ..., 0] = 0.1  # a step far below one nat, in a batch that is above it
    _, _, to_p = gradients(q, p, lambda q, p: latent.balanced_kl(q, p, 0.8, 1.0))
    assert to_p[0].abs().max() > 1e-3


@CLASSES
def test_the_gradients_of_kl_have_the_types_of_its_logits(logits, classes):
    q, p = logits(3, classes).bfloat16().requires_grad_(), logits(3, classes).requires_grad_()
    latent.kl(q, p).backward()
    assert (q.grad.dtype, p.grad.dtype) == (torch.bfloat16, torch.float32)


@CLASSES
def test_a_sample_is_one_hot_and_its_gradient_that_of_the_probabilities(logits, classes):
    x = logits(3, 4, classes).requires_grad_()
    weight = logits(3, 4, classes)
    drawn = latent.sample(x, torch.rand(3, 4, generator=torch.Generator().manual_seed(1)))
    assert set(drawn.unique().tolist()) == {0.0, 1.0} and (drawn.sum(-1) == 1).all()
    (ours,) = torch.autograd.grad((drawn * weight).sum(), x)
    (truth,) = torch.autograd.grad((x.softmax(-1) * weight).sum(), x)
    torch.testing.assert_close(ours, truth)


def test_samples_follow_the_probabilities():
    probs = torch.tensor([0.5, 0.0, 0.2, 0.3])
    noise = torch.rand(100_000, generator=torch.Generator().manual_seed(2))
    index = latent.inverse_cdf(probs.expand(100_000, 4), noise)
    count = torch.bincount(index, minlength=4)
    expected = probs * 100_000
    assert count[1] == 0
    assert ((count - expected).square() / expected.clamp(min=1)).sum() < 16.3  # chi-square, 3 df, p = 0.001


def test_rounding_never_draws_beyond_the_last_class():
    probs = torch.tensor([[0.3, 0.3, 0.39]])
    assert latent.inverse_cdf(probs, torch.tensor([0.9999])) == 2
    assert latent.inverse_cdf(torch.tensor([[0.0, 1.0]]), torch.tensor([0.0])) == 1


@CLASSES
def test_entropy(classes):
    torch.testing.assert_close(latent.entropy(torch.zeros(2, classes)), torch.full((2,), float(classes)).log())
