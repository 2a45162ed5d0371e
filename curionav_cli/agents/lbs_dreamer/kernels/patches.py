"""Images as patches of s x s pixels, on which a convolution of stride s is one of stride 1.

A convolution of kernel k and stride s on pixels equals one of kernel k / s and stride 1 on patches, and the
mirror image of that holds for a transposed one. Both are exact, and faster by half on patches.

Letters: N images, C channels, c channels of the other side, k kernel, s stride, G = H / s patches a side of an image of
H x H pixels, P = s * s * C numbers of a patch.
"""

from __future__ import annotations

import torch
from torch import Tensor

from curionav_cli.constants import IMAGE_CHANNELS, IMAGE_SIDE


def to_patches(image: Tensor, stride: int) -> Tensor:
    """Images (..., 64, 64, 3) uint8 -> patches (N, G, G, P) float32 in [-0.5, 0.5]."""
    return to_byte_patches(image, stride).float().mul_(1 / 255).sub_(0.5)


def to_byte_patches(image: Tensor, stride: int) -> Tensor:
    """Images (..., 64, 64, 3) uint8 -> patches (N, G, G, P) uint8."""
    grid = IMAGE_SIDE // stride
    word = {0: torch.int32, 2: torch.int16}.get(stride * IMAGE_CHANNELS % 4, torch.uint8)  # several bytes at a time
    rows = image.view(-1, grid, stride, grid, stride * IMAGE_CHANNELS).view(word).unbind(2)  # of a patch
    return torch.stack(rows, 3).view(torch.uint8).flatten(3)


def to_images(patches: Tensor, stride: int) -> Tensor:
    """The inverse of `to_patches`, rounded and clipped: (N, G, G, P) float -> (N, 64, 64, 3) uint8."""
    image = pixels(patches.float().permute(0, 3, 1, 2), stride).permute(0, 2, 3, 1)
    return ((image + 0.5) * 255).round().clamp(0, 255).to(torch.uint8)


def pixels(patches: Tensor, stride: int) -> Tensor:
    """Patches (N, P, G, G) -> the images (N, C, H, H) that they are of, channels last in memory."""
    images, numbers, grid, _ = patches.shape
    made = empty_images(patches, numbers // stride**2, grid * stride)
    blocks = patches.permute(0, 2, 3, 1).reshape(images, grid, grid, stride, stride, -1)
    made.permute(0, 2, 3, 1).view(images, grid, stride, grid, stride, -1).copy_(blocks.transpose(2, 3))
    return made


def patch_kernel(weight: Tensor, stride: int) -> Tensor:
    """A weight (c, C, k, k), of a convolution or a transposed one, for stride 1 on patches: (c, P, k/s, k/s)."""
    small, channels, kernel, _ = weight.shape
    reach = kernel // stride
    blocks = weight.view(small, channels, reach, stride, reach, stride)
    return blocks.permute(0, 3, 5, 1, 2, 4).reshape(small, stride * stride * channels, reach, reach)


def empty_images(like: Tensor, channels: int, size: int) -> Tensor:
    """Uninitialised images (N, channels, size, size), N as `like` has, channels last in memory."""
    shape = len(like), channels, size, size
    return torch.empty(shape, dtype=like.dtype, device=like.device, memory_format=torch.channels_last)
