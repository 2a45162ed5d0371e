"""Config: every setting's type and range, as plain dataclasses; the values stand in conf/, once.

A field without a default has its value in a YAML file. __post_init__ raises ValueError with
'key: what is wrong' for a value that its type allows and its meaning does not.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from difflib import get_close_matches
from enum import Enum
from typing import Any

from curionav_cli.bounds import bounded, within
from curionav_cli.remote.settings import Remote
from curionav_cli.results.settings import Results
from curionav_cli.world.settings import Env


class Device(Enum):
    """Where tensors are; auto takes a CUDA device if there is one."""

    auto = "auto"
    cpu = "cpu"
    cuda = "cuda"


class Compile(Enum):
    """How updates run. none: kernel by kernel; graph: as CUDA graphs; fused: with fewer kernels, which torch.compile
    makes for CUDA graphs and numba, in float32, for a CPU. auto is none on a CPU; on CUDA fused, or graph without a
    compiler."""

    auto = "auto"
    none = "none"
    graph = "graph"
    fused = "fused"


class Learner(Enum):
    """Where learning happens. local: in this process; remote: in curionav train, by way of `storage`."""

    local = "local"
    remote = "remote"


class Logger(Enum):
    """Where metrics go beside metrics.jsonl: nowhere, or to a file that TensorBoard, Weights & Biases or trackio shows.
    """

    local = "local"
    tensorboard = "tensorboard"
    wandb = "wandb"
    trackio = "trackio"

    @classmethod
    def chosen(cls, value: Any) -> tuple[str, ...]:
        """The names of `logger=`: one, or a list. Raises ValueError, with the nearest, for one that there is not."""
        if isinstance(value, list | tuple) and not value:
            raise ValueError("logger=[] names no logger. Set logger=local for metrics.jsonl alone.")
        several = value if isinstance(value, list | tuple) else [value]
        names: list[Any] = [getattr(one, "value", one) for one in several]
        known = [member.value for member in cls]
        for name in names:
            if name not in known:
                near = get_close_matches(str(name), known, 2)
                raise ValueError(f"logger: {name!r} is not one of {', '.join(known)}, or a list [...] of them."
                                 + (f" Did you mean {' or '.join(near)}?" if near else ""))
        return tuple(dict.fromkeys(names))


class Scale(Enum):
    """The size of an experiment. cpu: minutes on two cores; paper: the paper's hyperparameter table."""

    cpu = "cpu"
    paper = "paper"


class Keep(Enum):
    """Which images a run keeps. all: of every frame; replay: those that the learner may still draw, and the newest
    episodes whole; poses: as replay, and none once the run is done."""

    all = "all"
    replay = "replay"
    poses = "poses"


@dataclass(frozen=True)
class Loop:
    """One run: `episodes` times N `steps` of acting, then K `iterations` of learning (paper, "Lifelong learning").

    Offline training does not act: `iterations` are its total.
    """

    steps: int
    iterations: int
    episodes: int
    replay_memory: float  # GB of frames; the others are read from the disk
    replay_episodes: int | None  # the newest, from which a learner draws; None: from all
    keep: Keep

    def __post_init__(self) -> None:
        bounded("loop", self, {"steps episodes": (1, 10**6), "iterations": (0, 10**9), "replay_memory": (0, 10**6)})
        if self.replay_episodes is not None:
            bounded("loop", self, {"replay_episodes": (1, 10**6)})


@dataclass(frozen=True)
class Dock:
    """The docking trial: `requests` returns to the dock, each after an episode of loop.steps."""

    requests: int = 600

    def __post_init__(self) -> None:
        bounded("dock", self, {"requests": (1, 10**6)})


@dataclass(frozen=True)
class Config:
    """All settings of one run. agent, robot: the dataclasses of the chosen options."""

    seed: int
    device: Device
    compile: Compile
    scale: Scale
    data: str | None  # the folder of the episodes for offline training
    learner: Learner
    storage: str | None  # a URL: where robot and server meet
    remote: Remote
    loop: Loop
    env: Env
    agent: Any
    robot: Any
    dock: Dock = field(default_factory=Dock)
    question: str | None = None  # of a sweep, in a sentence; it opens the page that compare writes
    logger: Any = Logger.local  # one, or a list of them; runs of earlier versions do not record it
    init: str | None = None  # the folder of a run or card: evaluate acts with its weights, explore and train begin so
    results: Results = field(default_factory=Results)

    def __post_init__(self) -> None:
        within("seed", self.seed, least=0, most=2**32 - 1)
        chosen = Logger.chosen(self.logger)
        if isinstance(self.logger, str):
            object.__setattr__(self, "logger", Logger(*chosen))

    @property
    def loggers(self) -> tuple[str, ...]:
        """The names of the loggers."""
        return Logger.chosen(self.logger)
