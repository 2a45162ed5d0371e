"""Our mathematics against numbers that the originals' own code made of the same inputs (docs/fidelity.md).

Inputs are drawn here. What mastering-urlb and DreamerV2 made of them stands in tests/agents/fixtures.
"""

import math
from types import SimpleNamespace

import pytest
import torch
import torch.nn.functional as F
from originals import Draw
from torch import nn

from curionav_cli.agents.lbs_dreamer.behaviour import Behaviour, Imagined, targets_and_advantage
from curionav_cli.agents.lbs_dreamer.curiosity.lbs import LBS
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.kernels.patches import pixels, to_patches
from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.lbs_dreamer.networks import Decoder, Encoder
from curionav_cli.agents.lbs_dreamer.optimiser import Optimiser
from curionav_cli.agents.lbs_dreamer.returns import lambda_return
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, Observed, State, gru
from curionav_cli.agents.lbs_dreamer.stream_norm import StreamNorm

BOTH = pytest.mark.parametrize("project", ["mastering_urlb", "dreamerv2"])
EPSILON = {"mastering_urlb": 1e-5, "dreamerv2": 1e-3}  # of the LayerNorm: torch's default, Keras's
TOLERANCE = {"mastering_urlb": 1e-7, "dreamerv2": 2e-6}  # run in float64, in float32
GAMMA, LAMBDA, ENTROPY = 0.99, 0.95, 0.3
ADAM = {"rate": 0.01, "epsilon": 1e-5, "decay": 1e-2, "clip": 1.0}


@pytest.fixture
def close():
    """close(ours, theirs, project)"""
    def check(ours, theirs, project):
        tolerance = TOLERANCE[project]
        torch.testing.assert_close(ours.detach().double(), theirs, atol=tolerance, rtol=10 * tolerance)
    return check


def kl_inputs(size):
    draw = Draw(1)
    return tuple(draw.uniform(2, 3, 4, 5, scale=size).requires_grad_() for _ in range(2))


@BOTH
@pytest.mark.parametrize("size", [3.0, 0.5], ids=["above the free nat", "below"])
def test_kl_balance_and_free_nats(original, close, project, size):
    """DreamerV2, algorithm 2; the KL itself is equation (2) of the paper."""
    theirs, (posterior, prior) = original(project, f"kl_{size}"), kl_inputs(size)
    loss = latent.balanced_kl(posterior, prior, balance=0.8, free_nats=1.0)
    assert (theirs["value"].mean() < 1) == (size < 1)
    close(loss, theirs["loss"], project)
    close(latent.kl(posterior, prior), theirs["value"], project)
    for ours, name in zip(torch.autograd.grad(loss, (posterior, prior)), ("posterior", "prior"), strict=True):
        close(ours, theirs[name], project)


def sample_inputs():
    draw = Draw(2)
    return draw.uniform(3, 4, 5, scale=2).requires_grad_(), draw.uniform(3, 4, 5)


@BOTH
def test_the_gradient_of_a_sample_goes_straight_through(original, close, project):
    logits, weight = sample_inputs()
    (latent.sample(logits, torch.rand(3, 4)) * weight).sum().backward()
    close(logits.grad, original(project, "sample")["gradient"], project)


def gru_inputs():
    draw = Draw(3)
    dense, norm = draw.fill(nn.Linear(11, 15).double()), draw.fill(nn.LayerNorm(15).double())
    return draw.uniform(3, 6), draw.uniform(3, 5), dense, norm


@BOTH
def test_gru_cell(original, close, project):
    x, deter, dense, norm = gru_inputs()
    norm.eps = EPSILON[project]
    close(gru(x, deter, dense, norm), original(project, "gru")["state"], project)


def rssm_inputs():
    draw = Draw(4)
    rssm = draw.fill(RSSM(embed=7, actions=3, deter=5, hidden=6, latents=4, classes=5).double(), scale=1.0)
    stoch = F.one_hot(draw.integers(5, 3, 4), 5).flatten(-2).double()
    return rssm, State(draw.uniform(3, 5), stoch), draw.integers(3, 3), draw.uniform(3, 7)


