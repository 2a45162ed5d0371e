"""The choice of agent.precision=auto at scale=paper: which type this machine multiplies matrices fastest in.

At scale=cpu it is float32 everywhere (build.automatic; Precision in lbs_dreamer/settings.py states the whole rule). At
scale=paper it is bfloat16 on CUDA, or where the processor has instructions for it and multiplies faster in it; else
float32. Without such instructions bfloat16 is emulated, at a thirtieth of float32's rate; with AMX it has three times
that rate (docs/performance.md). MARGIN lies far from both, so that the choice is the same in every run on a machine,
busy or not.
"""

from __future__ import annotations

import time
from functools import cache
from pathlib import Path
from typing import NamedTuple

import torch

from curionav_cli.agents.lbs_dreamer.settings import Precision

CPUINFO = Path("/proc/cpuinfo")
NATIVE = {"amx_bf16", "avx512_bf16", "bf16", "svebf16"}  # as Linux names them: x86 and, the last two, ARM
SIDES, TIMES = (64, 128, 256, 512, 512, 512), 3  # of the matrices; the first product of a size is a warm-up
SECONDS = 0.005  # for each of the two
MARGIN = 1.25


class Rates(NamedTuple):
    """GFLOP/s of a matrix product, on as many threads as torch uses."""

    float32: float
    bfloat16: float


def quick(device: str) -> Precision:
    """Choose bfloat16 or float32 for `device`, cpu or cuda."""
    if device == "cuda":
        return Precision.bfloat16
    return Precision.bfloat16 if native() and faster(rates(), Precision.bfloat16) else Precision.float32


def faster(rates: Rates, precision: Precision) -> bool:
    """Tell whether `precision` is faster than the other type, by MARGIN."""
    other = rates.bfloat16 if precision is Precision.float32 else rates.float32
    return float(getattr(rates, precision.value)) > MARGIN * other


def native() -> list[str]:
    """List the processor's instructions for bfloat16; empty where /proc/cpuinfo is absent."""
    try:
        text = CPUINFO.read_text()
    except OSError:
        return []
    flags = [line for line in text.splitlines() if line.lower().startswith(("flags", "features"))]
    return sorted(NATIVE.intersection(*(line.partition(":")[2].split() for line in flags))) if flags else []


@cache
def rates() -> Rates:
    """Measure both rates, once in a process, in some ten milliseconds."""
    return Rates(*(rate(getattr(torch, name)) for name in Rates._fields))


@torch.no_grad()
def rate(kind: torch.dtype) -> float:
    """Measure GFLOP/s in a type: the best of products of growing size, so that another program slows only some."""
    best, end = 0.0, time.perf_counter() + SECONDS
    for side in SIDES:
        matrix = torch.ones(side, side, dtype=kind)
        for _ in range(TIMES):
            began = time.perf_counter()
            torch.mm(matrix, matrix)
            best = max(best, 2e-9 * side**3 / (time.perf_counter() - began))
        if time.perf_counter() > end:
            break
    return best
