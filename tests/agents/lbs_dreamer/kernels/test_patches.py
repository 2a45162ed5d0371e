"""Patches against plain slices of the image, and their convolutions against those on pixels."""

import pytest
import torch
import torch.nn.functional as F

from curionav_cli.agents.lbs_dreamer.kernels.patches import patch_kernel, pixels, to_images, to_patches

SIDES = pytest.mark.parametrize("side", [1, 2, 4])


@pytest.fixture
def image():
    return torch.randint(0, 256, (2, 64, 64, 3), dtype=torch.uint8, generator=torch.Generator().manual_seed(0))


@SIDES
def test_a_patch_is_a_square_of_the_image_row_by_row_and_the_way_back_is_exact(image, side):
    patches = to_patches(image, side)
    square = image[1, 2 * side:3 * side, 5 * side:6 * side].flatten().float() / 255 - 0.5
    torch.testing.assert_close(patches[1, 2, 5], square)
    assert patches.shape == (2, 64 // side, 64 // side, 3 * side * side)
    assert (to_images(patches, side) == image).all()


@SIDES
@pytest.mark.parametrize("transposed", [False, True])
def test_a_convolution_on_patches_is_that_on_pixels(image, side, transposed):
    generator = torch.Generator().manual_seed(1)
    weight = torch.randn(5, 3, 2 * side, 2 * side, dtype=torch.float64, generator=generator)
    if transposed:
        x = torch.randn(2, 5, 6, 6, dtype=torch.float64, generator=generator)
        ours = pixels(F.conv_transpose2d(x, patch_kernel(weight, side)), side)
        truth = F.conv_transpose2d(x, weight, stride=side)
    else:
        x, patches = (to_patches(image, s).double().permute(0, 3, 1, 2) for s in (1, side))
        ours, truth = F.conv2d(patches, patch_kernel(weight, side)), F.conv2d(x, weight, stride=side)
    torch.testing.assert_close(ours, truth)
