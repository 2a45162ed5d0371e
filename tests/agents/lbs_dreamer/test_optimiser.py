"""Clipping, decay apart from the gradient, and Adam's own arithmetic."""

import torch
from torch import nn

from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser


def layer():
    module = nn.Linear(3, 2)
    with torch.no_grad():
        module.weight.copy_(torch.arange(6.0).view(2, 3) - 2)
        module.bias.fill_(1)
    return module


def test_without_gradient_every_tensor_shrinks_by_the_decay():
    module = layer()
    before = [p.detach().clone() for p in module.parameters()]
    Optimiser(module, 0.1, 1e-5, 1e-6, 100).step(sum((p * 0).sum() for p in module.parameters()))
    for old, new in zip(before, module.parameters(), strict=True):
        assert (new == old * (1 - 1e-6)).all()


def test_three_steps_are_adams():
    module, beta1, beta2, rate, epsilon, decay = layer(), 0.9, 0.999, 0.01, 1e-5, 1e-3
    optimiser = Optimiser(module, rate, epsilon, decay, 1e9)
    weight = module.weight.detach().clone().double()
    first = second = torch.zeros_like(weight)
    for step in range(1, 4):
        optimiser.step((module.weight ** 3).sum() + module.bias.sum())
        gradient = 3 * weight ** 2
        weight = weight * (1 - decay)
        first, second = beta1 * first + (1 - beta1) * gradient, beta2 * second + (1 - beta2) * gradient ** 2
        size = (second / (1 - beta2 ** step)).sqrt() + epsilon
        weight = weight - rate * first / (1 - beta1 ** step) / size
    torch.testing.assert_close(module.weight.detach().double(), weight, atol=1e-5, rtol=1e-5)


def test_only_its_own_parameters_move():
    mine, other = layer(), layer()
    Optimiser(mine, 0.1, 1e-5, 0, 100).step((mine(torch.ones(3)) * other(torch.ones(3))).sum())
    assert all(p.grad is None for p in other.parameters())
    assert (other.bias == 1).all() and (mine.bias != 1).all()


def test_a_gradient_in_another_memory_layout_reaches_the_right_weights():
    """Convolutions on channels-last images give such gradients, and Adam's fused kernel does not look."""
    weight = torch.arange(2.0 * 3 * 2 * 2).view(2, 3, 2, 2)
    plain, fused = (nn.ParameterList([nn.Parameter(weight.clone())]) for _ in range(2))
    reference = torch.optim.Adam(plain.parameters(), lr=0.1, eps=1e-5, foreach=False)
    optimiser = Optimiser(fused, 0.1, 1e-5, 0.0, 1e9)
    image = torch.randn(1, 3, 5, 5, generator=torch.Generator().manual_seed(0))
    for _ in range(2):
        optimiser.step(torch.conv2d(image.to(memory_format=torch.channels_last), fused[0]).square().sum())
        reference.zero_grad()
        torch.conv2d(image, plain[0]).square().sum().backward()
        reference.step()
    torch.testing.assert_close(fused[0], plain[0])
