"""V-trace targets and advantages (Espeholt et al., IMPALA, 2018, equation (1) and section 4.2).

Letters: T steps, B unrolls. The ratios rho, c and that of the policy gradient are clipped at one, as in C-BET.
"""

from __future__ import annotations

import torch
from torch import Tensor


@torch.no_grad()
def vtrace(ratio: Tensor, reward: Tensor, discount: Tensor, value: Tensor) -> tuple[Tensor, Tensor]:
    """V-trace targets v_s and advantages, (T, B) both, from ratio pi / mu, reward, discount (T, B), value (T + 1, B).

    v_s = V_s + sum_t gamma^(t - s) (prod_{i < t} c_i) rho_t (r_t + gamma V_{t+1} - V_t), and the advantage is
    rho_s (r_s + gamma v_{s+1} - V_s).
    """
    assert ratio.shape == reward.shape == discount.shape == value[1:].shape
    cut = ratio.clamp(max=1)
    error = cut * (reward + discount * value[1:] - value[:-1])
    carried, corrections = torch.zeros_like(value[-1]), []
    for step in reversed(range(len(reward))):
        carried = error[step] + discount[step] * cut[step] * carried
        corrections.append(carried)
    target = value[:-1] + torch.stack(corrections[::-1])
    following = torch.cat([target[1:], value[-1:]])
    return target, cut * (reward + discount * following - value[:-1])
