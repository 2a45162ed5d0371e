"""Adam as the paper's table sets it: clipped by the global norm, weights decayed apart from the gradient."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from curionav_cli.agents.optimiser import ClippedOptimiser


class Optimiser(ClippedOptimiser):
    """Adam on the parameters of one module.

    Every tensor is multiplied by (1 - decay) before each step: the decay is not scaled by the
    learning rate and does not pass through Adam's moments (DreamerV2; it is neither torch's
    Adam(weight_decay) nor AdamW with the same number).
    """

    def __init__(self, module: nn.Module, rate: float, epsilon: float, decay: float, clip: float):
        def adam(parameters: list[nn.Parameter]) -> torch.optim.Adam:
            recorded = parameters[0].is_cuda  # can be part of a CUDA graph
            return torch.optim.Adam(parameters, lr=rate, eps=epsilon, fused=True, capturable=recorded)

        super().__init__(module, clip, ("exp_avg", "exp_avg_sq"), adam)
        self.decay = decay

    def step(self, loss: Tensor) -> Tensor:
        """One update of these parameters and no others; returns the gradient's norm, unclipped."""
        loss.backward(inputs=self.parameters)  # into .grad, which has the parameter's memory layout
        with torch.no_grad():
            torch._foreach_mul_(self.parameters, 1 - self.decay)
        return self.apply()
