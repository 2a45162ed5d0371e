"""Windows of images as rows of matrices, and the parts of convolutions beside products, compiled by numba.

A window is what a kernel covers of an image, row by row. Letters: N images of H x H points, C channels, h x h windows
of k x k points. Arrays are contiguous, channels last; float32 but for bytes.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.lbs_dreamer.kernels import rows

LEVEL, HALF = np.float32(1 / 255), np.float32(0.5)


@rows.compiled
def scaled(levels, made):
    """made (n,) float32 in [-0.5, 0.5] from bytes (n,), as patches.to_patches."""
    for i in range(len(made)):
        made[i] = np.float32(levels[i]) * LEVEL - HALF


@rows.compiled
def cut(images, stride, windows):
    """windows (N, h, h, k, k * C) from images (N, H, H, C)."""
    points, kernel, width = np.uint64(windows.shape[1]), np.uint64(windows.shape[3]), np.uint64(windows.shape[4])
    side, channels = np.uint64(images.shape[1]), np.uint64(images.shape[3])
    source, made, step, to = images.reshape(-1), windows.reshape(-1), np.uint64(stride), np.uint64(0)
    for image in range(np.uint64(len(images))):
        for i in range(points):
            for j in range(points):
                for row in range(kernel):
                    start = ((image * side + i * step + row) * side + j * step) * channels
                    for x in range(width):
                        made[to + x] = source[start + x]
                    to += width


@rows.compiled
def add(windows, stride, images):
    """images (N, H, H, C) = the sums of windows (N, h, h, k, k * C) where they overlap; zero where none is."""
    points, kernel, width = np.uint64(windows.shape[1]), np.uint64(windows.shape[3]), np.uint64(windows.shape[4])
    side, channels = np.uint64(images.shape[1]), np.uint64(images.shape[3])
    source, made, step, at = windows.reshape(-1), images.reshape(-1), np.uint64(stride), np.uint64(0)
    made[:] = rows.ZERO
    for image in range(np.uint64(len(images))):
        for i in range(points):
            for j in range(points):
                for row in range(kernel):
                    start = ((image * side + i * step + row) * side + j * step) * channels
                    for x in range(width):
                        made[start + x] += source[at + x]
                    at += width


@rows.compiled
def image_rows(images):
    """The same memory as rows of an image each, (N * H, H * C): long enough for vector registers."""
    return images.reshape(images.shape[0] * images.shape[1], images.shape[2] * images.shape[3])


@rows.compiled
def as_points(images):
    """The same memory as points, (N * H * H, C)."""
    return images.reshape(images.shape[0] * images.shape[1] * images.shape[2], images.shape[3])


@rows.compiled
def add_sums(images, total):
    """total (C,) += the sums over all points of images (N, H, H, C)."""
    wide, channels = image_rows(images), images.shape[3]
    each = np.zeros(wide.shape[1], np.float32)
    for row in range(len(wide)):
        for i in range(wide.shape[1]):
            each[i] += wide[row, i]
    for i in range(len(each)):
        total[i % channels] += each[i]


@rows.compiled
def swapped(source, made):
    """made (N, b, a) = source (N, a, b)."""
    for n in range(len(source)):
        for i in range(made.shape[1]):
            for j in range(made.shape[2]):
                made[n, i, j] = source[n, j, i]


@rows.compiled
def seen_by(source, stride, buffer):
    """The windows of source (N, H, H, C) as rows; where a window is a point, source itself."""
    if buffer.shape[3] == 1 and stride == 1:
        return as_points(source)
    cut(source, stride, buffer)
    return buffer.reshape(-1, buffer.shape[3] * buffer.shape[4])


@rows.compiled
def put(small, matrix, stride, buffer, large):
    """large (N, H, H, C): what small (N * h * h, c) is of, windows added where they overlap."""
    if buffer.shape[3] == 1 and stride == 1:
        np.dot(small, matrix, as_points(large))
    else:
        np.dot(small, matrix, buffer.reshape(-1, matrix.shape[1]))
        add(buffer, stride, large)


@rows.compiled
def add_product(left, right, total):
    """total (a, b) += left^T right, of left (n, a) and right (n, b)."""
    found = np.dot(left.T, right)
    for i in range(total.shape[0]):
        for j in range(total.shape[1]):
            total[i, j] += found[i, j]
