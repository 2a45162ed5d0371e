"""Minari: a dataset holds what was seen, told and earned, to the byte."""

from __future__ import annotations

import numpy as np
import pytest

from curionav_cli.world.registration import SCENES

pytestmark = [pytest.mark.clients, pytest.mark.filterwarnings("ignore:Implicitly cleaning up:ResourceWarning")]


def collected(monkeypatch, folder, env, episodes: int, seeded: bool = True):
    """The dataset of a random walk, as it is read from the disk, and the rows (observations, rewards, infos) of it."""
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(folder))
    minari = pytest.importorskip("minari")
    pytest.importorskip("jax")
    collector = minari.DataCollector(env, record_infos=True, jpeg_encoding=False)
    rows = []
    for episode in range(episodes):
        observation, info = collector.reset(seed=episode if seeded else None)
        seen, told, earned, over = [observation], [info], [], False
        while not over:
            observation, reward, _, over, info = collector.step(collector.action_space.sample())
            seen.append(observation)
            told.append(info)
            earned.append(reward)
        rows.append((seen, earned, told))
    collector.create_dataset("curionav/walk-v0", eval_env=env.spec, algorithm_name="random", author="a",
                             author_email="a@example.com", code_permalink="https://example.com", description="a walk")
    collector.close()
    return minari.load_dataset("curionav/walk-v0"), rows


@pytest.mark.parametrize("name", SCENES)
def test_a_dataset_loses_nothing(made, name: str, tmp_path, monkeypatch) -> None:
    dataset, rows = collected(monkeypatch, tmp_path, made(name, reward="count", max_episode_steps=6), 2)
    assert len(dataset) == 2
    for stored, (seen, earned, told) in zip(dataset.iterate_episodes(), rows, strict=True):
        for key in ("image", "depth"):
            assert np.array_equal(stored.observations[key], np.stack([observation[key] for observation in seen]))
        for key in ("pose", "collided", "episode_index"):
            assert np.array_equal(stored.infos[key], np.stack([info[key] for info in told]))
        assert stored.rewards.tolist() == earned and stored.truncations.tolist() == [False] * 5 + [True]
    assert dataset.recover_environment().unwrapped.reward.name == "count"


def test_the_lab_changes_where_a_reset_goes_on(made, tmp_path, monkeypatch) -> None:
    """Its collector seeds every reset by itself."""
    lab = made("curionav/LargeLab-v0", reset_mode="continue", max_episode_steps=2)
    dataset, _ = collected(monkeypatch, tmp_path, lab, 3, seeded=False)
    assert [int(episode.infos["episode_index"][0]) for episode in dataset.iterate_episodes()] == [0, 1, 2]
    first, *_, last = dataset.iterate_episodes()
    assert not np.array_equal(first.observations["image"][0], last.observations["image"][0])
