"""Gradients that are composed by hand against torch's own, in float64 and, as near as it can be, in bfloat16."""

import math

import pytest
import torch
import torch.nn.functional as F

from curionav_cli.agents.lbs_dreamer.kernels.convolution import (
    MANY,
    by_products,
    convolution,
    transposed_of_point,
    transposed_to_patches,
)
from curionav_cli.agents.lbs_dreamer.kernels.patches import pixels

EPSILON = 2.0**-8  # the most by which rounding to bfloat16 changes a number, relative to it


def tensors(*shapes):
    generator = torch.Generator().manual_seed(0)
    return [torch.randn(*shape, dtype=torch.float64, generator=generator).requires_grad_() for shape in shapes]


def whole(*shapes, shares):
    """Of each tensor the given share of numbers is -1, 0 or 1, the rest 0."""
    generator = torch.Generator().manual_seed(0)
    return [(torch.randint(-1, 2, shape, generator=generator) * (torch.rand(shape, generator=generator) < share))
            .double().requires_grad_() for shape, share in zip(shapes, shares, strict=True)]


def with_gradients(y, given, slope):
    """y, and the derivatives of the sum of y * slope by each of what was given."""
    return y.detach().double(), *torch.autograd.grad((y.double() * slope).sum(), given)


def assert_near(found, truth, kernel, stride):
    """Within what bfloat16 can hold of sums of products, on any processor.

    Both factors and the sum are rounded once, each by EPSILON at most. Without native bfloat16, sums of the
    ceil(kernel / stride)^2 windows that cover a point are rounded once more after each window (torch's col2im).
    Roundings are independent, so the squares of what they change add up; every sum on the way counts as a whole one.
    """
    roundings = 3 + math.ceil(kernel / stride)**2
    assert (found - truth).norm() < EPSILON * math.sqrt(roundings) * truth.norm()


@pytest.mark.parametrize("transposed", [False, True])
def test_gradients_are_finite_differences(transposed):
    x, weight, bias = tensors((2, 3, 5, 5), (3, 3, 3, 3), (3,))
    assert torch.autograd.gradcheck(lambda *given: convolution(*given, 2, transposed), (x, weight, bias))


@pytest.mark.parametrize("inputs, kernel, stride", [(30, 6, 2), (16, 4, 4), (63, 2, 1)])
@pytest.mark.parametrize("half", [False, True])
def test_patches_are_the_pixels_of_a_transposed_convolution(inputs, kernel, stride, half):
    given = tensors((1, 4, inputs, inputs), (4, 3, kernel, kernel), (3,))
    with torch.autocast("cpu", torch.bfloat16, enabled=half):
        ours = pixels(transposed_to_patches(*given, stride), stride).permute(0, 2, 3, 1)
    truth = F.conv_transpose2d(*given, stride=stride).permute(0, 2, 3, 1)
    assert ours.dtype == (torch.bfloat16 if half else torch.float64)
    slope = torch.linspace(0, 1, truth.numel(), dtype=torch.float64).view(truth.shape)
    for one, other in zip(*(with_gradients(y, given, slope) for y in (ours, truth)), strict=True):
        if half:
            assert_near(one, other, kernel, stride)
        else:
            torch.testing.assert_close(one, other, rtol=0, atol=1e-10 * float(other.abs().max()))


def test_a_transposed_convolution_of_a_point_is_a_product():
    given = tensors((4, 6), (6, 3, 5, 5), (3,))
    ours, truth = transposed_of_point(*given), F.conv_transpose2d(given[0][:, :, None, None], *given[1:])
    slope = torch.linspace(0, 1, truth.numel(), dtype=torch.float64).view(truth.shape)
    torch.testing.assert_close(*(with_gradients(y, given, slope) for y in (ours, truth)))


WINDOWS = pytest.mark.parametrize("transposed, size, kernel, stride", [
    (False, 7, 4, 2),  # to few points, and a row that no window reaches
    (False, 14, 4, 2),
    (True, 5, 5, 2),  # a stride that does not divide its kernel
    (True, 9, 6, 2),  # one that does
])


def shapes(transposed, size, kernel):
    """Of an image of many or few channels, the weight and the bias."""
    many, few = MANY, 8
    return ((5, many if transposed else few, size, size), (many, few, kernel, kernel),
            (few if transposed else many,))


@pytest.fixture
def both(monkeypatch):
    """both(given, stride, transposed): in bfloat16, in several parts, and torch's own in float64."""
    def make(given, stride, transposed):
        monkeypatch.setattr("curionav_cli.agents.lbs_dreamer.kernels.convolution.PART", 2 * given[0].shape[-1]**2)
        assert by_products(given[0].bfloat16(), given[1], stride, transposed)
        with torch.autocast("cpu", torch.bfloat16):
            ours = convolution(*given, stride, transposed)
        truth = (F.conv_transpose2d if transposed else F.conv2d)(*given, stride)
        assert ours.shape == truth.shape and ours.dtype == torch.bfloat16
        return ours, truth
    return make


@WINDOWS
def test_products_of_windows_are_convolutions(both, transposed, size, kernel, stride):
    given = tensors(*shapes(transposed, size, kernel))
    ours, truth = both(given, stride, transposed)
    slope = torch.randn(truth.shape, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    for one, other in zip(*(with_gradients(y, given, slope) for y in (ours, truth)), strict=True):
        assert_near(one, other, kernel, stride)


@WINDOWS
def test_products_of_windows_are_exact_where_bfloat16_is(both, transposed, size, kernel, stride):
    """It holds every whole number up to 256: where no sum can leave these, no order of adding rounds anything."""
    given = whole(*shapes(transposed, size, kernel), shares=(0.1, 1, 1))
    ours, truth = both(given, stride, transposed)
    (slope,) = (one.detach() for one in whole(truth.shape, shares=(0.05,)))
    sizes = [one.detach().abs().requires_grad_() for one in given]
    most = with_gradients((F.conv_transpose2d if transposed else F.conv2d)(*sizes, stride), sizes, slope.abs())
    assert max(one.max() for one in most) <= 256
    for one, other in zip(*(with_gradients(y, given, slope) for y in (ours, truth)), strict=True):
        assert (one == other).all() and other.any()
