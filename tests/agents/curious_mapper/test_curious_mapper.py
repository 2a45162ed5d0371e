"""The curious mapping explorer by the agent's contract, with a world model of a few thousand weights."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from entry import Cli
from omegaconf import OmegaConf

from curionav_cli.agents.curious_mapper import make
from curionav_cli.agents.curious_mapper.agent import CuriousMapper
from curionav_cli.agents.curious_mapper.settings import CuriousMapper as Settings
from curionav_cli.agents.setup import Setup
from curionav_cli.errors import WeightsRefused
from curionav_cli.loop import Callbacks, run_episode
from curionav_cli.records import Episode
from curionav_cli.storage.replay import Replay
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.scene.scene import Scene

CONF = Path(__file__).parents[3] / "conf"
TINY = {
    "batch_size": 3, "sequence_length": 8, "latent_dimension": 4, "latent_classes": 4, "gru_units": 16,
    "rssm_hidden": 16, "mlp_units": 16, "mlp_layers": 1, "encoder_channels": [4, 4, 8], "decoder_channels": [8, 4],
    "precision": "float32",
}
ROOM: dict[str, Any] = {
    "name": "two", "size": [3.0, 2.0], "cell": 0.1, "radius": 0.15, "camera": 0.45, "height": 2.4,
    "start": [0.5, 0.5, 0], "walls": [{"line": [1.7, 0.0, 1.7, 2.0], "gaps": [[0.6, 0.9]]}],
    "furniture": [{"kind": "box", "x": 2.5, "y": 1.2, "name": "box"}],
}
WORDS = ("env=small_room", "agent=curious_mapper", "device=cpu", "loop.steps=12", "loop.iterations=2",
         *(f"agent.{key}={value}" for key, value in TINY.items()))


@pytest.fixture(scope="module")
def env() -> NavigationEnv:
    return NavigationEnv(Scene.from_dict(ROOM))


def settings(**changes: Any) -> Settings:
    merged = OmegaConf.structured(Settings)
    for file in ("scale/lbs_dreamer/paper", "scale/lbs_dreamer/cpu", "agent/curious_mapper"):
        layer = OmegaConf.load(CONF / f"{file}.yaml")
        layer.pop("defaults", None)
        merged = OmegaConf.merge(merged, layer)
    return OmegaConf.to_object(OmegaConf.merge(merged, TINY, changes))


def agent(env: NavigationEnv, seed: int = 0, **changes: Any) -> CuriousMapper:
    torch.set_num_threads(1)
    made = make(settings(**changes), Setup(seed, "cpu", "none", "numpy", env.scene))
    assert isinstance(made, CuriousMapper)
    return made


def one_episode(made: CuriousMapper, env: NavigationEnv, index: int, steps: int = 30) -> Episode:
    observation, info = env.reset(seed=0, options={"episode": index})
    return run_episode(env, made, observation, info, steps, Callbacks())


def episodes(made: CuriousMapper, env: NavigationEnv, count: int, replay: Replay, steps: int = 30) -> list[list[int]]:
    """Act and learn; the actions of each episode."""
    done = []
    for _ in range(count):
        episode = one_episode(made, env, len(replay), steps)
        replay.add(episode)
        made.learn(replay, 2, lambda i: None)
        done.append(episode.action.tolist())
    return done


def saved(made: CuriousMapper, folder: Path) -> dict[str, bytes]:
    folder.mkdir()
    made.save(folder)
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("surprise", ["measured", "shuffled", "visits"])
def test_it_explores_and_reports(env: NavigationEnv, surprise: str) -> None:
    made, replay = agent(env, surprise=surprise), Replay()
    actions = episodes(made, env, 2, replay, steps=80)
    landed = np.zeros(env.scene.plan.visitable.shape, bool)
    for index in range(2):
        pose = replay.episode(index).pose
        landed[env.scene.plan.cells(pose[:, 0], pose[:, 1])] = True
    assert (landed & env.scene.plan.visitable).sum() > 0.1 * env.scene.plan.visitable.sum()
    report = made.report()
    assert report["surprise_expected"] > report["surprise_usual"] > 0 and len(set(actions[1])) == 3
    assert made.learner.updates == 4 and made.learner.behaviour_updates == 0


def test_surprise_is_that_of_filtering(env: NavigationEnv) -> None:
    """Its measurement is the KL that the world model has of the same images and actions with the same noise."""
    made = agent(env)
    felt, noise = [], []
    made.driver.add_measurement = lambda surprise: felt.append(surprise)  # type: ignore[method-assign]
    inner = made.filter
    made.filter = lambda step: noise.append(step.noise) or inner(step)  # type: ignore[method-assign]
    episode = one_episode(made, env, 0, steps=20)
    model = made.learner.networks.world_model
    action = torch.tensor([-1, *episode.action[:-1]])[:, None]
    with torch.no_grad():
        observed = model.observe(model.rssm.initial(1), model.patches(torch.from_numpy(episode.image[:-1])), action,
                                 torch.stack(noise)[..., :-1])
        p, q = (logits.softmax(-1) for logits in (observed.prior, observed.posterior))
        kl = (q * (q.log() - p.log())).sum((-1, -2))[:, 0]
    assert felt[:2] == [None, None], "of a state that began with zeros"
    torch.testing.assert_close(torch.tensor(felt[2:]), kl[2:], rtol=1e-4, atol=1e-5)


def test_it_goes_on_to_the_byte_from_what_it_saved(env: NavigationEnv, tmp_path: Path) -> None:
    made, replay = agent(env), Replay()
    episodes(made, env, 2, replay)
    saved(made, tmp_path / "half")
    other = agent(env, seed=9)
    other.load(tmp_path / "half")
    other.seed = made.seed
    same = Replay(replay.episode(index) for index in range(2))
    assert episodes(made, env, 2, replay) == episodes(other, env, 2, same)
    assert saved(made, tmp_path / "one") == saved(other, tmp_path / "two")


def test_weights_go_to_the_robot_and_its_map_stays(env: NavigationEnv, tmp_path: Path) -> None:
    """A robot with the weights of a server acts as an agent that learned itself; the server has no map."""
    alone, robot, server = (agent(env) for _ in range(3))
    mine, at_server = Replay(), Replay()
    for index in range(3):
        [actions] = episodes(alone, env, 1, mine)
        episode = one_episode(robot, env, index)
        assert episode.action.tolist() == actions
        at_server.add(episode)
        server.learn(at_server, 2, lambda i: None)
        robot.import_weights(server.export_weights())
    assert robot.export_weights() == server.export_weights() == alone.export_weights()
    robots, servers, ours = (saved(each, tmp_path / name) for name, each in
                             (("robot", robot), ("server", server), ("alone", alone)))
    assert robots["map.npz"] == ours["map.npz"] != servers["map.npz"]
    assert robots["mapper.json"] == ours["mapper.json"]


def test_weights_that_cannot_act_are_refused_and_change_nothing(env: NavigationEnv) -> None:
    made, spoilt = agent(env), agent(env)
    before = made.export_weights()
    for tensor in spoilt.acting_weights().values():
        tensor.fill_(3e38)
    with pytest.raises(WeightsRefused, match="no finite numbers"):
        made.import_weights(spoilt.export_weights())
    assert made.export_weights() == before


def test_it_predicts_for_the_figures(env: NavigationEnv) -> None:
    made = agent(env)
    prediction = made.predict(0, one_episode(made, env, 0))
    assert prediction and {"open_loop_mse_5", "repeat_mse_5"} <= prediction.metrics().keys()


@pytest.mark.parametrize(("word", "said"), [
    ("agent.entropy=0.3", "agent=curious_mapper does not read agent.entropy. It is a setting of agent=lbs_dreamer,"),
    ("agent.surprise=loud", "agent.surprise"),
    ("agent.sequence_length=99", "agent.sequence_length=99 does not fit into an episode of 12 steps"),
])
def test_wrong_use_is_answered_in_a_line(cli: Cli, word: str, said: str) -> None:
    refused = cli("explore", *WORDS, word)
    assert refused.code == 2 and said in refused.error
    assert len(refused.error.strip().splitlines()) <= 2 and not re.search("Traceback", refused.error)


@pytest.mark.parametrize(("key", "value"), [("action_repeat", 4), ("curiosity", "lbs"), ("behaviour", "plan")])
def test_a_file_cannot_set_what_it_does_not_read(key: str, value: object) -> None:
    with pytest.raises(Exception, match=rf"agent\.{key}.*"):
        settings(**{key: value})


def test_what_it_does_not_read_is_not_offered(cli: Cli) -> None:
    shown = cli("explore", "--help", "agent=curious_mapper").out
    assert "agent.optimism" in shown and "agent.model_lr" in shown
    assert not re.search(r"agent\.(entropy|horizon|plan_depth|behaviour|curiosity) ", shown)


@pytest.mark.parametrize(("key", "value", "limits"), [
    ("stay", -1.0, "0 and 1000000"), ("optimism", 2.0, "0 and 1"), ("sight", 0.0, "0.1 and 10.0"),
])
def test_numbers_that_cannot_be_are_refused_by_name(key: str, value: float, limits: str) -> None:
    with pytest.raises(Exception, match=f"agent.{key}: {value} is not between {limits}"):
        settings(**{key: value})


@pytest.mark.slow
def test_it_runs_and_is_resumed_by_the_command(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *WORDS, "loop.episodes=2", "hydra.run.dir=whole").code == 0
    assert cli("explore", *WORDS, "loop.episodes=1", "hydra.run.dir=half").code == 0
    assert cli("resume", "half", "loop.episodes=2").code == 0
    for file in ("episodes/000001.npz", "checkpoint/000002/map.npz", "checkpoint/000002/weights.safetensors",
                 "checkpoint/000002/rng.json", "checkpoint/000002/mapper.json"):
        assert (tmp_path / "whole" / file).read_bytes() == (tmp_path / "half" / file).read_bytes(), file
