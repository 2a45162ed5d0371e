"""Clipping, torch's own RMSprop, and a state that is taken over in place."""

import torch
from torch import nn
from torch.optim import rmsprop as functional

from curionav_cli.agents.optimiser import ClippedOptimiser, clip_by_norm


def test_small_gradients_pass_and_large_ones_are_cut_to_the_limit():
    small, large = [torch.tensor([3.0]), torch.tensor([4.0])], [torch.tensor([300.0]), torch.tensor([400.0])]
    assert clip_by_norm(small, 100) == 5 and torch.cat(small).tolist() == [3, 4]
    assert clip_by_norm(large, 100) == 500
    torch.testing.assert_close(torch.cat(large), torch.tensor([60.0, 80.0]))


def test_without_a_limit_gradients_stay_as_they_are():
    gradients = [torch.tensor([300.0]), torch.tensor([400.0])]
    assert clip_by_norm(gradients, float("inf")) == 500 and torch.cat(gradients).tolist() == [300, 400]


def rmsprop(parameters, gradients, squares, steps):
    functional.rmsprop(parameters, gradients, squares, [], [], steps, lr=0.1, alpha=0.9, eps=1e-3, weight_decay=0,
                       momentum=0, centered=False)


def matrix():
    module = nn.Linear(2, 2, bias=False)
    with torch.no_grad():
        module.weight.copy_(torch.tensor([[1.0, -2.0], [3.0, 0.5]]))
    return module


def test_two_steps_are_rmsprops():
    module = matrix()
    optimiser, weight = ClippedOptimiser(module, 3.0, ("square_avg",), rmsprop), module.weight.detach().double()
    average = torch.zeros_like(weight)
    for _ in range(2):
        gradient = 2 * weight
        module.weight.square().sum().backward()
        torch.testing.assert_close(optimiser.apply().double(), gradient.norm(), atol=1e-5, rtol=1e-5)
        gradient = gradient * min(1.0, 3.0 / float(gradient.norm()))
        average = 0.9 * average + 0.1 * gradient**2
        weight = weight - 0.1 * gradient / (average.sqrt() + 1e-3)
        torch.testing.assert_close(module.weight.detach().double(), weight, atol=1e-5, rtol=1e-5)
    assert module.weight.grad is None


def test_what_does_not_learn_is_left_out():
    module = nn.ModuleList([matrix(), matrix().requires_grad_(False)])
    assert ClippedOptimiser(module, 1.0, ("square_avg",), rmsprop).names == ["0.weight"]


def test_a_state_goes_from_one_to_the_next():
    one, other = (ClippedOptimiser(matrix(), 3.0, ("square_avg",), rmsprop) for _ in range(2))
    assert one.state().keys() == {"weight/step", "weight/square_avg"} and not one.state()["weight/square_avg"].any()
    one.parameters[0].square().sum().backward()
    one.apply()
    kept = other.state()["weight/square_avg"]
    other.load_state(one.state())
    assert (kept == one.state()["weight/square_avg"]).all() and int(other.state()["weight/step"]) == 1
