"""Products with one-hots as sums of the weight's columns: on a CPU a tenth of the work.

Letters: B states, S one-hots of C classes, U units.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor

from curionav_cli.agents.elu import elu_
from curionav_cli.agents.lbs_dreamer.kernels.precision import as_computed

MANY = 500  # states from which on laying out the columns pays


def pays(stoch: Tensor) -> bool:
    """Tell whether sums of columns pay for the one-hots (B, S * C)."""
    return stoch.device.type == "cpu" and len(stoch) >= MANY


def indices(stoch: Tensor, classes: int) -> Tensor:
    """Where the one-hots (B, S * C) are one: (B, S) int64."""
    one_hots = stoch.unflatten(-1, (-1, classes))  # (B, S, C)
    index = (one_hots @ torch.arange(classes, dtype=stoch.dtype)).long()
    return index + classes * torch.arange(one_hots.shape[-2])


def columns_of(weight: Tensor) -> Tensor:
    """The columns of a weight (U, S * C) as rows (S * C, U), in the type that products are made in."""
    return as_computed(weight)[0].t().contiguous()


def summed(ones: Tensor, columns: Tensor) -> Tensor:
    """The product x W^T of one-hots x: the sum of the columns `ones` (..., S) of W, (..., U)."""
    return F.embedding_bag(ones.flatten(0, -2), columns, mode="sum").unflatten(0, ones.shape[:-1])


def elu_of_dense(stoch: Tensor, weight: Tensor, rest: Tensor, ones: Tensor | None) -> Tensor:
    """elu(stoch W^T + rest): stoch (B, S * C), W (U, S * C), rest (B, U) -> (B, U). ones: `indices` of stoch.

    With `ones` it has no gradient.
    """
    if ones is None:
        return F.elu(torch.addmm(rest, stoch, weight.t()))
    return elu_(rest + summed(ones, columns_of(weight)))
