"""Discrete latents: S categoricals of C classes (DreamerV2, sections 2.1 and 2.2). Pure functions.

Logits are (..., S, C) in nats; everything is computed in float32, whatever the networks run in.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor


class _StraightThrough(torch.autograd.Function):
    """Forward a one-hot sample, backward the gradient of the probabilities."""

    @staticmethod
    def forward(ctx, logits: Tensor, noise: Tensor) -> Tensor:
        probs = logits.float().softmax(-1)
        ctx.save_for_backward(probs)
        ctx.dtype = logits.dtype
        return torch.zeros_like(probs).scatter_(-1, inverse_cdf(probs, noise)[..., None], 1.0)

    @staticmethod
    def backward(ctx, gradient: Tensor):
        (probs,) = ctx.saved_tensors
        weighted = probs * gradient
        return (weighted - probs * weighted.sum(-1, keepdim=True)).to(ctx.dtype), None


def inverse_cdf(probs: Tensor, noise: Tensor) -> Tensor:
    """Index (...) drawn from probs (..., C) by uniform noise (...) in [0, 1).

    Clamped, because rounding may leave the sum of the probabilities below the noise.
    """
    assert probs.shape[:-1] == noise.shape, (probs.shape, noise.shape)
    index = (probs.cumsum(-1) <= noise[..., None]).sum(-1)
    return index.clamp_(max=probs.shape[-1] - 1)


def sample(logits: Tensor, noise: Tensor) -> Tensor:
    """One-hot samples (..., S, C) with straight-through gradients; noise (..., S) uniform in [0, 1)."""
    return _StraightThrough.apply(logits, noise)


def kl(left: Tensor, right: Tensor) -> Tensor:
    """KL(left || right) in nats, summed over the S latents: (..., S, C) twice -> (...)."""
    assert left.shape == right.shape, (left.shape, right.shape)
    log_left, log_right = F.log_softmax(left.float(), -1), F.log_softmax(right.float(), -1)
    return (log_left.exp() * (log_left - log_right)).sum((-2, -1))


def balanced_kl(posterior: Tensor, prior: Tensor, balance: float, free_nats: float) -> Tensor:
    """KL balancing with free nats (DreamerV2, algorithm 2): logits (..., S, C) -> scalar.

    `balance` of the gradient goes to the prior, the rest to the posterior. The free nats are taken
    off the mean over batch and time, from each of the two terms.
    """
    to_prior = kl(posterior.detach(), prior).mean()
    to_posterior = kl(posterior, prior.detach()).mean()
    return balance * to_prior.clamp(min=free_nats) + (1 - balance) * to_posterior.clamp(min=free_nats)


def entropy(logits: Tensor) -> Tensor:
    """Entropy in nats over the last dimension: (..., C) -> (...)."""
    log_probs = F.log_softmax(logits.float(), -1)
    return -(log_probs.exp() * log_probs).sum(-1)
