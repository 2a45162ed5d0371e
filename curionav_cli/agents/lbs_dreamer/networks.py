"""Encoder, decoder and MLP (DreamerV2, appendix D), with images held as patches.

Letters: N frames, k kernel, s stride, G = 64 / s patches a side, P = 3 s s numbers of a patch, E embedding.

A convolution of kernel k and stride s on pixels equals one of kernel k / s and stride 1 on s x s
patches, and the mirror image of that holds for the decoder's last layer. Both are computed on
patches, which is faster by half and exact; the parameters keep their usual shapes.
"""

from __future__ import annotations

from itertools import pairwise
from typing import cast

import torch
import torch.nn.functional as F
from torch import Tensor, nn

SIDE, COLOURS = 64, 3


def to_patches(image: Tensor, stride: int) -> Tensor:
    """Images (..., 64, 64, 3) uint8 -> patches (N, G, G, P) float in [-0.5, 0.5]."""
    grid = SIDE // stride
    blocks = image.view(-1, grid, stride, grid, stride, COLOURS).transpose(2, 3)
    blocks = blocks.reshape(-1, grid, grid, stride * stride * COLOURS)
    return blocks.float().mul_(1 / 255).sub_(0.5)


def to_images(patches: Tensor, stride: int) -> Tensor:
    """The way back: (N, G, G, P) float -> (N, 64, 64, 3) uint8."""
    grid = SIDE // stride
    blocks = patches.float().reshape(-1, grid, grid, stride, stride, COLOURS)
    image = blocks.transpose(2, 3).reshape(-1, SIDE, SIDE, COLOURS)
    return ((image + 0.5) * 255).round().clamp(0, 255).to(torch.uint8)


def patch_kernel(weight: Tensor, stride: int) -> Tensor:
    """Convolution weight (out, 3, k, k) on pixels -> (out, P, k/s, k/s) on patches."""
    out, colours, kernel, _ = weight.shape
    reach = kernel // stride
    blocks = weight.view(out, colours, reach, stride, reach, stride)
    return blocks.permute(0, 3, 5, 1, 2, 4).reshape(out, stride * stride * colours, reach, reach)


def transposed_patch_kernel(weight: Tensor, stride: int) -> Tensor:
    """Transposed weight (in, 3, k, k) to pixels -> convolution weight (P, in, k/s, k/s) to patches.

    To be used with padding k/s - 1: a transposed convolution is a full correlation with the kernel
    turned round, here patch by patch and not inside a patch.
    """
    inputs, colours, kernel, _ = weight.shape
    reach = kernel // stride
    blocks = weight.view(inputs, colours, reach, stride, reach, stride).flip(2, 4)
    return blocks.permute(3, 5, 1, 0, 2, 4).reshape(stride * stride * colours, inputs, reach, reach)


def initialise(module: nn.Module, generator: torch.Generator) -> None:
    """Glorot-uniform weights and zero biases, as Keras does for DreamerV2; LayerNorm at one and zero."""
    for part in module.modules():
        if isinstance(part, (nn.Linear, nn.Conv2d, nn.ConvTranspose2d)):
            nn.init.xavier_uniform_(part.weight, generator=generator)
            nn.init.zeros_(cast(Tensor, part.bias))
        elif isinstance(part, nn.LayerNorm):
            nn.init.ones_(part.weight)
            nn.init.zeros_(part.bias)


class Encoder(nn.Module):
    """Convolutions with ELU, no padding: (N, G, G, P) -> (N, E)."""

    def __init__(self, channels: list[int], kernels: list[int], strides: list[int]):
        super().__init__()
        inputs = [COLOURS, *channels[:-1]]
        layers = zip(inputs, channels, kernels, strides, strict=True)
        self.layers = nn.ModuleList(nn.Conv2d(i, o, k, s) for i, o, k, s in layers)
        self.stride = strides[0]
        side = SIDE
        for kernel, stride in zip(kernels, strides, strict=True):
            side = (side - kernel) // stride + 1
        self.size = side * side * channels[-1]

    def forward(self, patches: Tensor) -> Tensor:
        first, *rest = cast(list[nn.Conv2d], self.layers)
        x = F.elu(F.conv2d(patches.permute(0, 3, 1, 2), patch_kernel(first.weight, self.stride), first.bias))
        for layer in rest:
            x = F.elu(layer(x))
        return x.permute(0, 2, 3, 1).flatten(1)  # (N, E), rows and columns before channels as in Keras


class Decoder(nn.Module):
    """A dense layer and transposed convolutions with ELU, none on the last: (N, F) -> (N, G, G, P).

    The output is the mean of a normal distribution of variance one for every number of the image.
    """

    def __init__(self, features: int, units: int, channels: list[int], kernels: list[int],
                 strides: list[int]):
        super().__init__()
        self.dense = nn.Linear(features, units)
        sizes = [units, *channels, COLOURS]
        layers = zip(sizes[:-1], sizes[1:], kernels, strides, strict=True)
        self.layers = nn.ModuleList(nn.ConvTranspose2d(i, o, k, s) for i, o, k, s in layers)
        self.stride = strides[-1]

    def forward(self, features: Tensor) -> Tensor:
        first, *middle, last = cast(list[nn.ConvTranspose2d], self.layers)
        x = F.elu(self._from_point(first, self.dense(features)))
        for layer in middle:
            x = F.elu(layer(x))
        weight = transposed_patch_kernel(last.weight, self.stride)
        bias = cast(Tensor, last.bias).repeat(self.stride ** 2)
        return F.conv2d(x, weight, bias, padding=weight.shape[-1] - 1).permute(0, 2, 3, 1)

    @staticmethod
    def _from_point(layer: nn.ConvTranspose2d, x: Tensor) -> Tensor:
        """A transposed convolution of one point is a product: (N, in) -> (N, out, k, k)."""
        inputs, out, kernel, _ = layer.weight.shape
        weight = layer.weight.permute(0, 2, 3, 1).reshape(inputs, -1)
        y = torch.addmm(cast(Tensor, layer.bias).repeat(kernel * kernel), x, weight)
        return y.view(-1, kernel, kernel, out).permute(0, 3, 1, 2)


class MLP(nn.Module):
    """Dense layers with ELU and one linear output: (..., inputs) -> (..., outputs)."""

    def __init__(self, inputs: int, units: int, layers: int, outputs: int):
        super().__init__()
        sizes = [inputs] + [units] * layers
        self.layers = nn.ModuleList(nn.Linear(i, o) for i, o in pairwise(sizes))
        self.out = nn.Linear(units, outputs)

    def forward(self, x: Tensor) -> Tensor:
        for layer in self.layers:
            x = F.elu(layer(x))
        return self.out(x)
