"""What learner.py measures of ours, an update and a step of acting on random data, and what bounds it."""

from __future__ import annotations

import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
ACTIONS = 3
CPU, CUDA = "cpu", "cuda"
Job = dict[str, Any]  # device, precision, times (updates in a row), hyper (the shapes), overrides (ours)


def batch(hyper: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Images (B, T, 64, 64, 3) uint8 and actions (B, T)."""
    rng, shape = np.random.default_rng(0), (hyper["batch_size"], hyper["sequence_length"])
    return rng.integers(0, 256, (*shape, 64, 64, 3), np.uint8), rng.integers(0, ACTIONS, shape)


def settings(overrides: list[str]) -> Any:
    """The shipped settings, composed as the command line does it."""
    from curionav_cli.config.compose import compose
    from curionav_cli.config.override_errors import OverrideErrors
    from curionav_cli.config.sources import opened

    with opened("benchmark") as hydra:
        return compose(hydra, OverrideErrors(hydra, overrides), overrides)[0]


def resident() -> float:
    """The most memory that this process took, in bytes."""
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def dense(hyper: dict[str, Any], again: bool = True) -> float:
    """GFLOP of an update by formula: products once, backwards twice, but for the gradients of detached inputs.

    again: the actor's layers are computed in imagination and, as peers do and ours does not, again for their gradient.
    """
    side, depth, encoder = 64, 3, 0
    for channels, kernel, stride in zip(*(hyper[f"encoder_{key}"] for key in ("channels", "kernels", "strides"))):
        side = (side - kernel) // stride + 1
        encoder += side**2 * kernel**2 * depth * channels
        depth = channels
    latent = hyper["latent_dimension"] * hyper["latent_classes"]
    deter, hidden = hyper["gru_units"], hyper["rssm_hidden"]
    embed, features = side**2 * depth, latent + deter
    side, depth, decoder = 1, embed, features * embed
    for channels, kernel, stride in zip([*hyper["decoder_channels"], 3], hyper["decoder_kernels"],
                                        hyper["decoder_strides"]):
        decoder += side**2 * kernel**2 * depth * channels
        side, depth = (side - 1) * stride + kernel, channels
    imagine = (latent + ACTIONS) * hidden + (hidden + deter) * 3 * deter + deter * hidden + hidden * latent
    observe = imagine + (deter + embed) * hidden + hidden * latent
    units, frames, horizon = hyper["mlp_units"], hyper["batch_size"] * hyper["sequence_length"], hyper["horizon"]
    first, head = features * units, features * units + (hyper["mlp_layers"] - 1) * units**2 + units
    actor, learned = head + (ACTIONS - 1) * units, lambda products: 3 * products - first
    starts = min(hyper["imagination_starts"], frames)
    model = 3 * frames * (encoder + observe + hyper["decoded_share"] * decoder) + frames * learned(head)
    behaviour = starts * (horizon * (imagine + actor) + 2 * (horizon + 1) * head
                          + (horizon - 1) * (learned(actor) - (0 if again else actor)) + horizon * learned(head))
    return 2 * (model + behaviour / hyper["behaviour_interval"]) / 1e9


class Torch:
    """What the contenders that are made with PyTorch share: one thread, its clock, its memory, its count."""

    packages: tuple[str, ...] = ("torch",)

    def __init__(self, job: Job):
        import torch

        torch.set_num_threads(1)
        self.torch, self.job, self.cuda = torch, job, job["device"] == CUDA

    def clock(self) -> float:
        """Seconds: CPU time of all threads; on a GPU the time when all that was asked for is done."""
        if self.cuda:
            self.torch.cuda.synchronize()
            return time.perf_counter()
        return time.process_time()

    def memory(self) -> float:
        """The most memory it took, in bytes; on a GPU of the GPU's."""
        return self.torch.cuda.max_memory_allocated() if self.cuda else resident()

    def warm(self) -> float:
        """The first updates. GFLOP of one: products and convolutions, counted as they are called for on a CPU."""
        from torch.utils.flop_counter import FlopCounterMode

        if self.cuda:
            for _ in range(self.job["times"]):
                self.update()
            return type(self)({**self.job, "device": CPU, "times": self.job["hyper"]["behaviour_interval"]}).warm()
        with FlopCounterMode(display=False) as counter:
            for _ in range(self.job["times"]):
                self.update()
        return counter.get_total_flops() / self.job["times"] / 1e9

    def update(self) -> Any:
        """One update of everything that learns."""
        raise TypeError(f"{type(self).__name__} does not learn")


class Curionav(Torch):
    """Ours, through the doors that the loop uses: Learner.update and LBSDreamer.act."""

    def __init__(self, job: Job):
        super().__init__(job)
        from curionav_cli import build
        from curionav_cli.agents.lbs_dreamer.world_model import Sequences
        from curionav_cli.storage.replay import NO_ACTION

        chosen = settings([*job["overrides"], f"device={job['device']}", f"agent.precision={job['precision']}"])
        self.agent = build.agent(chosen, build.scene(chosen))
        image, action = batch(job["hyper"])
        self.seen = {"image": image[0, 0], "depth": np.ones((64, 64), np.float32)}
        action[:, 0] = NO_ACTION
        self.data = Sequences(*(self.torch.from_numpy(part).transpose(0, 1).contiguous().to(job["device"])
                                for part in (image, action)),
                              self.torch.zeros(len(action), dtype=self.torch.bool, device=job["device"]))
        self.agent.begin()

    def update(self) -> None:
        self.agent.learner.update(self.data)

    def act(self) -> None:
        self.agent.act(self.seen, {"episode_index": 0})


class Probe(Torch):
    """The machine's own limit: products of two square matrices."""

    def peaks(self) -> dict[str, float]:
        """GFLOP/s in each precision."""
        side, rates = 8192 if self.cuda else 1024, {}
        for kind in ("float32", "bfloat16"):
            left = self.torch.ones(side, side, dtype=getattr(self.torch, kind), device=self.job["device"])
            left @ left
            begin = self.clock()
            for _ in range(8):
                left @ left
            rates[kind] = 8 * 2 * side**3 / (self.clock() - begin) / 1e9
        return rates