@BOTH
def test_a_step_of_the_world_model(original, close, project):
    theirs, (rssm, state, action, embed) = original(project, "rssm"), rssm_inputs()
    rssm.gru_norm.eps = EPSILON[project]
    after, posterior = rssm.filter(state, rssm.action_input(action), rssm.embed_input(embed), torch.rand(3, 4))
    close(after.deter, theirs["deter"], project)
    close(rssm.prior(after.deter), theirs["prior"], project)
    close(posterior, theirs["posterior"], project)


def return_inputs():
    draw = Draw(5)
    return draw.uniform(5, 3), draw.uniform(5, 3), draw.uniform(3)


@BOTH
def test_lambda_returns(original, close, project):
    close(lambda_return(*return_inputs(), GAMMA, LAMBDA), original(project, "lambda_return")["returns"], project)


def behaviour_inputs():
    draw = Draw(6)
    behaviour = draw.fill(Behaviour(features=6, actions=3, units=8, layers=2).double())
    return behaviour, draw.uniform(6, 4, 6), draw.integers(3, 5, 4), draw.uniform(6, 4)


def slopes(loss, module):
    return torch.cat([slope.flatten() for slope in torch.autograd.grad(loss, list(module.parameters()))])


@BOTH
def test_losses_of_actor_and_critic(original, close, project):
    """Their critic's loss has the constant of the normal distribution, which ours leaves out."""
    theirs, (behaviour, features, action, reward) = original(project, "behaviour"), behaviour_inputs()
    imagined = Imagined(features, action)
    value = behaviour.slow_critic(features).squeeze(-1)
    target, advantage = targets_and_advantage(reward, value, GAMMA, LAMBDA)
    close(target, theirs["target"], project)
    actor, entropy = behaviour.actor_loss(imagined, advantage, GAMMA, ENTROPY)
    close(actor, theirs["actor_loss"], project)
    close(entropy, theirs["entropy"], project)
    close(slopes(actor, behaviour.actor), theirs["actor"], project)
    critic = behaviour.critic_loss(imagined, target, GAMMA)
    close(slopes(critic, behaviour.critic), theirs["critic"], project)
    constant = math.log(2 * math.pi) / 2 * sum(GAMMA**step for step in range(5)) / 5
    close(critic + constant, theirs["critic_loss"], project)


def reward_inputs():
    draw = Draw(7)
    return [draw.uniform(4, 3, scale=scale) for scale in (1.0, 5.0, 0.2)]


@BOTH
def test_rewards_are_normalised_alike(original, close, project):
    norm = StreamNorm(0.95, 0.0).double()
    for rewards, theirs in zip(reward_inputs(), original(project, "stream_norm")["rewards"], strict=True):
        close(norm(rewards), theirs, project)


class Size(SimpleNamespace):
    """What a curiosity asks of an RSSM."""

    features, stoch = 25, 20


def lbs_inputs():
    draw = Draw(8)
    lbs = draw.fill(LBS(Size(), units=8, layers=2, burn_in=0).double(), scale=0.3)
    posterior, prior = draw.uniform(6, 2, 4, 5, scale=2), draw.uniform(6, 2, 4, 5, scale=2)
    stoch = F.one_hot(draw.integers(5, 6, 2, 4), 5).flatten(-2).double()
    return lbs, Observed(State(draw.uniform(6, 2, 5), stoch), posterior, prior)


def test_the_head_of_lbs_learns_from_every_step_of_a_window(original, close):
    """burn_in 0, as scale=paper has it: the steps after a window's cold start are targets too."""
    theirs, (lbs, seen) = original("mastering_urlb", "lbs"), lbs_inputs()
    data = SimpleNamespace(is_start=torch.zeros(2, dtype=torch.bool))
    loss, _ = lbs.loss(seen, data, torch.rand(6, 2))
    close(loss.double() + math.log(2 * math.pi) / 2, theirs["loss"], "dreamerv2")  # predictions are made float32
    close(slopes(loss, lbs), theirs["head"], "dreamerv2")


