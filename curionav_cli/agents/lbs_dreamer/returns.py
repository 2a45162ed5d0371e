"""Lambda returns of imagined rollouts (DreamerV2, section 2.2): pure functions, time first.

Letters: H steps, N rollouts.
"""

from __future__ import annotations

import torch
from torch import Tensor


def lambda_return(reward: Tensor, value: Tensor, bootstrap: Tensor, gamma: float, lam: float) -> Tensor:
    """Lambda returns (H, N) of reward (H, N), value (H, N) and bootstrap (N,), the value of the last state.

        target_t = r_t + gamma ((1 - lam) v_{t+1} + lam target_{t+1}),    target_H = v_H = bootstrap

    lam = 0 is TD(0), lam = 1 is Monte Carlo.
    """
    assert reward.shape == value.shape and value.shape[1:] == bootstrap.shape
    following = torch.cat([value[1:], bootstrap[None]])  # v_{t+1} (H, N)
    inputs = reward + gamma * (1 - lam) * following
    target, targets = bootstrap, []
    for step in reversed(inputs.unbind()):
        target = step + gamma * lam * target
        targets.append(target)
    return torch.stack(targets[::-1])


def discount_weights(steps: int, gamma: float, like: Tensor) -> Tensor:
    """Weights 1, gamma, gamma^2 ... of a rollout's steps as a column (H, 1), of the type and device of `like`."""
    return gamma ** torch.arange(steps, dtype=like.dtype, device=like.device)[:, None]
