"""Where an agent computes."""

from __future__ import annotations

import torch

from curionav_cli.errors import ConfigError


def resolve_device(device: str) -> torch.device:
    """auto, cpu or cuda -> the device. Raises ConfigError for cuda where there is none."""
    if device == "cuda" and not torch.cuda.is_available():
        raise ConfigError("device=cuda, but torch sees no CUDA device here. Use device=auto or device=cpu.")
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(device)


def repeatable(device: torch.device) -> None:
    """Of cuDNN's convolutions take those that add up in a fixed order, so that a run can be repeated.

    Nothing else here is computed in an order of chance. TF32 stays as torch has it: convolutions use it
    where agent.precision is float32, products do not; under bfloat16 it plays no part.
    """
    if device.type == "cuda":
        torch.backends.cudnn.deterministic = True
        torch.backends.cudnn.benchmark = False
