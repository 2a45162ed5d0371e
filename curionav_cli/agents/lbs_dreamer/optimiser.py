"""Adam with the paper's table: clipped by the global norm, with weight decay apart from the gradient."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.optim import adam as functional

from curionav_cli.agents.optimiser import ClippedOptimiser, Tensors


class Optimiser(ClippedOptimiser):
    """Adam for the parameters of one module; rate, epsilon, decay, clip as in the paper's table.

    Every tensor is multiplied by (1 - decay) before each step: the decay is not scaled by the
    learning rate and does not pass through Adam's moments (DreamerV2; it is neither torch's
    Adam(weight_decay) nor AdamW with the same number).
    """

    def __init__(self, module: nn.Module, rate: float, epsilon: float, decay: float, clip: float):
        def adam(parameters: Tensors, gradients: Tensors, means: Tensors, squares: Tensors, steps: Tensors) -> None:
            functional.adam(parameters, gradients, means, squares, [], steps, lr=rate, beta1=0.9, beta2=0.999,
                            eps=epsilon, weight_decay=0, amsgrad=False, maximize=False, fused=True,
                            capturable=parameters[0].is_cuda)  # there it may be recorded as part of a CUDA graph

        super().__init__(module, clip, ("exp_avg", "exp_avg_sq"), adam)
        self.decay = decay

    def step(self, loss: Tensor) -> Tensor:
        """Take a step down the gradient of a scalar loss, of these parameters only; return its norm before clipping."""
        loss.backward(inputs=self.parameters)  # into .grad, which has the parameter's memory layout
        with torch.no_grad():
            torch._foreach_mul_(self.parameters, 1 - self.decay)
        return self.apply()
