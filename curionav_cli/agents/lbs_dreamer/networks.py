"""Encoder and decoder p(x | s) (paper, "World model"; DreamerV2, appendix D), on images held as patches.

The encoder's first layer and the decoder's last are computed on patches (kernels/patches.py), exactly; their parameters
have the shapes of convolutions on pixels.

Letters: N frames, s stride, G = 64 / s patches a side, P = 3 * s * s numbers of a patch, E embedding, F features.
"""

from __future__ import annotations

from typing import cast

import torch
from torch import Tensor, nn

from curionav_cli.agents.elu import InPlace, elu, elu_
from curionav_cli.agents.lbs_dreamer.kernels.convolution import convolution, transposed_of_point, transposed_to_patches
from curionav_cli.agents.lbs_dreamer.kernels.patches import patch_kernel
from curionav_cli.constants import IMAGE_CHANNELS, IMAGE_SIDE


def initialise(module: nn.Module, generator: torch.Generator) -> None:
    """Draw Glorot-uniform weights; zero biases, LayerNorm weights of one (DreamerV2 by Keras' defaults)."""
    for part in module.modules():
        if isinstance(part, (nn.Linear, nn.Conv2d, nn.ConvTranspose2d)):
            nn.init.xavier_uniform_(part.weight, generator=generator)
            nn.init.zeros_(cast(Tensor, part.bias))
        elif isinstance(part, nn.LayerNorm):
            nn.init.ones_(part.weight)
            nn.init.zeros_(part.bias)


class Encoder(nn.Module):
    """Convolutions with ELU, no padding: patches (N, G, G, P) -> embeddings (N, E)."""

    def __init__(self, channels: list[int], kernels: list[int], strides: list[int]):
        super().__init__()
        self.elu: InPlace = elu_
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
            x = convolution(elu(x, self.elu), layer.weight, cast(Tensor, layer.bias), layer.stride[0])
        return elu(x, self.elu).permute(0, 2, 3, 1).flatten(1)  # (N, E), rows and columns before channels as in Keras


class Decoder(nn.Module):
    """A dense layer and transposed convolutions with ELU, none on the last: features (N, F) -> patches (N, G, G, P).

    The output is the mean of p(x | s), a normal distribution of variance one for every number of the image.
    """

    def __init__(self, features: int, units: int, channels: list[int], kernels: list[int],
                 strides: list[int]):
        super().__init__()
        self.elu: InPlace = elu_
        self.dense = nn.Linear(features, units)
        sizes = [units, *channels, IMAGE_CHANNELS]
        layers = zip(sizes[:-1], sizes[1:], kernels, strides, strict=True)
        self.layers = nn.ModuleList(nn.ConvTranspose2d(i, o, k, s) for i, o, k, s in layers)
        self.stride = strides[-1]

    def forward(self, features: Tensor) -> Tensor:
        first, *middle, last = cast(list[nn.ConvTranspose2d], self.layers)
        x = transposed_of_point(self.dense(features), first.weight, cast(Tensor, first.bias))  # (N, c, k, k)
        for layer in middle:
            x = convolution(elu(x, self.elu), layer.weight, cast(Tensor, layer.bias), layer.stride[0], transposed=True)
        x = elu(x, self.elu)
        return transposed_to_patches(x, last.weight, cast(Tensor, last.bias), self.stride).permute(0, 2, 3, 1)
