"""Adam as the paper's table sets it: clipped by the global norm, weights decayed apart from the gradient."""

from __future__ import annotations

from typing import cast

import torch
from torch import Tensor, nn


def clip_by_norm(gradients: list[Tensor], limit: float) -> Tensor:
    """Scale in place to a global norm of at most `limit`; returns the norm before."""
    norm = torch.linalg.vector_norm(torch.stack(torch._foreach_norm(gradients)))
    torch._foreach_mul_(gradients, limit / norm.clamp(min=limit))
    return norm


class Optimiser:
    """Adam on the parameters of one module.

    Every tensor is multiplied by (1 - decay) before each step: the decay is not scaled by the
    learning rate and does not pass through Adam's moments (DreamerV2; it is neither torch's
    Adam(weight_decay) nor AdamW with the same number).
    """

    def __init__(self, module: nn.Module, rate: float, epsilon: float, decay: float, clip: float):
        self.names, parameters = zip(*((name, parameter) for name, parameter in module.named_parameters()
                                            if parameter.requires_grad), strict=True)
        self.parameters = list(parameters)
        self.decay, self.clip = decay, clip
        self.adam = torch.optim.Adam(self.parameters, lr=rate, eps=epsilon, fused=True,
                                     capturable=self.parameters[0].is_cuda)  # can be part of a CUDA graph
        for parameter in self.parameters:  # as its first step would do: all state is there from the start
            self.adam.state[parameter] = {
                "step": torch.zeros((), device=parameter.device),
                "exp_avg": torch.zeros_like(parameter), "exp_avg_sq": torch.zeros_like(parameter)}

    def step(self, loss: Tensor) -> Tensor:
        """One update of these parameters and no others; returns the gradient's norm, unclipped."""
        loss.backward(inputs=self.parameters)  # into .grad, which has the parameter's memory layout
        norm = clip_by_norm([cast(Tensor, parameter.grad) for parameter in self.parameters], self.clip)
        with torch.no_grad():
            torch._foreach_mul_(self.parameters, 1 - self.decay)
        self.adam.step()
        self.adam.zero_grad(set_to_none=True)
        return norm

    def state(self) -> dict[str, Tensor]:
        """Adam's moments and step counts, themselves and not copies, by 'parameter/moment'."""
        return {
            f"{name}/{key}": value
            for name, parameter in zip(self.names, self.parameters, strict=True)
            for key, value in self.adam.state[parameter].items()
        }

    def load_state(self, tensors: dict[str, Tensor]) -> None:
        """Take over what `state` returned, in place."""
        own = self.state()
        for path, tensor in tensors.items():
            own[path].copy_(tensor)
