"""torchrl: its environment, with what info holds, and its collector."""

from __future__ import annotations

import pytest

from curionav_cli.world.registration import SCENES

pytestmark = [pytest.mark.clients, pytest.mark.filterwarnings("ignore::DeprecationWarning")]


@pytest.mark.parametrize("name", SCENES)
def test_it_builds_every_world_and_collects(world, name: str) -> None:
    """GymEnv tries frameskip= first, and goes on because of our TypeError's words."""
    pytest.importorskip("torchrl")
    import torch
    from torchrl.collectors import Collector
    from torchrl.envs import GymEnv, check_env_specs

    settings = world(name, reward="coverage", max_episode_steps=6)
    env = GymEnv(settings.pop("id"), **settings).auto_register_info_dict()
    check_env_specs(env)
    walk = env.rollout(10, break_when_any_done=False)
    assert walk["next", "truncated"].flatten().tolist() == [False] * 5 + [True] + [False] * 4
    assert walk["next", "episode_index"].diff().tolist() == [0] * 5 + [1] + [0] * 3
    assert walk["next", "collided"].dtype == torch.bool and walk["next", "pose"].shape == (10, 3)
    collector = Collector(env, None, frames_per_batch=16, total_frames=32)
    assert [batch["image"].shape for batch in collector] == [(16, 64, 64, 3)] * 2
    collector.shutdown()
