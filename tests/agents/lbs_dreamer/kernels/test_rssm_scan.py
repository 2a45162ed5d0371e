"""The gradient written by hand against autograd's of one step after another, and against finite differences."""

import pytest
import torch

from curionav_cli.agents.lbs_dreamer.kernels.rssm_scan import Weights, scan
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State

T, B, E = 4, 3, 5


def make(latents=3, classes=4):
    """A model with every weight away from its special value, a state to begin with, and inputs."""
    generator = torch.Generator().manual_seed(0)
    rssm = RSSM(E, 3, deter=4, hidden=6, latents=latents, classes=classes)
    initialise(rssm, generator)
    with torch.no_grad():
        for parameter in rssm.parameters():
            parameter.add_(torch.rand(parameter.shape, generator=generator) - 0.5)
    rssm.double()
    deter, stoch, embed = (torch.randn(*shape, dtype=torch.float64, generator=generator).requires_grad_()
                           for shape in ((B, 4), (B, latents * classes), (T, B, E)))
    action = torch.randint(-1, 3, (T, B), generator=generator)
    return rssm, State(deter, stoch), embed, action, torch.rand(T, B, latents, generator=generator).double()


def one_after_another(rssm, state, embed, action, noise):
    states, logits = [], []
    for a, e, n in zip(rssm.action_input(action), rssm.embed_input(embed), noise, strict=True):
        state, posterior = rssm.filter(state, a, e, n)
        states.append(state)
        logits.append(posterior)
    return *(torch.stack(x) for x in zip(*states, strict=True)), torch.stack(logits)


@pytest.mark.parametrize("parts", [(0,), (1,), (2,), (0, 1, 2)])
def test_results_and_gradients_are_those_of_one_step_after_another(parts):
    rssm, state, *inputs = make()
    seen = rssm.observe(state, *inputs)
    results = ((*seen.states, seen.posterior), one_after_another(rssm, state, *inputs))
    gradients = []
    leaves = {"deter": state.deter, "stoch": state.stoch, "embed": inputs[0], **dict(rssm.named_parameters())}
    for result in results:
        loss = sum((x * torch.linspace(-1, 2, x.numel(), dtype=x.dtype).view(x.shape)).sum()
                   for x in (result[part] for part in parts))
        found = torch.autograd.grad(loss, tuple(leaves.values()), allow_unused=True)
        gradients.append({name: x for name, x in zip(leaves, found, strict=True) if x is not None and x.any()})
    torch.testing.assert_close(*results, rtol=1e-12, atol=1e-12)
    assert len(gradients[0]) >= 8
    torch.testing.assert_close(*gradients, rtol=1e-10, atol=1e-12)


def test_gradients_are_finite_differences():
    """With one class the sample is no choice, and nothing is straight through."""
    rssm, state, embed, action, noise = make(latents=2, classes=1)
    inputs = [*state, rssm.action_input(action), rssm.embed_input(embed), *rssm.scan_weights()]
    assert torch.autograd.gradcheck(
        lambda deter, stoch, a, e, *weights: scan(deter, stoch, a, e, noise, Weights(*weights), 1e-3)[::2],
        [x.detach().clone().requires_grad_() for x in inputs])
