"""F.conv2d and F.conv_transpose2d without padding, composed of operations that are fast on a CPU.

Some of oneDNN's are slow: the gradient of a bias, which it computes together with the weight's (a plain sum takes a
hundredth of that); in float32 a convolution to few points and both its gradients (3.7, 3.9 and 4.0 times as long as
products, one core of an Intel Xeon, the last layer of scale=paper); and in bfloat16, beside what is done here, at the
shapes of scale=paper (one core of an AMD EPYC):

    a transposed convolution with a bias whose stride does not divide its kernel        four times as long
    the gradient of a kernel of many channels, beside products of windows               1.1 to 3.5 times
    a convolution to few points, and its gradient by its input                          2.8 and 2.1
    a transposed convolution whose stride divides its kernel, beside stride 1 to patches  1.2

A window is what a kernel covers of an image, row by row. Letters: N images, k kernel, s stride, c channels of the
smaller image of h x h points, C of the larger of H x H; weights are (c, C, k, k) both for a convolution, which goes
from the larger image to the smaller, and for a transposed one, which goes back.
"""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor

from curionav_cli.agents.lbs_dreamer.kernels.patches import empty_images, patch_kernel, pixels
from curionav_cli.agents.lbs_dreamer.kernels.precision import as_computed

MANY = 96  # channels of the smaller image, from which on products pay
FEW = 4  # points a side of it, below which they pay for a convolution and its gradient by the input
PART = 1250  # windows at a time, which stay in the caches


class Windows:
    """A convolution, or a transposed one, as matrix products with windows on a CPU."""

    def __init__(self, weight: Tensor, stride: int, points: int, size: int):
        self.stride, self.points, self.size = stride, points, size
        self.kernel, self.channels = weight.shape[-1], weight.shape[1]
        self.matrix = weight.permute(0, 2, 3, 1).flatten(1)  # (c, k * k * C)
        self.images = max(1, PART // points**2)

    def cut(self, large: Tensor) -> Tensor:
        """The windows: (N, C, H, H) -> (N * h * h, k * k * C)."""
        large = large.contiguous(memory_format=torch.channels_last)
        apart, _, row, column = large.stride()
        shape = len(large), self.points, self.points, self.kernel, self.kernel * self.channels
        cut = large.as_strided(shape, (apart, self.stride * row, self.stride * column, row, 1))
        return cut.reshape(-1, self.matrix.shape[1])

    def to_small(self, large: Tensor, bias: Tensor) -> Tensor:
        """The convolution: (N, C, H, H) -> (N, c, h, h)."""
        made = empty_images(large, len(self.matrix), self.points)
        torch.addmm(bias, self.cut(large), self.matrix.t(), out=rows(made))
        return made

    def to_large(self, small: Tensor) -> Tensor:
        """The gradient by the input: (N, c, h, h) -> (N, C, H, H)."""
        made = empty_images(small, self.channels, self.size)
        for part, whole in zip(small.split(self.images), made.split(self.images), strict=True):
            each = (rows(part) @ self.matrix).view(len(part), self.points, self.points, self.kernel, -1)
            total = torch.zeros(len(part), self.size, self.size * self.channels)
            for i in range(self.points):
                for j in range(self.points):
                    top, left = i * self.stride, j * self.stride * self.channels
                    total[:, top:top + self.kernel, left:left + each.shape[-1]] += each[:, i, j]
            whole.copy_(total.view(len(part), self.size, self.size, -1).permute(0, 3, 1, 2))
        return made

    def to_weight(self, small: Tensor, large: Tensor) -> Tensor:
        """The gradient by the weight (c, C, k, k) from the two images, one an input and the other a gradient."""
        found = torch.zeros(self.matrix.shape)
        for part, whole in zip(small.split(self.images), large.split(self.images), strict=True):
            found += rows(part).t() @ self.cut(whole)
        return found.view(len(found), self.kernel, self.kernel, -1).permute(0, 3, 1, 2).to(small.dtype)


def rows(x: Tensor) -> Tensor:
    """(N, c, h, h) -> (N * h * h, c)"""
    return x.permute(0, 2, 3, 1).flatten(0, 2)


def by_products(x: Tensor, weight: Tensor, stride: int, transposed: bool) -> Windows | None:
    """The products to compute x by; None where oneDNN is as fast, or does not compute."""
    kernel, size = weight.shape[-1], x.shape[-1]
    points, larger = (size, (size - 1) * stride + kernel) if transposed else ((size - kernel) // stride + 1, size)
    pays = {torch.bfloat16: len(weight) >= MANY, torch.float32: points < FEW and not transposed}
    return Windows(weight, stride, points, larger) if pays.get(x.dtype) and x.device.type == "cpu" else None


class _Convolution(torch.autograd.Function):
    """Each of the two convolutions and its gradients in the way that is fastest; torch's own on a GPU."""

    @staticmethod
    def forward(ctx, x, weight, bias, stride, transposed):
        ctx.save_for_backward(x, weight)
        ctx.stride, ctx.transposed = stride, transposed
        ctx.windows = windows = by_products(x, weight, stride, transposed)
        if not transposed:
            return windows.to_small(x, bias) if windows and windows.points < FEW else F.conv2d(x, weight, bias, stride)
        if weight.shape[-1] % stride and x.device.type == "cpu":
            return F.conv_transpose2d(x, weight, None, stride).add_(bias[:, None, None])
        if windows and stride > 1:
            patches = F.conv_transpose2d(x, patch_kernel(weight, stride), bias.repeat(stride * stride))
            return pixels(patches, stride)
        return F.conv_transpose2d(x, weight, bias, stride)

    @staticmethod
    def backward(ctx, gradient):
        x, weight = ctx.saved_tensors
        windows, (by_x, by_weight, *_) = ctx.windows, ctx.needs_input_grad
        up = windows and windows.points < FEW and not ctx.transposed
        stride, wanted = [ctx.stride] * 2, [by_x and not up, by_weight and not windows, False]
        to_x, to_weight, _ = torch.ops.aten.convolution_backward.default(
            gradient, x, weight, None, stride, [0, 0], [1, 1], ctx.transposed, [0, 0], 1, wanted)
        if by_x and up:
            to_x = windows.to_large(gradient)
        if by_weight and windows:
            to_weight = windows.to_weight(*((x, gradient) if ctx.transposed else (gradient, x)))
        return to_x, to_weight, gradient.sum((0, 2, 3)), None, None


def convolution(x: Tensor, weight: Tensor, bias: Tensor, stride: int = 1, transposed: bool = False) -> Tensor:
    """F.conv2d of x (N, C, H, H) or F.conv_transpose2d of x (N, c, h, h), without padding; weight (c, C, k, k)."""
    return _Convolution.apply(*as_computed(x, weight, bias), stride, transposed)


def transposed_to_patches(x: Tensor, weight: Tensor, bias: Tensor, stride: int) -> Tensor:
    """F.conv_transpose2d(x, weight, bias, stride) as patches (N, s * s * C, G, G); the stride divides the kernel."""
    return convolution(x, patch_kernel(weight, stride), bias.repeat(stride * stride), transposed=True)


def transposed_of_point(x: Tensor, weight: Tensor, bias: Tensor) -> Tensor:
    """F.conv_transpose2d of images of one point, x (N, c), as one product: (N, C, k, k)."""
    y = torch.mm(x, weight.flatten(1)).view(-1, *weight.shape[1:]) + bias[:, None, None]
    return y.contiguous(memory_format=torch.channels_last)
