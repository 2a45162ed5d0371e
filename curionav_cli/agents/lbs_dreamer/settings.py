"""The settings of LBS Dreamer; the values stand in conf/agent and conf/scale/lbs_dreamer."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from curionav_cli.bounds import bounded, within
from curionav_cli.constants import IMAGE_CHANNELS, IMAGE_SIDE, OptionSet


class Precision(Enum):
    """The type that matrix products and convolutions are computed in.

    auto is bfloat16 at scale=paper, on CUDA or on a processor that has it natively and multiplies faster in it; else
    float32. At scale=cpu it is float32 everywhere: learning in bfloat16 was not compared there.
    """

    auto = "auto"
    float32 = "float32"
    bfloat16 = "bfloat16"


class Curiosity(Enum):
    """The intrinsic reward; agents/lbs_dreamer/curiosity has a file for each."""

    lbs = "lbs"
    picture_count = "picture_count"
    lbs_count = "lbs_count"
    disagreement = "disagreement"
    rnd = "rnd"
    count = "count"
    shuffled = "shuffled"
    none = "none"


class BehaviourKind(Enum):
    """How it chooses: by an actor that is trained in imagination, or by a search there at each choice (planner.py)."""

    actor = "actor"
    plan = "plan"


@dataclass(frozen=True)
class LBSDreamer:
    """The paper's hyperparameter table in its order, then what it leaves out.

    The encoder's first stride and the decoder's last are equal, and divide their kernels: images are held as patches of
    that side.
    """

    name: str
    curiosity: Curiosity
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
    options: OptionSet  # seven: an action is an option, whose length takes the place of action_repeat
    action_repeat: int  # steps for which an action is held; the model observes the frames that are acted on
    behaviour: BehaviourKind
    plan_depth: int  # actions of a sequence, all of which are followed: A^depth of A actions
    plan_samples: int  # rollouts of each sequence
    plan_temperature: float  # share of an action's mean value at which the policy prefers one value to another e-fold
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
    curiosity_burn_in: int  # 0 in mastering-urlb; leaving steps out is our choice
    precision: Precision

    def __post_init__(self) -> None:
        bounded("agent", self, {
            "kl_balance gamma return_lambda weight_decay decoded_share reward_momentum reward_centring "
            "model_lr actor_lr critic_lr adam_epsilon": (0, 1),
            "free_nats entropy": (0, 10**6), "curiosity_burn_in": (0, 10**9), "clip": (1e-8, 1e9),
            "mlp_layers": (1, 100), "action_repeat": (1, 1000), "horizon": (2, 1000),
            "plan_depth": (1, 4), "plan_samples": (1, 100), "plan_temperature": (1e-4, 1e4),
            "batch_size latent_dimension gru_units mlp_units rssm_hidden": (1, 10**4),
            "sequence_length latent_classes": (2, 10**4),
            "imagination_starts": (1, 10**6), "slow_critic_interval behaviour_interval": (1, 10**9)})
        check_layers("agent.encoder", self.encoder_channels, self.encoder_kernels, self.encoder_strides)
        check_layers("agent.decoder", [*self.decoder_channels, IMAGE_CHANNELS], self.decoder_kernels,
                     self.decoder_strides)
        side = 1
        for kernel, stride in zip(self.decoder_kernels, self.decoder_strides, strict=True):
            side = (side - 1) * stride + kernel
        if side != IMAGE_SIDE:
            raise ValueError(f"agent.decoder_kernels: with these strides the image has side {side}, not {IMAGE_SIDE}")
        patch, kernels = self.encoder_strides[0], (self.encoder_kernels[0], self.decoder_kernels[-1])
        if patch != self.decoder_strides[-1] or IMAGE_SIDE % patch or any(kernel % patch for kernel in kernels):
            raise ValueError("agent.encoder_strides: the first must be the last of agent.decoder_strides, "
                             f"and divide {IMAGE_SIDE} and the kernels of those two layers")


def check_layers(key: str, channels: list[int], kernels: list[int], strides: list[int]) -> None:
    """Raises ValueError unless the three lists describe the same one or more layers."""
    if not 2 <= len(channels) == len(kernels) == len(strides):
        raise ValueError(f"{key}_channels: two layers at least, with a kernel and a stride each")
    for name, numbers in (("channels", channels), ("kernels", kernels), ("strides", strides)):
        for number in numbers:
            within(f"{key}_{name}", number, least=1, most=10**4)
