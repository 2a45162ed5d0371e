"""MLP: dense layers with ELU, with their gradient written out by hand.

Layer i makes h_i = elu(h_{i-1} W_i^T + b_i), with h_0 = x, and the last one y = h_n W^T + b. With y' for the loss's
derivative by y:

    W' = y'^T h_n      b' = sum of y'      h_n' = y' W      (h_{n-1} W_n^T + b_n)' = h_n' elu's      and so on down

Why by hand: layers that were already computed need not be computed again for their gradient (the actor's, which
imagination has evaluated for every action); on a CPU a product with one-hots is a sum of columns (one_hot.py), and rows
are taken in parts that stay in the caches.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import cast

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.elu import InPlace, elu_, elu_backward
from curionav_cli.agents.lbs_dreamer.kernels.one_hot import columns_of, summed

PART = 2500  # rows at a time


class MLP(nn.Module):
    """Dense layers with ELU and a linear output: (..., inputs) -> (..., outputs). The inputs get no gradient.

    hot: how many of the inputs, the first ones, are one-hots.
    """

    def __init__(self, inputs: int, units: int, layers: int, outputs: int, hot: int = 0):
        super().__init__()
        sizes = [inputs] + [units] * layers
        self.layers = nn.ModuleList(nn.Linear(i, o) for i, o in pairwise(sizes))
        self.out = nn.Linear(units, outputs)
        self.hot = hot
        self.elu: InPlace = elu_

    def forward(self, x: Tensor, ones: Tensor | None = None, known: Sequence[Tensor] = ()) -> Tensor:
        """Outputs for x. ones: see `activations`; known: what that returned for x with the same weights."""
        columns = None if known or ones is None else self.columns()
        given = [x.detach(), *known] if columns is None else [x.detach(), cast(Tensor, ones)]
        flat = [tensor.reshape(-1, tensor.shape[-1]) for tensor in given]
        size = PART if x.device.type == "cpu" else len(flat[0])
        outputs = []
        for rows, *others in zip(*(tensor.split(size) for tensor in flat), strict=True):
            computed = others if known else self.activations(rows, others[0] if others else None, columns)
            outputs.append(self._learnable(rows, computed) if torch.is_grad_enabled() else computed[-1])
        return torch.cat(outputs).view(*x.shape[:-1], -1)

    @torch.no_grad()
    def activations(self, x: Tensor, ones: Tensor | None = None, columns: Tensor | None = None) -> list[Tensor]:
        """Outputs of every layer for x, those of the last one last; without gradients.

        ones (..., S) int64: which of the inputs are one, if that is known (one_hot.py); columns: `columns()`.
        """
        first, *rest = cast(list[nn.Linear], self.layers)
        if ones is None:
            made = first(x)
        else:
            made = F.linear(x[..., self.hot:], first.weight[:, self.hot:], first.bias)
            made += summed(ones, self.columns() if columns is None else columns)
        computed = [self.elu(made)]
        for layer in rest:
            computed.append(self.elu(layer(computed[-1])))
        return [*computed, self.out(computed[-1])]

    @torch.no_grad()
    def columns(self) -> Tensor:
        """The columns of the first layer that belong to one-hots."""
        return columns_of(cast(nn.Linear, self.layers[0]).weight[:, :self.hot])

    def _learnable(self, x: Tensor, computed: Sequence[Tensor]) -> Tensor:
        """The outputs that were computed, with a gradient to the weights."""
        every = [*cast(list[nn.Linear], self.layers), self.out]
        weights, biases = (part.weight for part in every), (part.bias for part in every)
        return _Computed.apply(x, len(every), *computed, *weights, *biases)


class _Computed(torch.autograd.Function):
    """The last of the activations, with the gradient of all layers; products are made in the outputs' type."""

    @staticmethod
    def forward(ctx, x, count, *tensors):
        computed, weights = tensors[:count], tensors[count:2 * count]
        ctx.save_for_backward(x, *computed[:-1], *weights)
        ctx.count = count
        return computed[-1].clone()

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
