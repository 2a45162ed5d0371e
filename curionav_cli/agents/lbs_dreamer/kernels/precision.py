"""The type that matrix products are computed in."""

from __future__ import annotations

import torch
from torch import Tensor


def as_computed(*tensors: Tensor) -> list[Tensor]:
    """Return the tensors in the type that autocast, if it is on, computes products in."""
    device = tensors[0].device.type
    if not torch.amp.is_autocast_available(device) or not torch.is_autocast_enabled(device):
        return list(tensors)
    return [tensor.to(torch.get_autocast_dtype(device)) for tensor in tensors]
