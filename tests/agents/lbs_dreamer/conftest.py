"""A learner small enough for quick tests, and episodes whose pixels depend on the actions."""

from pathlib import Path

import numpy as np
import pytest
import torch
from omegaconf import OmegaConf

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer
from curionav_cli.agents.lbs_dreamer.learner import build_networks
from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.records import Episode
from curionav_cli.storage.replay import Replay

SCALES = Path(__file__).parents[3] / "conf" / "scale" / "lbs_dreamer"
TINY = {
    "batch_size": 3, "sequence_length": 8, "latent_dimension": 4, "latent_classes": 4, "gru_units": 16,
    "rssm_hidden": 16, "mlp_units": 16, "mlp_layers": 1, "horizon": 4, "imagination_starts": 10,
    "encoder_channels": [4, 4, 8], "decoder_channels": [8, 4], "behaviour_interval": 2,
    "slow_critic_interval": 2, "action_repeat": 1,
}


@pytest.fixture(autouse=True)
def one_thread():
    torch.set_num_threads(1)


@pytest.fixture
def hyper():
    """hyper(scale, **changes): the shipped settings of a scale, cpu.yaml laid over paper.yaml, in float32."""
    def make(scale="cpu", **changes):
        settings = OmegaConf.merge(OmegaConf.structured(lbs_settings.LBSDreamer),
                                   {"name": "lbs_dreamer", "curiosity": "lbs"})
        for name in ("paper", "cpu")[:1 if scale == "paper" else 2]:
            layer = OmegaConf.load(SCALES / f"{name}.yaml")
            layer.pop("defaults", None)
            settings = OmegaConf.merge(settings, layer)
        return OmegaConf.to_object(OmegaConf.merge(settings, {"precision": "float32"}, changes))
    return make


@pytest.fixture
def tiny(hyper):
    """tiny(**changes): settings for a learner of a few thousand weights."""
    return lambda **changes: hyper("cpu", **{**TINY, **changes})


@pytest.fixture
def networks():
    """networks(hyper, seed=0) on the CPU."""
    return lambda settings, seed=0: build_networks(
        settings, torch.Generator().manual_seed(seed), torch.device("cpu"))


@pytest.fixture
def agent(tiny, a_plan):
    """agent(seed=0, **changes): a tiny agent."""
    return lambda seed=0, **changes: LBSDreamer(tiny(**changes), seed, "cpu", a_plan())


@pytest.fixture
def replay():
    """replay(episodes=3, steps=20): coloured stripes that move with each action."""
    def make(episodes=3, steps=20):
        return Replay([stripes(steps, seed) for seed in range(episodes)])
    return make


@pytest.fixture
def data(replay):
    """A batch of the tiny learner's size, as the agent hands it to the learner."""
    batch = replay().sample(3, 8, np.random.default_rng(0))
    image, action = (torch.from_numpy(batch[key]).transpose(0, 1).contiguous() for key in ("image", "action"))
    return Sequences(image, action, torch.from_numpy(batch["is_start"]))


def stripes(steps, seed):
    """A striped wall: left and right shift it, forward changes its colour."""
    rng = np.random.default_rng(seed)
    action = rng.integers(0, 3, steps)
    shift = np.concatenate([[0], np.cumsum(np.select([action == 1, action == 2], [4, -4], 0))])
    red = 100 + 40 * np.concatenate([[0], np.cumsum(action == 0)]) % 150
    column = (np.arange(64)[None] + shift[:, None]) % 64
    image = np.zeros((steps + 1, 64, 64, 3), np.uint8)
    image[..., 0] = red[:, None, None]
    image[..., 1] = (4 * column)[:, None, :]
    image[..., 2] = (np.where(column // 8 % 2, 220, 30))[:, None, :]
    return Episode(image, action, np.zeros((steps + 1, 3)), np.zeros(steps, bool))
