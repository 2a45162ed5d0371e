"""Torch's optimisers with clipping by the global norm; their state is saved by parameter name and loaded in place.

They are called as functions: torch's optimiser objects import its compiler, which takes as long as torch itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import torch
from torch import Tensor, nn

Tensors = list[Tensor]
Step = Callable[..., None]  # (parameters, gradients, each of the moments in turn, step counts), all Tensors


def clip_by_norm(gradients: list[Tensor], limit: float) -> Tensor:
    """Scale the gradients in place to a global norm of at most `limit` (inf: not at all); return the norm before."""
    norm = torch.linalg.vector_norm(torch.stack(torch._foreach_norm(gradients)))
    if limit < float("inf"):
        torch._foreach_mul_(gradients, limit / norm.clamp(min=limit))
    return norm


class ClippedOptimiser:
    """One of torch's optimisers for the parameters of `module` that require gradients.

    clip: limit of the gradients' global norm. moments: names of the tensors that it keeps for each parameter beside
    the step count; all exist before the first step, so that a state can be loaded and a CUDA graph recorded.
    step: moves the parameters in place.
    """

    def __init__(self, module: nn.Module, clip: float, moments: tuple[str, ...], step: Step):
        named = [(name, parameter) for name, parameter in module.named_parameters() if parameter.requires_grad]
        self.names, self.parameters = [name for name, _ in named], [cast(Tensor, parameter) for _, parameter in named]
        self.clip, self.move = clip, step
        self.steps = [torch.zeros((), device=parameter.device) for parameter in self.parameters]
        self.moments = {moment: [torch.zeros_like(parameter) for parameter in self.parameters] for moment in moments}

    def apply(self) -> Tensor:
        """Clip the gradients, take a step and clear them; return their norm before clipping."""
        gradients = [cast(Tensor, parameter.grad) for parameter in self.parameters]
        norm = clip_by_norm(gradients, self.clip)
        with torch.no_grad():
            self.move(self.parameters, gradients, *self.moments.values(), self.steps)
        for parameter in self.parameters:
            parameter.grad = None
        return norm

    def state(self) -> dict[str, Tensor]:
        """Return moments and step counts by 'parameter/moment': the tensors themselves, not copies."""
        return {f"{name}/{key}": tensors[index] for index, name in enumerate(self.names)
                for key, tensors in {"step": self.steps, **self.moments}.items()}

    def load_state(self, tensors: dict[str, Tensor]) -> None:
        """Copy what `state` returned into this optimiser's tensors, in place."""
        own = self.state()
        for path, tensor in tensors.items():
            own[path].copy_(tensor)
