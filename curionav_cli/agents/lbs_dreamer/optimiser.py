"""Adam with the paper's table: clipped by the global norm, with weight decay apart from the gradient."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from curionav_cli.agents.optimiser import ClippedOptimiser


class Optimiser(ClippedOptimiser):
    """Adam for the parameters of one module; rate, epsilon, decay, clip as in the paper's table.

    Every tensor is multiplied by (1 - decay) before each step: the decay is not scaled by the
    learning rate and does not pass through Adam's moments (DreamerV2; it is neither torch's
    Adam(weight_decay) nor AdamW with the same number).
    """

    def __init__(self, module: nn.Module, rate: float, epsilon: float, decay: float, clip: float):
        def adam(parameters: list[nn.Parameter]) -> torch.optim.Adam:
            on_gpu = parameters[0].is_cuda  # there it may be recorded as part of a CUDA graph
            return torch.optim.Adam(parameters, lr=rate, eps=epsilon, fused=True, capturable=on_gpu)

        super().__init__(module, clip, ("exp_avg", "exp_avg_sq"), adam)
        self.decay = decay

    def step(self, loss: Tensor) -> Tensor:
        """Take a step down the gradient of a scalar loss, of these parameters only; return its norm before clipping."""
        loss.backward(inputs=self.parameters)  # into .grad, which has the parameter's memory layout
        with torch.no_grad():
            torch._foreach_mul_(self.parameters, 1 - self.decay)
        return self.apply()
