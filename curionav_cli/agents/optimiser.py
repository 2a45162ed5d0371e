"""Optimisers of torch: clipped by the global norm, saved by the names of their parameters, loaded in place."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import torch
from torch import Tensor, nn


def clip_by_norm(gradients: list[Tensor], limit: float) -> Tensor:
    """Scale in place to a global norm of at most `limit` (inf: as they are); returns the norm before."""
    norm = torch.linalg.vector_norm(torch.stack(torch._foreach_norm(gradients)))
    if limit < float("inf"):
        torch._foreach_mul_(gradients, limit / norm.clamp(min=limit))
    return norm


class ClippedOptimiser:
    """`make` gives torch's optimiser of those parameters of `module` that learn.

    moments: what it keeps of each parameter beside the number of steps. All of it is there from the start.
    """

    def __init__(self, module: nn.Module, clip: float, moments: tuple[str, ...],
                 make: Callable[[list[nn.Parameter]], torch.optim.Optimizer]):
        named = [(name, parameter) for name, parameter in module.named_parameters() if parameter.requires_grad]
        self.names, self.parameters = [name for name, _ in named], [cast(Tensor, parameter) for _, parameter in named]
        self.clip, self.inner = clip, make([parameter for _, parameter in named])
        for parameter in self.parameters:  # as its first step would do
            self.inner.state[parameter] = {"step": torch.zeros((), device=parameter.device),
                                           **{moment: torch.zeros_like(parameter) for moment in moments}}

    def apply(self) -> Tensor:
        """Step along the gradients that are there, and forget them; their norm, unclipped."""
        norm = clip_by_norm([cast(Tensor, parameter.grad) for parameter in self.parameters], self.clip)
        self.inner.step()
        self.inner.zero_grad(set_to_none=True)
        return norm

    def state(self) -> dict[str, Tensor]:
        """Moments and step counts, themselves and not copies, by 'parameter/moment'."""
        return {
            f"{name}/{key}": value
            for name, parameter in zip(self.names, self.parameters, strict=True)
            for key, value in self.inner.state[parameter].items()
        }

    def load_state(self, tensors: dict[str, Tensor]) -> None:
        """Take over what `state` returned, in place."""
        own = self.state()
        for path, tensor in tensors.items():
            own[path].copy_(tensor)
