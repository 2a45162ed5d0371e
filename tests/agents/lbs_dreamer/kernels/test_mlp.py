"""The MLP's gradient by hand against autograd through torch's own layers."""

import pytest
import torch
from torch import nn

from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.networks import initialise

S, C, OTHER, ROWS = 3, 4, 5, 11


@pytest.fixture
def mlp():
    made = MLP(S * C + OTHER, units=6, layers=3, outputs=2, hot=S * C)
    initialise(made, torch.Generator().manual_seed(0))
    return made.double()


@pytest.fixture
def ones():
    """(1, ROWS, S): one of each latent's classes."""
    return torch.randint(0, C, (1, ROWS, S), generator=torch.Generator().manual_seed(1)) + C * torch.arange(S)


@pytest.fixture
def x(ones):
    generator = torch.Generator().manual_seed(2)
    hot = torch.zeros(1, ROWS, S * C, dtype=torch.float64).scatter(-1, ones, 1.0)
    return torch.cat([hot, torch.randn(1, ROWS, OTHER, dtype=torch.float64, generator=generator)], -1)


def plain(mlp, x):
    """The same of torch's own layers, which share its weights."""
    return nn.Sequential(*(part for layer in mlp.layers for part in (layer, nn.ELU())), mlp.out)(x)


def gradients(mlp, y):
    slope = torch.linspace(-1, 2, y.numel(), dtype=torch.float64).view(y.shape)
    return torch.autograd.grad((y * slope).sum(), tuple(mlp.parameters()))


@pytest.mark.parametrize("part", [4, 100])  # several, and one
@pytest.mark.parametrize("given", ["nothing", "ones", "known"])
def test_outputs_and_gradients_are_those_of_plain_layers(monkeypatch, mlp, x, ones, given, part):
    monkeypatch.setattr("curionav_cli.agents.lbs_dreamer.kernels.mlp.PART", part)
    others = {"nothing": {}, "ones": {"ones": ones}, "known": {"known": mlp.activations(x)}}[given]
    ours, truth = mlp(x, **others), plain(mlp, x)
    torch.testing.assert_close(ours, truth)
    torch.testing.assert_close(gradients(mlp, ours), gradients(mlp, truth))
    with torch.no_grad():
        torch.testing.assert_close(mlp(x, **others), truth)


def test_what_is_known_is_not_computed_again(monkeypatch, mlp, x):
    known = mlp.activations(x)
    monkeypatch.setattr(mlp, "activations", None)
    assert (mlp(x, known=known) == known[-1]).all()


@pytest.mark.parametrize("given", ["nothing", "ones"])
def test_bfloat16_is_as_near_as_it_can_be(mlp, x, ones, given):
    """To float64. A layer rounds its inputs, its weights and its sums, each by 2^-8 at most, there and back again.

    Roundings are independent, so the squares of what they change add up, and ELU makes no change larger.
    """
    truth = plain(mlp, x)
    exact = (truth, *gradients(mlp, truth))
    mlp.float()
    with torch.autocast("cpu", torch.bfloat16):
        ours = mlp(x.float(), ones if given == "ones" else None)
    assert ours.dtype == torch.bfloat16
    found = (ours, *gradients(mlp, ours))
    layers = len(mlp.layers) + 1
    for one, other, roundings in zip(found, exact, [3 * layers] + [6 * layers] * (len(found) - 1), strict=True):
        assert one is ours or one.dtype == torch.float32
        assert (one - other).norm() < 2.0**-8 * roundings**0.5 * other.norm()


def test_the_inputs_get_no_gradient(mlp, x):
    assert not torch.autograd.grad(mlp(x.requires_grad_()).sum(), (x, mlp.out.bias), allow_unused=True)[0]
