"""ELU in float32 on a CPU in one pass by numba, where torch takes five. The same but for rounding."""

from __future__ import annotations

import torch
from torch import Tensor

from curionav_cli.agents.elu import elu_
from curionav_cli.agents.lbs_dreamer.kernels import rows


def fused_elu_(x: Tensor) -> Tensor:
    """ELU in place, without a gradient; torch's where x is not float32 without gaps in memory."""
    without_gaps = x.is_contiguous() or (x.dim() == 4 and x.is_contiguous(memory_format=torch.channels_last))
    if x.dtype != torch.float32 or not without_gaps:
        return elu_(x)
    rows.elu_(x.detach().as_strided((x.numel(),), (1,)).numpy())
    return x
