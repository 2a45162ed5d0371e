"""ELU by powers of two against torch's, and its gradient against autograd."""

import pytest
import torch
import torch.nn.functional as F

from curionav_cli.agents.elu import ENOUGH, elu, elu_

VALUES = torch.cat([torch.linspace(-30, 30, ENOUGH), -torch.logspace(-8, 1.9, ENOUGH)])


@pytest.mark.parametrize("part", [1000, 2**20])
def test_float32_is_right_to_a_ten_millionth(monkeypatch, part):
    monkeypatch.setattr("curionav_cli.agents.elu.PART", part)
    truth = F.elu(VALUES.double())
    assert (elu_(VALUES.clone()) - truth).abs().max() <= 1.2e-7 * 30  # the last bit of 30
    below = VALUES < 0
    assert (elu_(VALUES.clone()) - truth)[below].abs().max() <= 1.2e-7


def test_bfloat16_is_the_nearest_that_it_holds():
    """Of a float32 that is right to 1.2e-7: rounding adds at most 2^-8 of the value, on any processor."""
    x = VALUES.bfloat16()
    truth = F.elu(x.double())
    assert ((elu_(x.clone()) - truth).abs() <= 2.0**-8 * truth.abs() + 1.2e-7).all()


def test_what_is_not_a_number_or_not_finite():
    given = torch.tensor([torch.nan, torch.inf, -torch.inf, 1e5, -1e5, 0.0]).repeat(ENOUGH)
    torch.testing.assert_close(elu_(given.clone()), F.elu(given), equal_nan=True)


@pytest.mark.parametrize("kind", [torch.float32, torch.float64])
def test_its_gradient_is_that_of_torchs(kind):
    x = VALUES.to(kind).requires_grad_()
    slope = torch.linspace(-1, 2, len(x), dtype=kind)
    found, truth = (torch.autograd.grad((y * slope).sum(), x)[0] for y in (elu(x * 1), F.elu(x * 1)))
    torch.testing.assert_close(found, truth)
