"""Steps of imagination in float32 on a CPU: products by torch, the rest by rows.py. Letters as in rssm.py."""

from __future__ import annotations

import torch
from torch import Tensor

from curionav_cli.agents.elu import elu_
from curionav_cli.agents.lbs_dreamer.kernels import one_hot, rows
from curionav_cli.agents.lbs_dreamer.kernels.fused_steps import call, gru
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, State


class FusedDynamics:
    """The dynamics of an RSSM as they are when this is made: RSSM.roll but for rounding, for many steps in a row."""

    def __init__(self, rssm: RSSM):
        self.rssm, self.norm = rssm, rssm.gru_norm
        self.z = one_hot.columns_of(rssm.img_in.weight[:, :rssm.stoch])  # (S * C, U)
        self.actions = rssm.action_input(torch.arange(rssm.actions))  # (A, U)
        self.gru, self.out, self.dist = (layer.weight.t().contiguous() for layer in
                                         (rssm.gru, rssm.img_out, rssm.img_dist))

    def ones(self, state: State) -> Tensor:
        """Indices (B, S) of the ones in z (B, S * C)."""
        return one_hot.indices(state.stoch, self.rssm.classes)

    def roll(self, state: State, action: Tensor, noise: Tensor, ones: Tensor) -> tuple[State, Tensor]:
        """One step as RSSM.roll; also `ones` of the state reached."""
        rssm, shape = self.rssm, (len(action), self.rssm.latents, self.rssm.classes)
        before = self.actions.index_select(0, action).add_(one_hot.summed(ones, self.z))
        deter, *_ = gru(before, state.deter, self.gru.t(), rssm.gru.bias, self.norm.weight, self.norm.bias,
                        self.norm.eps)
        out = elu_(torch.addmm(rssm.img_out.bias, deter, self.out))
        logits = torch.addmm(rssm.img_dist.bias, out, self.dist).view(shape)
        stoch, index = torch.empty_like(logits), torch.empty_like(ones)
        call(rows.draw, logits, noise, stoch, logits, index)
        return State(deter, stoch.flatten(-2)), index
