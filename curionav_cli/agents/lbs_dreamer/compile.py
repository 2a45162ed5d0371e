"""How the agent's functions run on its device: eagerly, as CUDA graphs, or with fused kernels.

Fused kernels are made by torch.compile on a GPU, where they are CUDA graphs too, and by numba on a CPU.
"""

from __future__ import annotations

import logging
import sysconfig
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from shutil import which

import torch
from torch import nn

from curionav_cli.agents.lbs_dreamer.behaviour import Behaviour
from curionav_cli.agents.lbs_dreamer.kernels.cuda_graphs import Record, Recorded, as_it_is, cuda_graph
from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.kernels.patches import to_byte_patches
from curionav_cli.agents.lbs_dreamer.kernels.rssm_scan import PLAIN, Steps
from curionav_cli.agents.lbs_dreamer.learner import Networks
from curionav_cli.agents.lbs_dreamer.networks import Decoder, Encoder
from curionav_cli.agents.lbs_dreamer.rssm import RSSM
from curionav_cli.agents.lbs_dreamer.settings import Precision
from curionav_cli.agents.lbs_dreamer.world_model import WorldModel
from curionav_cli.errors import ConfigError

log = logging.getLogger("curionav")


def compile_mode(compile: str, device: torch.device, precision: Precision = Precision.float32) -> str:
    """Resolve the setting compile to none, graph or fused. Raises ConfigError where that is not possible here.

    On a CPU auto is none: fusing pays in long runs only, and in float32 only.
    """
    on_cpu = device.type == "cpu"
    if compile == "auto":
        compile = "none" if on_cpu else "fused" if can_fuse(device) else "graph"
        log.info("compile=auto is compile=%s here", compile)
    if on_cpu and compile == "graph":
        raise ConfigError("compile=graph needs a CUDA device, and this run computes on the CPU. "
                          "Use compile=auto or compile=none.")
    if on_cpu and compile == "fused" and not can_fuse(device):
        raise ConfigError("compile=fused on a CPU needs numba, which is not installed. "
                          "Use compile=auto, or: .venv/bin/pip install -c constraints.txt -e '.[fast]'")
    if on_cpu and compile == "fused" and precision is Precision.bfloat16:
        raise ConfigError("compile=fused on a CPU fuses float32 alone. Use compile=none, or agent.precision=float32.")
    return compile


def can_fuse(device: torch.device) -> bool:
    """Tell whether kernels can be fused: on a CPU with numba, on a GPU with Triton.

    Triton needs a GPU from Volta on, a C compiler and Python's header.
    """
    if device.type == "cpu":
        return find_spec("numba") is not None
    header = Path(sysconfig.get_path("include"), "Python.h")
    return (find_spec("triton") is not None and any(map(which, ("cc", "gcc", "clang"))) and header.is_file()
            and torch.cuda.get_device_capability(device) >= (7, 0))


def recorder(mode: str, device: torch.device) -> Record:
    """Return what makes a function run in that mode."""
    return as_it_is if mode == "none" or device.type == "cpu" else partial(Recorded, cuda_graph, device)


def fuse_on(device: torch.device, networks: Networks) -> None:
    """Have the steps of the RSSM run as fused kernels on its device, on a CPU images and every ELU too."""
    rssm = networks.world_model.rssm
    if device.type == "cpu":
        fuse_rows(rssm, networks.behaviour)
        fuse_images(networks.world_model)
        fuse_elu(networks)
    else:
        fuse(rssm)


def fuse_rows(rssm: RSSM, behaviour: Behaviour) -> None:
    """Have numba's functions do all steps of filtering, of its gradient and of imagination."""
    from curionav_cli.agents.lbs_dreamer.kernels.fused_filter import FusedLoop  # it imports numba
    from curionav_cli.agents.lbs_dreamer.kernels.fused_imagination import imagine

    rssm.steps = FusedLoop()
    behaviour.imagine = partial(imagine, behaviour.actor)  # type: ignore[method-assign]


def fuse_images(model: WorldModel) -> None:
    """Have numba's functions encode images and compare them with decoded ones; patches stay bytes until then."""
    from curionav_cli.agents.lbs_dreamer.kernels import fused_images

    if fused_images.pays(model.encoder, model.decoder):
        model.patches = partial(to_byte_patches, stride=model.encoder.stride)  # type: ignore[method-assign]
        model.encoder.forward = partial(fused_images.encoded, model.encoder)  # type: ignore[method-assign]
        model.image_error = partial(fused_images.decoded_error, model.decoder)  # type: ignore[method-assign]


def fuse_elu(networks: nn.Module) -> None:
    """Have numba's function be the ELU of encoder, decoder and all MLPs."""
    from curionav_cli.agents.lbs_dreamer.kernels.fused_elu import fused_elu_

    for part in networks.modules():
        if isinstance(part, (Encoder, Decoder, MLP)):
            part.elu = fused_elu_


def fuse(rssm: RSSM, backend: str = "inductor") -> None:
    """Have torch.compile fuse the kernels of a step: of the scan, of its gradient, of imagination."""
    compiled = partial(torch.compile, backend=backend, dynamic=False, fullgraph=True)
    rssm.steps = Steps(*(compiled(step) for step in PLAIN))
    rssm.imagine = compiled(rssm.imagine)  # type: ignore[method-assign]
