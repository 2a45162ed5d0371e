"""Every setting's type and range, as plain dataclasses; the values stand in conf/, once.

A field without a default has its value in a YAML file. __post_init__ raises ValueError with
'key: what is wrong' for a value that its type allows and its meaning does not.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any


class Device(Enum):
    """Where tensors live; auto takes a CUDA device if there is one."""

    auto = "auto"
    cpu = "cpu"
    cuda = "cuda"


class Scale(Enum):
    """cpu: minutes on two cores; paper: the paper's hyperparameter table."""

    cpu = "cpu"
    paper = "paper"


@dataclass(frozen=True)
class Loop:
    """One life: `episodes` times N `steps` of acting, then K `iterations` of learning."""

    steps: int
    iterations: int
    episodes: int

    def __post_init__(self) -> None:
        within("loop.steps", self.steps, least=1)
        within("loop.iterations", self.iterations, least=0)
        within("loop.episodes", self.episodes, least=1)


@dataclass(frozen=True)
class Random:
    """Each action equally likely."""

    name: str


@dataclass(frozen=True)
class Sticky:
    """Repeats its last action with probability `repeat`."""

    name: str
    repeat: float

    def __post_init__(self) -> None:
        within("agent.repeat", self.repeat, least=0, most=1)


@dataclass(frozen=True)
class Bounce:
    """Forward until blocked, then a turn drawn from [min_turn, max_turn] degrees, either way."""

    name: str
    min_turn: float
    max_turn: float

    def __post_init__(self) -> None:
        within("agent.min_turn", self.min_turn, least=10, most=180)
        within("agent.max_turn", self.max_turn, least=self.min_turn, most=180)


@dataclass(frozen=True)
class Frontier:
    """The oracle: is told the map, walks to the nearest cell it has not visited."""

    name: str


class Precision(Enum):
    """What products and convolutions are computed in."""

    float32 = "float32"
    bfloat16 = "bfloat16"


@dataclass(frozen=True)
class LBSDreamer:
    """The paper's hyperparameter table in its order, then what it leaves out.

    The encoder's first stride and the decoder's last are one number, and divide their kernels: images
    are kept as patches of that side.
    """

    name: str
    # World model
    batch_size: int
    sequence_length: int
    latent_dimension: int
    latent_classes: int
    gru_units: int
    free_nats: float
    kl_balance: float
    model_lr: float
    slow_critic_interval: int  # in updates of the critic
    # Actor-critic
    horizon: int
    gamma: float
    return_lambda: float
    actor_lr: float
    critic_lr: float
    entropy: float
    # Common
    mlp_layers: int
    mlp_units: int
    adam_epsilon: float
    weight_decay: float
    clip: float
    # Not in the table
    rssm_hidden: int
    encoder_channels: list[int]
    encoder_kernels: list[int]
    encoder_strides: list[int]
    decoder_channels: list[int]
    decoder_kernels: list[int]
    decoder_strides: list[int]
    decoded_share: float
    behaviour_interval: int
    imagination_starts: int
    reward_momentum: float
    reward_centring: float
    lbs_burn_in: int
    precision: Precision

    def __post_init__(self) -> None:
        at_least = {0: ("free_nats", "model_lr", "actor_lr", "critic_lr", "entropy", "adam_epsilon",
                        "lbs_burn_in"),
                    1: ("batch_size", "latent_dimension", "gru_units", "slow_critic_interval", "mlp_layers",
                        "mlp_units", "rssm_hidden", "behaviour_interval", "imagination_starts"),
                    2: ("sequence_length", "latent_classes", "horizon")}
        for least, keys in at_least.items():
            for key in keys:
                within(f"agent.{key}", getattr(self, key), least=least)
        for key in ("kl_balance", "gamma", "return_lambda", "weight_decay", "decoded_share",
                    "reward_momentum", "reward_centring"):
            within(f"agent.{key}", getattr(self, key), least=0, most=1)
        within("agent.clip", self.clip, least=1e-8)
        check_layers("agent.encoder", self.encoder_channels, self.encoder_kernels, self.encoder_strides)
        check_layers("agent.decoder", [*self.decoder_channels, 3], self.decoder_kernels, self.decoder_strides)
        side = 1
        for kernel, stride in zip(self.decoder_kernels, self.decoder_strides, strict=True):
            side = (side - 1) * stride + kernel
        if side != 64:
            raise ValueError(f"agent.decoder_kernels: with these strides the image has side {side}, not 64")
        patch, kernels = self.encoder_strides[0], (self.encoder_kernels[0], self.decoder_kernels[-1])
        if patch != self.decoder_strides[-1] or 64 % patch or any(kernel % patch for kernel in kernels):
            raise ValueError("agent.encoder_strides: the first must be the last of agent.decoder_strides, "
                             "and divide 64 and the kernels of those two layers")


