"""Gradients that are composed by hand against torch's own, in float64 and, nearly, in bfloat16."""

import pytest
import torch
import torch.nn.functional as F

from curionav_cli.agents.lbs_dreamer.convolution import MANY, by_products, convolution, pixels, to_patches_of


def tensors(*shapes):
    generator = torch.Generator().manual_seed(0)
    return [torch.randn(*shape, dtype=torch.float64, generator=generator).requires_grad_() for shape in shapes]


@pytest.mark.parametrize("transposed", [False, True])
def test_gradients_are_finite_differences(transposed):
    x, weight, bias = tensors((2, 3, 5, 5), (3, 3, 3, 3), (3,))
    assert torch.autograd.gradcheck(lambda *given: convolution(*given, 2, transposed), (x, weight, bias))


@pytest.mark.parametrize("inputs, kernel, stride", [(30, 6, 2), (16, 4, 4), (63, 2, 1)])
@pytest.mark.parametrize("half", [False, True])
def test_patches_are_the_pixels_of_a_transposed_convolution(inputs, kernel, stride, half):
    given = tensors((1, 4, inputs, inputs), (4, 3, kernel, kernel), (3,))
    with torch.autocast("cpu", torch.bfloat16, enabled=half):
        ours = pixels(to_patches_of(*given, stride), stride).permute(0, 2, 3, 1)
    truth = F.conv_transpose2d(*given, stride=stride).permute(0, 2, 3, 1)
    assert ours.dtype == (torch.bfloat16 if half else torch.float64)
    near = {"rtol": 0.02, "atol": 0.1} if half else {}
    torch.testing.assert_close(ours.double(), truth, **near)
    slope = torch.linspace(0, 1, truth.numel(), dtype=torch.float64).view(truth.shape)
    found, true = (torch.autograd.grad((y.double() * slope).sum(), given) for y in (ours, truth))
    for one, other in zip(found, true, strict=True):
        limit = 0.02 * other.abs().max() if half else 1e-10 * other.abs().max()
        torch.testing.assert_close(one, other, rtol=0, atol=float(limit))


@pytest.mark.parametrize("transposed, size, kernel, stride", [
    (False, 7, 4, 2),  # to few points, and a row that no window reaches
    (False, 14, 4, 2),
    (True, 5, 5, 2),  # a stride that does not divide its kernel
    (True, 9, 6, 2),  # one that does
])
def test_products_of_windows_are_convolutions(monkeypatch, transposed, size, kernel, stride):
    """In bfloat16 and with many channels, in several parts, against torch's own in float64."""
    monkeypatch.setattr("curionav_cli.agents.lbs_dreamer.convolution.PART", 2 * size**2)
    many, few = MANY, 8
    given = tensors((5, many if transposed else few, size, size), (many, few, kernel, kernel),
                    (few if transposed else many,))
    assert by_products(given[0].bfloat16(), given[1], stride, transposed)
    with torch.autocast("cpu", torch.bfloat16):
        ours = convolution(*given, stride, transposed)
    truth = (F.conv_transpose2d if transposed else F.conv2d)(*given, stride)
    assert ours.shape == truth.shape and ours.dtype == torch.bfloat16
    slope = torch.randn(truth.shape, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    found, true = (torch.autograd.grad((y.double() * slope).sum(), given) for y in (ours, truth))
    for one, other in zip((ours, *found), (truth, *true), strict=True):
        assert (one - other).norm() < 0.006 * other.norm()
