"""The recurrent state-space model: its cell, what it may and may not see, filtering step by step."""

import math

import pytest
import torch
from torch import nn

from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.kernels.one_hot import MANY
from curionav_cli.agents.lbs_dreamer.networks import initialise
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State, gru, one_hot_action

T, B, E = 5, 2, 6


@pytest.fixture
def rssm():
    module = RSSM(E, 3, deter=8, hidden=7, latents=3, classes=4)
    initialise(module, torch.Generator().manual_seed(0))
    return module


@pytest.fixture
def inputs():
    generator = torch.Generator().manual_seed(1)
    action = torch.randint(0, 3, (T, B), generator=generator)
    action[0] = -1
    return torch.randn(T, B, E, generator=generator), action, torch.rand(T, B, 3, generator=generator)


def sigmoid(x):
    return 1 / (1 + math.exp(-x))


def test_the_cell_against_plain_arithmetic():
    dense, norm = nn.Linear(2 + 3, 9), nn.LayerNorm(9, eps=1e-3)
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():
        for parameter in [*dense.parameters(), *norm.parameters()]:
            parameter.uniform_(-1, 1, generator=generator)
    x, deter = [0.3, -0.7], [0.1, -0.2, 0.9]
    ours = gru(torch.tensor([x]), torch.tensor([deter]), dense, norm)[0].tolist()
    gates = [sum(w * v for w, v in zip(row, x + deter, strict=True)) + b
             for row, b in zip(dense.weight.tolist(), dense.bias.tolist(), strict=True)]
    mean = sum(gates) / 9
    deviation = math.sqrt(sum((g - mean) ** 2 for g in gates) / 9 + 1e-3)
    gates = [(g - mean) / deviation * w + b
             for g, w, b in zip(gates, norm.weight.tolist(), norm.bias.tolist(), strict=True)]
    for i in range(3):
        candidate = math.tanh(sigmoid(gates[i]) * gates[3 + i])
        update = sigmoid(gates[6 + i] - 1)
        assert ours[i] == pytest.approx(update * candidate + (1 - update) * deter[i], abs=1e-5)


def test_a_cell_without_input_keeps_most_of_its_state():
    dense, norm = nn.Linear(2 + 3, 9), nn.LayerNorm(9, eps=1e-3)
    nn.init.zeros_(dense.weight), nn.init.zeros_(dense.bias)
    kept = gru(torch.ones(1, 2), torch.ones(1, 3), dense, norm)
    torch.testing.assert_close(kept, torch.full((1, 3), 1 - sigmoid(-1)))


def test_no_action_is_zeros():
    assert one_hot_action(torch.tensor([2, -1]), 3).tolist() == [[0, 0, 1], [0, 0, 0]]


def test_splitting_the_first_layers_changes_nothing(rssm):
    """The action's and the observation's share are computed apart; together they are one dense layer."""
    state = State(torch.rand(2, 8), torch.rand(2, 12))
    action, embed = torch.tensor([1, 2]), torch.rand(2, E)
    x = torch.nn.functional.elu(rssm.img_in(torch.cat([state.stoch, one_hot_action(action, 3)], -1)))
    deter = gru(x, state.deter, rssm.gru, rssm.gru_norm)
    torch.testing.assert_close(rssm.recur(state, rssm.action_input(action)), deter)
    logits = rssm.obs_dist(torch.nn.functional.elu(rssm.obs_out(torch.cat([deter, embed], -1))))
    torch.testing.assert_close(rssm.posterior(deter, rssm.embed_input(embed)).flatten(1), logits)


def test_one_step_after_another_is_the_whole_sequence(rssm, inputs):
    embed, action, noise = inputs
    whole = rssm.observe(rssm.initial(B), *inputs)
    state = rssm.initial(B)
    for t in range(T):
        state, logits = rssm.filter(state, rssm.action_input(action[t]), rssm.embed_input(embed[t]), noise[t])
        torch.testing.assert_close(state.deter, whole.states.deter[t])
        assert (state.stoch == whole.states.stoch[t]).all()
        torch.testing.assert_close(logits, whole.posterior[t])
        torch.testing.assert_close(rssm.prior(state.deter), whole.prior[t])


def sensitivity(rssm, inputs, part, step):
    """For each t: does a gradient of `part` at `step` reach the observation of t?"""
    embed, action, noise = inputs
    embed = embed.clone().requires_grad_()
    seen = rssm.observe(rssm.initial(B), embed, action, noise)
    target = {"deter": seen.states.deter, "prior": seen.prior, "posterior": seen.posterior}[part][step]
    (gradient,) = torch.autograd.grad(target.square().sum(), embed)
    return [bool(g.any()) for g in gradient]


@pytest.mark.parametrize("part, sees", [("deter", 3), ("prior", 3), ("posterior", 4)])
def test_nothing_sees_the_future_and_only_the_posterior_the_present(rssm, inputs, part, sees):
    assert sensitivity(rssm, inputs, part, 3) == [t < sees for t in range(T)]


def test_the_action_of_a_step_is_the_one_that_led_to_it(rssm, inputs):
    embed, action, noise = inputs
    changed = action.clone()
    changed[3] = (action[3] + 1) % 3
    one, other = (rssm.observe(rssm.initial(B), embed, a, noise).states.deter for a in (action, changed))
    assert (one[:3] == other[:3]).all() and (one[3] != other[3]).any()


def test_sequences_of_a_batch_do_not_touch_each_other(rssm, inputs):
    embed, action, noise = inputs
    changed = embed.clone()
    changed[:, 0] += 1
    one, other = (rssm.observe(rssm.initial(B), e, action, noise).posterior for e in (embed, changed))
    assert (one[:, 1] == other[:, 1]).all() and (one[:, 0] != other[:, 0]).any()


def test_imagining_many_states_by_their_ones_is_imagining_them_by_products(rssm):
    generator = torch.Generator().manual_seed(3)
    logits, chance = torch.randn(MANY, 3, 4, generator=generator), torch.rand(MANY, 3, generator=generator)
    state = State(torch.rand(MANY, 8, generator=generator), latent.draw(logits, chance)[0].flatten(-2))
    ones = rssm.ones(state)
    assert ones is not None
    action, noise = rssm.action_input(torch.zeros(MANY, dtype=torch.int64)), torch.rand(MANY, 3, generator=generator)
    torch.testing.assert_close(rssm.recur(state, action, ones), rssm.recur(state, action))
    assert (rssm.imagine(state, action, noise, ones).stoch == rssm.imagine(state, action, noise).stoch).all()


