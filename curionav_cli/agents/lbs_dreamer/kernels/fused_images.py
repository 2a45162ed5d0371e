"""Encoder, and decoder with its squared error, in float32 on a CPU: each and its gradient in one call of numba.

The same computation as networks.py on patches but for rounding. A few images at a time go through all layers, so that
what a layer makes is in the caches when the next one reads it. A convolution is a product of windows (windows.py) with
a matrix. Letters: N images, E embedding, G patches a side of P numbers; a layer has kernel k, stride s, c channels of
its smaller image and C of its larger, and the matrix (c, k * k * C).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, cast

import numpy as np
import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.kernels import rows, windows
from curionav_cli.agents.lbs_dreamer.kernels.patches import patch_kernel
from curionav_cli.agents.lbs_dreamer.networks import Decoder, Encoder
from curionav_cli.constants import IMAGE_SIDE

PART = 8  # images at a time
MANY = 96  # channels from which on convolutions are left to oneDNN; not measured
Geometry = tuple[tuple[int, int, int, int], ...]  # kernel, stride, points of the larger image, of the smaller


@rows.compiled
def encode(image, strides, matrices, biases, patches, buffers, made):
    """Fill `made`, for each layer its results (N, h, h, c), from bytes; patches and buffers: of PART images."""
    part = len(buffers[0])
    for first in range(0, len(image), part):
        last = min(first + part, len(image))
        source = patches[:last - first]
        windows.scaled(image[first:last].reshape(-1), source.reshape(-1))
        for i in range(len(made)):
            target = made[i][first:last]
            flat = windows.seen_by(source, strides[i], buffers[i][:last - first])
            np.dot(flat, matrices[i].T, windows.as_points(target))
            rows.add_bias_elu(windows.image_rows(target), biases[i])
            source = target


@rows.compiled
def encode_backward(slope, image, strides, matrices, patches, buffers, made, to_matrices, to_biases):
    """Add the gradients of matrices and biases to the last two from `slope` (N, h, h, c), which is overwritten."""
    part = len(buffers[0])
    for first in range(0, len(image), part):
        last = min(first + part, len(image))
        bytes_ = patches[:last - first]
        windows.scaled(image[first:last].reshape(-1), bytes_.reshape(-1))
        above = slope[first:last]
        for layer in range(len(made)):
            i = len(made) - 1 - layer
            source = bytes_ if i == 0 else made[i - 1][first:last]
            rows.elu_slope(windows.image_rows(above), windows.image_rows(made[i][first:last]))
            windows.add_sums(above, to_biases[i])
            buffer = buffers[i][:last - first]
            windows.add_product(windows.as_points(above), windows.seen_by(source, strides[i], buffer), to_matrices[i])
            if i > 0:
                below = np.empty(source.shape, np.float32)
                windows.put(windows.as_points(above), matrices[i], strides[i], buffer, below)
                above = below


@rows.compiled
def drawn(point, size, first_bias, strides, matrices, biases, buffers, made):
    """Decode `size` images into `made`, from point (size, c, k * k); the last as patches, without an ELU."""
    base = made[0][:size]
    windows.swapped(point, base.reshape(size, -1, base.shape[3]))
    rows.add_bias_elu(windows.image_rows(base), first_bias)
    for i in range(len(matrices)):
        target = made[i + 1][:size]
        windows.put(windows.as_points(made[i][:size]), matrices[i], strides[i], buffers[i][:size], target)
        if i < len(matrices) - 1:
            rows.add_bias_elu(windows.image_rows(target), biases[i])
        else:
            rows.add_bias(windows.image_rows(target), biases[i])


@rows.compiled
def drawn_backward(slope, size, strides, matrices, buffers, made, to_point, to_first_bias, to_matrices, to_biases):
    """Set the gradient of `point`, and add those of the weights, from `slope` (size, G, G, P)."""
    above = slope
    for layer in range(len(matrices)):
        i = len(matrices) - 1 - layer
        source = made[i][:size]
        windows.add_sums(above, to_biases[i])
        flat = windows.seen_by(above, strides[i], buffers[i][:size])
        windows.add_product(windows.as_points(source), flat, to_matrices[i])
        below = np.empty(source.shape, np.float32)
        np.dot(flat, matrices[i].T, windows.as_points(below))
        rows.elu_slope(windows.image_rows(below), windows.image_rows(source))
        above = below
    windows.add_sums(above, to_first_bias)
    windows.swapped(above.reshape(size, -1, above.shape[3]), to_point)


@rows.compiled
def decode(point, first_bias, image, strides, matrices, biases, buffers, made, scale, to_point, to_first_bias,
           to_matrices, to_biases):
    """The squared error of decoded images, summed, and `scale` times its gradients in the last four arguments.

    point (N, c, k * k): the first layer's product, without bias. buffers: windows of PART images; made: the
    results of all layers, the last as patches, and the patches of the images, (PART, h, h, c) each.
    """
    error, part = 0.0, len(buffers[0])
    for first in range(0, len(image), part):
        last = min(first + part, len(image))
        size = last - first
        drawn(point[first:last], size, first_bias, strides, matrices, biases, buffers, made)
        decoded, goal = made[len(matrices)][:size], made[len(matrices) + 1][:size]
        windows.scaled(image[first:last].reshape(-1), goal.reshape(-1))
        error += difference(decoded.reshape(-1), goal.reshape(-1), scale)
        drawn_backward(decoded, size, strides, matrices, buffers, made, to_point[first:last], to_first_bias,
                       to_matrices, to_biases)
    return error


@rows.compiled
def difference(decoded, goal, scale):
    """decoded (n,) = 2 * scale * (decoded - goal), in place; returns the sum of squared differences."""
    total, twice = rows.ZERO, rows.TWO * scale
    for i in range(len(decoded)):
        apart = decoded[i] - goal[i]
        total += apart * apart
        decoded[i] = apart * twice
    return total


def buffers_of(geometry: Geometry, channels: list[int]) -> tuple[np.ndarray, ...]:
    """Uninitialised windows of PART images of each layer; channels: of each layer's larger image."""
    return tuple(np.empty((PART, small, small, kernel, kernel * many), np.float32)
                 for (kernel, _, _, small), many in zip(geometry, channels, strict=True))