def test_scale_paper_leaves_no_step_out_and_scale_cpu_two(hyper):
    assert [hyper(scale).curiosity_burn_in for scale in ("paper", "cpu")] == [0, 2]


def encoder_inputs():
    draw = Draw(9)
    return draw.fill(Encoder([2, 4, 8, 16], [4] * 4, [2] * 4)), draw.image(2)


@BOTH
def test_encoder(original, close, project):
    """mastering-urlb lists channels before rows and columns."""
    (encoder, image), theirs = encoder_inputs(), original(project, "encoder")["embed"]
    if project == "mastering_urlb":
        theirs = theirs.view(2, 16, 2, 2).permute(0, 2, 3, 1).flatten(1)
    close(encoder(to_patches(image, 2)), theirs, "dreamerv2")


def decoder_inputs():
    draw = Draw(10)
    return draw.fill(Decoder(6, 64, [8, 4, 2], [5, 5, 6, 6], [2] * 4), scale=0.4), draw.uniform(3, 6).float()


@BOTH
def test_decoder(original, close, project):
    """mastering-urlb takes an ELU of the image's mean, DreamerV2 and we do not."""
    decoder, features = decoder_inputs()
    image = pixels(decoder(features).permute(0, 3, 1, 2), 2).permute(0, 2, 3, 1)[:, ::8, 3::8]
    theirs = original(project, "decoder")["mean"]
    if project == "mastering_urlb":
        assert (image - theirs).max() < 1e-5 < (theirs - image).max()
        image = F.elu(image)
    close(image, theirs, "dreamerv2")


def adam_inputs():
    """A module, and the gradients of three steps: the first is clipped, the last is tiny."""
    draw = Draw(11)
    module = draw.fill(nn.Linear(3, 2).double())
    return module, [[draw.uniform(2, 3, scale=scale), draw.uniform(2, scale=scale)] for scale in (2.0, 0.2, 1e-3)]


def along(module, gradients):
    return sum((p * g).sum() for p, g in zip(module.parameters(), gradients, strict=True))


def test_three_steps_of_adam_with_decay_and_clipping(original, close):
    module, gradients = adam_inputs()
    optimiser = Optimiser(module, **ADAM)
    for step, theirs in zip(gradients, original("mastering_urlb", "adam")["weights"], strict=True):
        optimiser.step(along(module, step))
        close(torch.cat([p.flatten() for p in module.parameters()]), theirs, "mastering_urlb")


def test_keras_adds_epsilon_before_the_correction_of_the_bias(original, close):
    """A first step of ours with epsilon / sqrt(1 - beta_2) is Keras's with epsilon; seen where gradients are tiny."""
    theirs = original("dreamerv2", "adam_tiny")["weights"]
    for epsilon, same in ((ADAM["epsilon"] / math.sqrt(1 - 0.999), True), (ADAM["epsilon"], False)):
        module, gradients = adam_inputs()
        Optimiser(module, **{**ADAM, "epsilon": epsilon}).step(along(module, gradients[-1]))
        ours = torch.cat([p.detach().flatten() for p in module.parameters()])
        assert torch.allclose(ours, theirs, rtol=0, atol=1e-6) == same


def test_the_slow_critic_is_copied_before_the_updates_after_which_theirs_is(original, tiny, networks, monkeypatch):
    """Ours copies, then learns; theirs learns, then copies: ours lags by one step of the critic."""
    settings, copied = tiny(slow_critic_interval=100, behaviour_interval=1), []
    learner = Learner(settings, networks(settings), torch.Generator())
    monkeypatch.setattr(Behaviour, "update_slow_critic", lambda self: copied.append(learner.behaviour_updates))
    for _ in range(250):
        learner.count()
    assert copied == original("mastering_urlb", "slow_critic")["copied_after"].tolist() == [0, 100, 200]
