"""How the agent's functions run on its device."""

from __future__ import annotations

from functools import partial

import torch

from curionav_cli.agents.lbs_dreamer.graphs import Record, Recorded, as_it_is, cuda_graph
from curionav_cli.errors import ConfigError


def recorder(compile: str, device: torch.device) -> Record:
    """auto, none or graph -> what makes an update run that way. Raises ConfigError for a graph without CUDA."""
    if compile == "none" or (compile == "auto" and device.type == "cpu"):
        return as_it_is
    if device.type == "cpu":
        raise ConfigError(f"compile={compile} needs a CUDA device, and this run computes on the CPU. "
                          "Use compile=auto or compile=none.")
    return partial(Recorded, cuda_graph, device)
