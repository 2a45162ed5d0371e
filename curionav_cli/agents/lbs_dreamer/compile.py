"""How the agent's functions run on its device: eagerly, as CUDA graphs, or as CUDA graphs of fused kernels."""

from __future__ import annotations

import logging
import sysconfig
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from shutil import which

import torch

from curionav_cli.agents.lbs_dreamer.kernels.cuda_graphs import Record, Recorded, as_it_is, cuda_graph
from curionav_cli.agents.lbs_dreamer.kernels.rssm_scan import Steps
from curionav_cli.agents.lbs_dreamer.rssm import RSSM
from curionav_cli.errors import ConfigError

log = logging.getLogger("curionav")


def compile_mode(compile: str, device: torch.device) -> str:
    """Resolve the setting compile to none, graph or fused. Raises ConfigError where it needs a CUDA device."""
    if device.type == "cpu":
        if compile in ("graph", "fused"):
            raise ConfigError(f"compile={compile} needs a CUDA device, and this run computes on the CPU. "
                              "Use compile=auto or compile=none.")
        return "none"
    if compile == "auto":
        compile = "fused" if can_fuse(device) else "graph"
        log.info("compile=auto is compile=%s here", compile)
    return compile


def can_fuse(device: torch.device) -> bool:
    """Tell whether Triton can compile here: it needs a GPU from Volta on, a C compiler and Python's header."""
    header = Path(sysconfig.get_path("include"), "Python.h")
    return (find_spec("triton") is not None and any(map(which, ("cc", "gcc", "clang"))) and header.is_file()
            and torch.cuda.get_device_capability(device) >= (7, 0))


def recorder(mode: str, device: torch.device) -> Record:
    """Return what makes a function run in that mode."""
    return as_it_is if mode == "none" else partial(Recorded, cuda_graph, device)


def fuse(rssm: RSSM, backend: str = "inductor") -> None:
    """Have torch.compile fuse the kernels of a step: of the scan, of its gradient, of imagination."""
    compiled = partial(torch.compile, backend=backend, dynamic=False, fullgraph=True)
    rssm.steps = Steps(*(compiled(step) for step in rssm.steps))
    rssm.imagine = compiled(rssm.imagine)  # type: ignore[method-assign]
