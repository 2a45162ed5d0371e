"""The device that an agent computes on, and how the process keeps its memory there."""

from __future__ import annotations

import ctypes
import sys

import torch

from curionav_cli.errors import ConfigError

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_MMAP_MAX = -1, -3, -4  # glibc's malloc.h
ALL = -1  # for M_TRIM_THRESHOLD: the heap never shrinks


def resolve_device(device: str) -> torch.device:
    """Return the device of the setting auto, cpu or cuda. Raises ConfigError for cuda where there is none."""
    if device == "cuda" and not torch.cuda.is_available():
        raise ConfigError("device=cuda, but torch sees no CUDA device here. Use device=auto or device=cpu.")
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(device)


def repeatable(device: torch.device) -> None:
    """Have cuDNN use the convolutions that add up in a fixed order, so that a run can be repeated.

    Nothing else here is summed in a varying order. TF32 stays as torch has it: convolutions use it where
    agent.precision is float32, matrix products do not; under bfloat16 it plays no part.
    """
    if device.type == "cuda":
        torch.backends.cudnn.deterministic = True
        torch.backends.cudnn.benchmark = False


def keep_freed_memory(kept: int, mapped_from: int | None) -> None:
    """Have glibc keep freed memory for this process; without effect where the C library is another one.

    It hands large blocks back to the kernel as soon as they are freed, which clears each page anew when it is next
    asked for. A learner frees and asks for the same activations at every update: that took a fifth of LBS Dreamer's
    CPU seconds, and as long as C-BET's matrix products.

    kept: bytes of free memory on top of the heap that are not handed back; ALL: none ever is.
    mapped_from: bytes from which on a block lies outside the heap and is handed back when freed (at most 2^25, by
    glibc); None: no block does.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt:
        mallopt(M_TRIM_THRESHOLD, kept)
        mallopt(*((M_MMAP_MAX, 0) if mapped_from is None else (M_MMAP_THRESHOLD, mapped_from)))


def devices() -> list[tuple[str, str]]:
    """List the devices here, as (setting, description)."""
    found = [("device=cpu", f"torch {torch.__version__}, {torch.get_num_threads()} threads")]
    for index in range(torch.cuda.device_count()):
        about = torch.cuda.get_device_properties(index)
        found.append(("device=cuda", f"{about.name}, {about.total_memory / 2**30:.0f} GiB"))
    return found
