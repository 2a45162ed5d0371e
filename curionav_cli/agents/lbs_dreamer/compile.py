"""How the agent's functions run on its device: kernel by kernel, as CUDA graphs, as graphs of fused kernels."""

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


def way(compile: str, device: torch.device) -> str:
    """The setting -> none, graph or fused. Raises ConfigError for what needs CUDA where there is none."""
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
    """Triton writes kernels for GPUs from Volta on; what starts them is C and needs Python's header."""
    header = Path(sysconfig.get_path("include"), "Python.h")
    return (find_spec("triton") is not None and any(map(which, ("cc", "gcc", "clang"))) and header.is_file()
            and torch.cuda.get_device_capability(device) >= (7, 0))


def recorder(way: str, device: torch.device) -> Record:
    """What makes a function run that way."""
    return as_it_is if way == "none" else partial(Recorded, cuda_graph, device)


def fuse(rssm: RSSM, backend: str = "inductor") -> None:
    """Let torch.compile make few kernels of the many of a step: of the scan, of its gradient, of imagination."""
    compiled = partial(torch.compile, backend=backend, dynamic=False, fullgraph=True)
    rssm.steps = Steps(*(compiled(step) for step in rssm.steps))
    rssm.imagine = compiled(rssm.imagine)  # type: ignore[method-assign]