def check_layers(key: str, channels: list[int], kernels: list[int], strides: list[int]) -> None:
    """Raises ValueError unless the three lists describe the same one or more layers."""
    if not 2 <= len(channels) == len(kernels) == len(strides):
        raise ValueError(f"{key}_channels: two layers at least, with a kernel and a stride each")
    for name, numbers in (("channels", channels), ("kernels", kernels), ("strides", strides)):
        within(f"{key}_{name}", min(numbers), least=1)


@dataclass(frozen=True)
class Robot:
    """ideal: perfect motion, put back to the start after each episode."""

    name: str


class Collision(Enum):
    """A forward move that would hit something: is not made, ends there, or slides along (Habitat)."""

    cancel = "cancel"
    stop = "stop"
    slide = "slide"


class Engine(Enum):
    """What draws the pictures: numpy, always there, or numba, faster, from the extra `fast`."""

    numpy = "numpy"
    numba = "numba"


@dataclass(frozen=True)
class Env:
    """A scene in metres and degrees; world/scene_format.py explains the lists.

    A scene either has a `size` or opens a ROS `map`. `visitable` is a promise about the number of
    cells a robot of `visitable_radius` can reach: a scene that breaks it does not load.
    """

    name: str
    radius: float
    camera: float  # height of the camera above the floor
    note: str = ""
    size: list[float] | None = None  # x and y of the inside
    map: str | None = None  # the YAML file of a ROS map
    overlay: str | None = None  # a YAML file with what the map does not know: the lists below, start, dock
    unknown_grey: int | None = None  # the grey value that means unknown, whatever the thresholds say
    cell: float | None = None  # of the coverage grid; none: that of the map
    height: float = 2.5
    agent_height: float = 0.5
    fov: float = 79.0
    collision: Collision = Collision.cancel
    start: list[float] | None = None  # x, y, degrees; none: the roomiest place
    dock: list[float] | None = None  # none: the start
    visitable: int | None = None
    visitable_radius: float | None = None  # none: the radius above
    visitable_sha256: str | None = None
    rooms: list[Any] = field(default_factory=list)
    walls: list[Any] = field(default_factory=list)
    solids: list[Any] = field(default_factory=list)  # heights and materials of what a map shows as occupied
    posters: list[Any] = field(default_factory=list)
    lamps: list[Any] = field(default_factory=list)
    furniture: list[Any] = field(default_factory=list)
    repeat: list[Any] = field(default_factory=list)
    tune: dict[str, Any] = field(default_factory=dict)
    light: dict[str, Any] = field(default_factory=dict)
    moves: list[Any] = field(default_factory=list)
    engine: Engine = Engine.numpy
    changes: bool = True  # false: neither light nor moves, whatever stands there


@dataclass(frozen=True)
class Config:
    """All settings of one run. `agent` is the dataclass of the chosen agent."""

    seed: int
    device: Device
    scale: Scale
    loop: Loop
    env: Env
    agent: Any
    robot: Robot

    def __post_init__(self) -> None:
        within("seed", self.seed, least=0, most=2**32 - 1)


def within(key: str, value: float, least: float = float("-inf"), most: float = float("inf")) -> None:
    """Raises ValueError with 'key: ...' unless least <= value <= most (nan is never within)."""
    if least <= value <= most:
        return
    if most == float("inf"):
        raise ValueError(f"{key}: {value} is less than {least}")
    raise ValueError(f"{key}: {value} is not between {least} and {most}")
