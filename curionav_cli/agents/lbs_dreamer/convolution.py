"""Convolutions as torch has them, composed so that a CPU is quick at them.

Three of oneDNN's are slow: the gradient of a bias, which it finds together with the weight's (a plain sum takes a
hundredth of that); in bfloat16 the gradient of a kernel with few outputs on patches (eight times as long as on pixels);
and a transposed convolution with a bias whose stride does not divide its kernel (four times in bfloat16).
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor

SIDE, COLOURS = 64, 3


def pixels(patches: Tensor, stride: int) -> Tensor:
    """The image that patches (..., G, G, P) are of: (N, 64, 64, 3)."""
    grid = SIDE // stride
    return patches.reshape(-1, grid, grid, stride, stride, COLOURS).transpose(2, 3).reshape(-1, SIDE, SIDE, COLOURS)


def transposed_patch_kernel(weight: Tensor, stride: int) -> Tensor:
    """Transposed weight (in, 3, k, k) to pixels -> convolution weight (P, in, k/s, k/s) to patches.

    To be used with padding k/s - 1: a transposed convolution is a full correlation with the kernel
    turned round, here patch by patch and not inside a patch.
    """
    inputs, colours, kernel, _ = weight.shape
    reach = kernel // stride
    blocks = weight.view(inputs, colours, reach, stride, reach, stride).flip(2, 4)
    return blocks.permute(3, 5, 1, 0, 2, 4).reshape(stride * stride * colours, inputs, reach, reach)


def as_computed(*tensors: Tensor) -> list[Tensor]:
    """In the type that autocast, where it is on, wants products in."""
    device = tensors[0].device.type
    if not torch.amp.is_autocast_available(device) or not torch.is_autocast_enabled(device):
        return list(tensors)
    return [tensor.to(torch.get_autocast_dtype(device)) for tensor in tensors]


def slopes(gradient: Tensor, x: Tensor, weight: Tensor, stride: int, padding: int, transposed: bool,
           wanted: tuple[bool, bool]) -> tuple[Tensor | None, Tensor | None]:
    """The loss's derivatives by x and by the weight, where wanted."""
    strides, paddings, mask = [stride, stride], [padding, padding], [*wanted, False]
    to_x, to_weight, _ = torch.ops.aten.convolution_backward.default(
        gradient, x, weight, None, strides, paddings, [1, 1], transposed, [0, 0], 1, mask)
    return to_x, to_weight


class _Convolution(torch.autograd.Function):
    @staticmethod
    def forward(ctx, x, weight, bias, stride, transposed):
        ctx.save_for_backward(x, weight)
        ctx.stride, ctx.transposed = stride, transposed
        if transposed and weight.shape[-1] % stride and x.device.type == "cpu":
            return F.conv_transpose2d(x, weight, None, stride).add_(bias[:, None, None])
        return (F.conv_transpose2d if transposed else F.conv2d)(x, weight, bias, stride)

    @staticmethod
    def backward(ctx, gradient):
        x, weight = ctx.saved_tensors
        to_x, to_weight = slopes(gradient, x, weight, ctx.stride, 0, ctx.transposed, ctx.needs_input_grad[:2])
        return to_x, to_weight, gradient.sum((0, 2, 3)), None, None


def convolution(x: Tensor, weight: Tensor, bias: Tensor, stride: int = 1, transposed: bool = False) -> Tensor:
    """F.conv2d or F.conv_transpose2d, without padding."""
    return _Convolution.apply(*as_computed(x, weight, bias), stride, transposed)


class _ToPatches(torch.autograd.Function):
    """Forward and by x on patches, by the weight on pixels."""

    @staticmethod
    def forward(ctx, x, weight, bias, stride):
        kernel = transposed_patch_kernel(weight, stride)
        ctx.save_for_backward(x, weight, kernel)
        ctx.stride = stride
        return F.conv2d(x, kernel, bias.repeat(stride * stride), padding=kernel.shape[-1] - 1)

    @staticmethod
    def backward(ctx, gradient):
        x, weight, kernel = ctx.saved_tensors
        to_x, _ = slopes(gradient, x, kernel, 1, kernel.shape[-1] - 1, False, (True, False))
        image = pixels(gradient.permute(0, 2, 3, 1), ctx.stride).permute(0, 3, 1, 2)
        _, to_weight = slopes(image, x, weight, ctx.stride, 0, True, (False, True))
        return to_x, to_weight, image.sum((0, 2, 3)), None


def to_patches_of(x: Tensor, weight: Tensor, bias: Tensor, stride: int) -> Tensor:
    """F.conv_transpose2d(x, weight, bias, stride) to 64 x 64 pixels, given as patches (N, P, G, G)."""
    return _ToPatches.apply(*as_computed(x, weight, bias), stride)
