"""Fused functions of a step against the plain ones; both draw the same latents."""

import pytest
import torch

pytest.importorskip("numba")

from curionav_cli.agents.elu import elu_
from curionav_cli.agents.lbs_dreamer.behaviour import Behaviour
from curionav_cli.agents.lbs_dreamer.compile import fuse_on, fuse_rows
from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State

T, B, E, SIZES = 4, 3, 5, [(3, 4), (4, 20)]  # latents and classes; 20 are laid out with classes last


def pair(latents, classes, layers=2):
    """The same model and behaviour twice, the second fused, and a generator for inputs."""
    models = [RSSM(E, 3, deter=20, hidden=24, latents=latents, classes=classes) for _ in range(2)]
    behaviours = [Behaviour(model.features, 3, 28, layers, model.stoch) for model in models]
    for made in zip(models, behaviours, strict=True):
        generator = torch.Generator().manual_seed(0)
        for part in made:
            initialise(part, generator)
            with torch.no_grad():
                for parameter in part.parameters():
                    parameter.add_((torch.rand(parameter.shape, generator=generator) - 0.5) / 2)
    fuse_rows(models[1], behaviours[1])
    return models, behaviours, generator


def close(one, other):
    torch.testing.assert_close(one, other, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("latents, classes", SIZES)
def test_filtering_and_its_gradient_are_the_plain_ones(latents, classes):
    models, _, generator = pair(latents, classes)
    action = torch.randint(-1, 3, (T, B), generator=generator)
    noise = torch.rand(T, B, latents, generator=generator)
    shapes = (B, 20), (B, latents * classes), (T, B, E)
    given = [torch.randn(*shape, generator=generator).requires_grad_() for shape in shapes]
    slopes = [torch.randn(T, B, size, generator=generator) for size in (20, *[latents * classes] * 2)]
    results = []
    for model in models:
        observed = model.observe(State(*given[:2]), given[2], action, noise)
        made = *observed.states, observed.posterior.flatten(-2)
        loss = sum((part * slope).sum() for part, slope in zip(made, slopes, strict=True))
        learned = [weight for name, weight in model.named_parameters() if not name.startswith(("img_out", "img_dist"))]
        results.append((*made, *torch.autograd.grad(loss, [*given, *learned])))
    for plain, fused in zip(*results, strict=True):
        close(fused, plain)


@pytest.mark.parametrize("latents, classes", SIZES)
@pytest.mark.parametrize("layers", [1, 3])
def test_imagination_is_the_plain_one(latents, classes, layers):
    models, behaviours, generator = pair(latents, classes, layers)
    deter, index = torch.randn(B, 20, generator=generator), torch.randint(classes, (B, latents), generator=generator)
    start = State(deter, torch.nn.functional.one_hot(index, classes).float().flatten(-2))
    noise, before = torch.rand(T, B, latents + 1, generator=generator), deter.clone()
    plain, fused = (behaviour.imagine(model, start, noise) for model, behaviour in zip(models, behaviours, strict=True))
    assert (deter == before).all()
    assert (fused.action == plain.action).all()
    assert (fused.features[..., :latents * classes].nonzero()[:, 2].view(T + 1, B, latents) == fused.ones).all()
    for one, other in zip((plain.features, *plain.actor_layers), (fused.features, *fused.actor_layers), strict=True):
        close(other, one)


def test_an_elu_in_any_layout_is_torchs():
    from curionav_cli.agents.lbs_dreamer.kernels.fused_elu import fused_elu_

    image = torch.cat([torch.linspace(-100, 30, 358), torch.tensor([torch.nan, torch.inf])]).view(2, 3, 5, 12)
    for x in (image[0, 0], image, image.to(memory_format=torch.channels_last), image.transpose(2, 3), image.double()):
        torch.testing.assert_close(fused_elu_(x.clone()), elu_(x.clone()), rtol=1e-6, atol=2e-7, equal_nan=True)


def test_fused_updates_learn_what_plain_ones_do(tiny, networks, data):
    plain, fused = (Learner(tiny(), networks(tiny()), torch.Generator().manual_seed(1)) for _ in range(2))
    fuse_on(torch.device("cpu"), fused.networks)
    for _ in range(3):
        one, other = plain.update(data), fused.update(data)
        for name, value in one.items():
            assert float(other[name]) == pytest.approx(float(value), rel=1e-3, abs=1e-3), name
    for name, weight in plain.networks.state_dict().items():
        torch.testing.assert_close(fused.networks.state_dict()[name], weight, rtol=0, atol=1e-3)


def test_numbers_that_overflow_and_vanish_are_as_in_torch():
    from curionav_cli.agents.lbs_dreamer.kernels import latent, rows

    logits = torch.tensor([[[200.0, 0.0, -200.0], [-3e4, -3e4, 1e4]], [[0.0, 0.0, 0.0], [90.0, 89.0, 1.0]]])
    noise = torch.tensor([[0.5, 0.999], [0.9999999, 0.74]])
    one_hot, probs = torch.empty_like(logits), torch.empty_like(logits)
    index = torch.empty(2, 2, dtype=torch.int64)
    rows.draw(*(x.numpy() for x in (logits, noise, one_hot.view(2, -1), probs, index)))
    expected, _ = latent.draw(logits, noise)
    assert (one_hot == expected).all()
    close(probs, logits.softmax(-1))
