"""Encoder and decoder (DreamerV2, appendix D), with images held as patches.

Letters: N frames, k kernel, s stride, G = 64 / s patches a side, P = 3 s s numbers of a patch, E embedding.

A convolution of kernel k and stride s on pixels equals one of kernel k / s and stride 1 on s x s
patches, and the mirror image of that holds for the decoder's last layer. Both are computed on
patches, which is faster by half and exact; the parameters keep their usual shapes.
"""

from __future__ import annotations

from typing import cast

import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.kernels.convolution import convolution, pixels, to_patches_of
from curionav_cli.agents.lbs_dreamer.kernels.elu import elu
from curionav_cli.constants import IMAGE_CHANNELS, IMAGE_SIDE


def to_patches(image: Tensor, stride: int) -> Tensor:
    """Images (..., 64, 64, 3) uint8 -> patches (N, G, G, P) float in [-0.5, 0.5]."""
    grid = IMAGE_SIDE // stride
    word = {0: torch.int32, 2: torch.int16}.get(stride * IMAGE_CHANNELS % 4, torch.uint8)  # several bytes at a time
    rows = image.view(-1, grid, stride, grid, stride * IMAGE_CHANNELS).view(word).unbind(2)  # of a patch
    patches = torch.stack(rows, 3).view(torch.uint8).flatten(3)
    return patches.float().mul_(1 / 255).sub_(0.5)


def to_images(patches: Tensor, stride: int) -> Tensor:
    """The way back: (N, G, G, P) float -> (N, 64, 64, 3) uint8."""
    image = pixels(patches.float().permute(0, 3, 1, 2), stride).permute(0, 2, 3, 1)
    return ((image + 0.5) * 255).round().clamp(0, 255).to(torch.uint8)


def patch_kernel(weight: Tensor, stride: int) -> Tensor:
    """Convolution weight (out, 3, k, k) on pixels -> (out, P, k/s, k/s) on patches."""
    out, colours, kernel, _ = weight.shape
    reach = kernel // stride
    blocks = weight.view(out, colours, reach, stride, reach, stride)
    return blocks.permute(0, 3, 5, 1, 2, 4).reshape(out, stride * stride * colours, reach, reach)


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
        inputs = [IMAGE_CHANNELS, *channels[:-1]]
        layers = zip(inputs, channels, kernels, strides, strict=True)
        self.layers = nn.ModuleList(nn.Conv2d(i, o, k, s) for i, o, k, s in layers)
        self.stride = strides[0]
        side = IMAGE_SIDE
        for kernel, stride in zip(kernels, strides, strict=True):
            side = (side - kernel) // stride + 1
        self.size = side * side * channels[-1]

    def forward(self, patches: Tensor) -> Tensor:
        first, *rest = cast(list[nn.Conv2d], self.layers)
        x = convolution(patches.permute(0, 3, 1, 2), patch_kernel(first.weight, self.stride), cast(Tensor, first.bias))
        for layer in rest:
            x = convolution(elu(x), layer.weight, cast(Tensor, layer.bias), layer.stride[0])
        return elu(x).permute(0, 2, 3, 1).flatten(1)  # (N, E), rows and columns before channels as in Keras


class Decoder(nn.Module):
    """A dense layer and transposed convolutions with ELU, none on the last: (N, F) -> (N, G, G, P).

    The output is the mean of a normal distribution of variance one for every number of the image.
    """

    def __init__(self, features: int, units: int, channels: list[int], kernels: list[int],
                 strides: list[int]):
        super().__init__()
        self.dense = nn.Linear(features, units)
        sizes = [units, *channels, IMAGE_CHANNELS]
        layers = zip(sizes[:-1], sizes[1:], kernels, strides, strict=True)
        self.layers = nn.ModuleList(nn.ConvTranspose2d(i, o, k, s) for i, o, k, s in layers)
        self.stride = strides[-1]

    def forward(self, features: Tensor) -> Tensor:
        first, *middle, last = cast(list[nn.ConvTranspose2d], self.layers)
        x = elu(self._from_point(first, self.dense(features)))
        for layer in middle:
            x = elu(convolution(x, layer.weight, cast(Tensor, layer.bias), layer.stride[0], transposed=True))
        return to_patches_of(x, last.weight, cast(Tensor, last.bias), self.stride).permute(0, 2, 3, 1)

    @staticmethod
    def _from_point(layer: nn.ConvTranspose2d, x: Tensor) -> Tensor:
        """A transposed convolution of one point is a product: (N, in) -> (N, out, k, k)."""
        inputs, out, kernel, _ = layer.weight.shape
        weight = layer.weight.permute(0, 2, 3, 1).reshape(inputs, -1)
        y = torch.addmm(cast(Tensor, layer.bias).repeat(kernel * kernel), x, weight)
        return y.view(-1, kernel, kernel, out).permute(0, 3, 1, 2)
