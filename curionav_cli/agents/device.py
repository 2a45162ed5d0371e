"""Where an agent computes."""

from __future__ import annotations

import ctypes
import sys

import torch

from curionav_cli.errors import ConfigError

# glibc's malloc.h: trim the heap when so much is free on top (-1: never); so many blocks outside the heap.
M_TRIM_THRESHOLD, NEVER = -1, -1
M_MMAP_MAX, NONE = -4, 0


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


def keep_freed_memory() -> None:
    """From here on this process keeps what it frees, where the C library is glibc; nothing else changes.

    glibc hands large blocks back to the kernel, which clears each page anew when it is next asked for, and an update
    frees and asks for the same hundreds of megabytes: up to a fifth of its CPU seconds.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt:
        mallopt(M_TRIM_THRESHOLD, NEVER)
        mallopt(M_MMAP_MAX, NONE)


def devices() -> list[tuple[str, str]]:
    """What device=cpu and device=cuda would compute on: name, and what it is."""
    found = [("device=cpu", f"torch {torch.__version__}, {torch.get_num_threads()} threads")]
    for index in range(torch.cuda.device_count()):
        about = torch.cuda.get_device_properties(index)
        found.append(("device=cuda", f"{about.name}, {about.total_memory / 2**30:.0f} GiB"))
    return found