def arrays(tensors: Any) -> tuple[np.ndarray, ...]:
    return tuple(tensor.detach().contiguous().numpy() for tensor in tensors)


def called(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a compiled function, whose number of arguments mypy does not know."""
    return function(*arguments)


def along(biases: Iterable[np.ndarray], made: Iterable[np.ndarray]) -> tuple[np.ndarray, ...]:
    """Biases (c,) for a row of the results (N, h, h, c): (h * c,) each."""
    return tuple(np.tile(bias, result.shape[2]) for bias, result in zip(biases, made, strict=False))


class _Encode(torch.autograd.Function):
    """Embeddings (N, E) of bytes (N, 64, 64, 3); no gradient of these."""

    @staticmethod
    def forward(ctx, image, geometry, channels, *weights):
        count = len(geometry)
        matrices, biases = arrays(weights[:count]), arrays(weights[count:])
        grid = image.shape[1]
        made = tuple(np.empty((len(image), shape[3], shape[3], len(bias)), np.float32)
                     for shape, bias in zip(geometry, biases, strict=True))
        ctx.kept = (image.numpy(), tuple(shape[1] for shape in geometry), matrices,
                    np.empty((PART, grid, grid, channels[0]), np.float32), buffers_of(geometry, channels))
        ctx.made = made
        image, strides, matrices, patches, buffers = ctx.kept
        called(encode, image, strides, matrices, along(biases, made), patches, buffers, made)
        return torch.from_numpy(made[-1]).flatten(1)

    @staticmethod
    def backward(ctx, slope):
        matrices = ctx.kept[2]
        to_matrices = tuple(np.zeros_like(matrix) for matrix in matrices)
        to_biases = tuple(np.zeros(len(matrix), np.float32) for matrix in matrices)
        above = slope.contiguous().clone().numpy().reshape(ctx.made[-1].shape)
        called(encode_backward, above, *ctx.kept, ctx.made, to_matrices, to_biases)
        return None, None, None, *map(torch.from_numpy, (*to_matrices, *to_biases))


class _Decode(torch.autograd.Function):
    """The mean of squared errors, summed over an image; its gradients are computed at once."""

    @staticmethod
    def forward(ctx, point, first_bias, image, geometry, *weights):
        count, channels = len(geometry), len(first_bias)
        matrices, biases = arrays(weights[:count]), arrays(weights[count:])
        sides = [geometry[0][3], *(shape[2] for shape in geometry), geometry[-1][2]]
        widths = [channels, *map(len, biases), len(biases[-1])]
        made = tuple(np.empty((PART, side, side, width), np.float32)
                     for side, width in zip(sides, widths, strict=True))
        strides = tuple(shape[1] for shape in geometry)
        given = point.detach().numpy().reshape(len(image), channels, -1)
        ctx.found = [np.empty_like(given), np.zeros(channels, np.float32),
                     tuple(np.zeros_like(matrix) for matrix in matrices), tuple(np.zeros_like(bias) for bias in biases)]
        first, *others = along((first_bias.detach().numpy(), *biases), made)
        error = called(decode, given, first, image.numpy(), strides, matrices, tuple(others),
                       buffers_of(geometry, widths[1:-1]), made, np.float32(1 / len(image)), *ctx.found)
        ctx.shape = point.shape
        return point.new_tensor(error / len(image))

    @staticmethod
    def backward(ctx, slope):
        to_point, to_bias, to_matrices, to_biases = ctx.found
        first, *others = torch._foreach_mul([torch.from_numpy(found) for found in
                                             (to_point, to_bias, *to_matrices, *to_biases)], slope)
        return first.view(ctx.shape), others[0], None, None, *others[1:]


def matrix_of(weight: Tensor) -> Tensor:
    """A weight (c, C, k, k) as a matrix (c, k * k * C)."""
    return weight.permute(0, 2, 3, 1).flatten(1)


def encoded(encoder: Encoder, image: Tensor) -> Tensor:
    """Encoder.forward from bytes (N, 64, 64, 3): (N, E)."""
    first, *rest = cast(list[nn.Conv2d], list(encoder.layers))
    weights = [patch_kernel(first.weight, encoder.stride), *(layer.weight for layer in rest)]
    side, geometry = IMAGE_SIDE // encoder.stride, []
    for weight, stride in zip(weights, [1, *(layer.stride[0] for layer in rest)], strict=True):
        kernel, large = weight.shape[-1], side
        side = (side - kernel) // stride + 1
        geometry.append((kernel, stride, large, side))
    return _Encode.apply(image, tuple(geometry), [weight.shape[1] for weight in weights],
                         *map(matrix_of, weights), *(cast(Tensor, layer.bias) for layer in encoder.layers))


def decoded_error(decoder: Decoder, features: Tensor, image: Tensor) -> Tensor:
    """WorldModel.image_error from features (N, F) and bytes (N, 64, 64, 3): scalar."""
    first, *rest = cast(list[nn.ConvTranspose2d], list(decoder.layers))
    point = decoder.dense(features) @ first.weight.flatten(1)  # (N, c * k * k)
    last = cast(Tensor, rest[-1].bias).repeat(decoder.stride**2)
    weights = [*(layer.weight for layer in rest[:-1]), patch_kernel(rest[-1].weight, decoder.stride)]
    side, geometry = first.weight.shape[-1], []
    for weight, stride in zip(weights, [*(layer.stride[0] for layer in rest[:-1]), 1], strict=True):
        kernel, small = weight.shape[-1], side
        side = (side - 1) * stride + kernel
        geometry.append((kernel, stride, side, small))
    return _Decode.apply(point, first.bias, image, tuple(geometry), *map(matrix_of, weights),
                         *(layer.bias for layer in rest[:-1]), last)


def pays(encoder: Encoder, decoder: Decoder) -> bool:
    """Tell whether all layers are narrow enough."""
    layers = [*encoder.layers, *decoder.layers[1:]]
    return len(decoder.layers) > 1 and all(max(layer.weight.shape[:2]) < MANY for layer in layers)
