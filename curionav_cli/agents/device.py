"""Where an agent computes."""

from __future__ import annotations

import ctypes
import sys

import torch

from curionav_cli.errors import ConfigError

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3  # glibc's malloc.h
KEPT = 2**29  # bytes


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


def keep_memory() -> None:
    """Have the C library keep for this process what is freed, where it is GNU's; nothing else changes.

    It gives large arrays back to the system as soon as they are freed, and takes others page by page: a learner whose
    activations have 10 MB, made and freed at each update, spends as long on that as on its products.
    """
    if sys.platform == "linux" and hasattr(library := ctypes.CDLL(None), "mallopt"):
        library.mallopt(TRIM_THRESHOLD, KEPT)
        library.mallopt(MMAP_THRESHOLD, 2**25)  # the most that it takes


def devices() -> list[tuple[str, str]]:
    """What device=cpu and device=cuda would compute on: name, and what it is."""
    found = [("device=cpu", f"torch {torch.__version__}, {torch.get_num_threads()} threads")]
    for index in range(torch.cuda.device_count()):
        about = torch.cuda.get_device_properties(index)
        found.append(("device=cuda", f"{about.name}, {about.total_memory / 2**30:.0f} GiB"))
    return found
