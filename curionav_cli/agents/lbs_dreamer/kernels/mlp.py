"""MLP: dense layers with ELU, with their gradient written out by hand.

Layer i makes h_i = elu(h_{i-1} W_i^T + b_i), with h_0 = x, and the last one y = h_n W^T + b. With y' for the loss's
derivative by y:

    W' = y'^T h_n      b' = sum of y'      h_n' = y' W      (h_{n-1} W_n^T + b_n)' = h_n' elu's      and so on down

Three things are gained. Layers that were already computed need not be computed again for their gradient: the actor's,
which imagination has asked for every action. And on a CPU a product with one-hots is a sum of some of the weight's
columns, a tenth of the work; and rows are taken in parts that stay in the caches.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import cast

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.kernels.elu import elu_, elu_backward
from curionav_cli.agents.lbs_dreamer.kernels.precision import as_computed

PART = 2500  # rows at a time


class MLP(nn.Module):
    """Dense layers with ELU and one linear output: (..., inputs) -> (..., outputs). The inputs get no gradient.

    hot: how many of the inputs, the first, are one-hots.
    """

    def __init__(self, inputs: int, units: int, layers: int, outputs: int, hot: int = 0):
        super().__init__()
        sizes = [inputs] + [units] * layers
        self.layers = nn.ModuleList(nn.Linear(i, o) for i, o in pairwise(sizes))
        self.out = nn.Linear(units, outputs)
        self.hot = hot

    def forward(self, x: Tensor, ones: Tensor | None = None, known: Sequence[Tensor] = ()) -> Tensor:
        """ones: see `activations`; known: what that gave for x with the same weights."""
        columns = None if known or ones is None else self.columns()
        given = [x.detach(), *known] if columns is None else [x.detach(), cast(Tensor, ones)]
        flat = [tensor.reshape(-1, tensor.shape[-1]) for tensor in given]
        size = PART if x.device.type == "cpu" else len(flat[0])
        outputs = []
        for rows, *others in zip(*(tensor.split(size) for tensor in flat), strict=True):
            found = others if known else self.activations(rows, others[0] if others else None, columns)
            outputs.append(self._learnable(rows, found) if torch.is_grad_enabled() else found[-1])
        return torch.cat(outputs).view(*x.shape[:-1], -1)

    @torch.no_grad()
    def activations(self, x: Tensor, ones: Tensor | None = None, columns: Tensor | None = None) -> list[Tensor]:
        """What each layer makes of x, the outputs last.

        ones (..., S) int64: which of the inputs are the ones of S one-hots, if that is known; columns: `columns()`.
        """
        first, *rest = cast(list[nn.Linear], self.layers)
        if ones is None:
            made = first(x)
        else:
            made = F.linear(x[..., self.hot:], first.weight[:, self.hot:], first.bias)
            made += summed(ones, self.columns() if columns is None else columns)
        found = [elu_(made)]
        for layer in rest:
            found.append(elu_(layer(found[-1])))
        return [*found, self.out(found[-1])]

    @torch.no_grad()
    def columns(self) -> Tensor:
        """Of the first layer, those that one-hots choose from."""
        return columns_of(cast(nn.Linear, self.layers[0]).weight[:, :self.hot])

    def _learnable(self, x: Tensor, found: Sequence[Tensor]) -> Tensor:
        """The outputs that were found, with a way back to the weights."""
        every = [*cast(list[nn.Linear], self.layers), self.out]
        return _Found.apply(x, len(every), *found, *(part.weight for part in every), *(part.bias for part in every))


def columns_of(weight: Tensor) -> Tensor:
    """(outputs, inputs) -> (inputs, outputs), laid out for `summed`, in the type that products are made in."""
    return as_computed(weight)[0].t().contiguous()


def summed(ones: Tensor, columns: Tensor) -> Tensor:
    """x W^T for x (..., inputs) that is one at `ones` (..., S) and zero elsewhere: the sum of those columns of W."""
    return F.embedding_bag(ones.flatten(0, -2), columns, mode="sum").unflatten(0, ones.shape[:-1])


class _Found(torch.autograd.Function):
    """Products are made in the outputs' type."""

    @staticmethod
    def forward(ctx, x, count, *tensors):
        found, weights = tensors[:count], tensors[count:2 * count]
        ctx.save_for_backward(x, *found[:-1], *weights)
        ctx.count = count
        return found[-1].clone()

    @staticmethod
    def backward(ctx, slope):
        inputs, weights = ctx.saved_tensors[:ctx.count], ctx.saved_tensors[ctx.count:]
        to_weights, to_biases = [], []
        for given, weight in zip(reversed(inputs), reversed(weights), strict=True):
            to_weights.append((slope.t() @ given.to(slope.dtype)).to(weight.dtype))
            to_biases.append(slope.sum(0).to(weight.dtype))
            if given is not inputs[0]:
                slope = elu_backward(slope @ weight.to(slope.dtype), given)
        return None, None, *[None] * ctx.count, *reversed(to_weights), *reversed(to_biases)
