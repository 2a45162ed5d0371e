"""The functions of `import curionav_cli`, and the blocks of docs/python.md."""

from __future__ import annotations

import re
import subprocess
import sys
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

import curionav_cli as cn
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import ConfigError, RunFolderError, SoundnessWarning
from curionav_cli.storage.run_folder import RunFolder

PAGE = Path(__file__).parents[1] / "docs" / "python.md"
LENGTHS = (30, 12)


@pytest.fixture
def run(tmp_path: Path, an_episode, a_plan) -> Path:
    """A run of two episodes whose actions are held for two steps."""
    folder = RunFolder(tmp_path / "run")
    folder.create(settings_yaml(cn.compose(["env=small_room"])), {}, {}, a_plan())
    for index, steps in enumerate(LENGTHS):
        episode = an_episode(steps=steps, seed=index)
        episode.action[1::2] = episode.action[::2]
        folder.save_episode(index, episode)
        folder.append_metrics({"episode": index, "steps": steps})
    folder.set_status(state="done", episode=2)
    return folder.path


def test_an_import_stays_quick_and_says_what_there_is() -> None:
    heavy = "{'numpy', 'torch', 'hydra', 'gymnasium', 'matplotlib', 'curionav_cli.api'}"
    program = f"import sys, curionav_cli as cn; print(sorted({heavy} & sys.modules.keys()), 'load_run' in dir(cn))"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout == \
        "[] True\n"
    with pytest.raises(AttributeError, match="module 'curionav_cli' has no attribute 'load_ruin'"):
        _ = cn.load_ruin
    assert {name: callable(getattr(cn, name)) for name in cn.__all__} == dict.fromkeys(cn.__all__, True)


def test_every_block_of_the_page_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    names: dict[str, object] = {}
    for number, block in enumerate(blocks):
        exec(compile(block, f"{PAGE.name}, block {number}", "exec"), names)
    said = capsys.readouterr().out.splitlines()
    assert "<run outputs/first: small_room, bounce, seed 0, done>" in said
    assert "There is no small_rom in the group env. Did you mean small_room?" in said
    assert said[-2] == "There is no folder nowhere."
    assert said[-1] == ("length=500 does not fit into the longest episode of outputs/first, which holds 101 "
                        "observations. Set length=101 or less.")


def test_a_run_is_read_as_arrays_and_rows(run: Path) -> None:
    loaded = cn.load_run(run)
    assert [len(episode) for episode in loaded.episodes] == list(LENGTHS) and loaded.state == "done"
    assert len(loaded.episodes[:1]) == 1 and loaded.episodes[-1].image.shape == (13, 64, 64, 3)
    assert loaded.coverage.steps == sum(LENGTHS) and loaded.coverage.visits.sum() == sum(LENGTHS) + 2
    assert loaded.metrics == [{"episode": 0, "steps": 30}, {"episode": 1, "steps": 12}]
    assert loaded.settings["env"]["name"] == "small_room" and loaded.plan.name == "a_plan"
    assert [each.path for each in cn.load_runs(run.parent)] == [each.path for each in cn.load_runs(run)] == [run]


def test_a_broken_end_is_named_and_the_rest_is_given(run: Path) -> None:
    broken = run / "episodes" / "000001.npz"
    broken.write_bytes(broken.read_bytes()[:500])
    with pytest.warns(SoundnessWarning, match=r"000001.npz is not whole.*Shown up to there, 30 steps"):
        assert len(cn.load_run(run).episodes) == 1


def test_batches_are_windows_of_the_episodes(run: Path) -> None:
    first = list(islice(cn.batches(run, 4, 10, seed=3), 2))
    again = list(islice(cn.batches(run, 4, 10, seed=3, memory=0), 2))  # from the scratch file
    episodes = cn.load_run(run).episodes
    for batch, same in zip(first, again, strict=True):
        assert {key: (value.shape, value.dtype.name) for key, value in batch.items()} == {
            "image": ((4, 10, 64, 64, 3), "uint8"), "action": ((4, 10), "int64"), "pose": ((4, 10, 3), "float64"),
            "is_start": ((4,), "bool")}
        assert all(np.array_equal(batch[key], same[key]) for key in batch)
        for image, action in zip(batch["image"], batch["action"]):
            assert action[0] == -1
            assert any(np.array_equal(image, each.image[at:at + 10])
                       and np.array_equal(action[1:], each.action[at:at + 9])
                       for each in episodes for at in range(len(each) - 8))
    held = next(cn.batches(run, 2, 16, action_repeat=2))
    assert np.array_equal(held["image"][0], episodes[0].image[::2])


@pytest.mark.parametrize("arguments, said", [
    ({"length": 32}, "length=32 does not fit into the longest episode of .*, which holds 31 observations"),
    ({"length": 1}, "length must be a number from 2 to 1e[+]06, not 1."),
    ({"batch_size": 2.5}, "batch_size must be a whole number, not 2.5."),
    ({"seed": -1}, "seed must be a number from 0"),
])
def test_wrong_numbers_are_answered_at_once(run: Path, arguments: dict[str, float], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        cn.batches(run, **arguments)


def test_mistakes_are_errors_of_ours(run: Path, tmp_path: Path, an_episode) -> None:
    with pytest.raises(ConfigError, match=r"compose takes a list of settings: compose\(\['env=small_room'\]\)"):
        cn.compose("env=small_room")
    with pytest.raises(RunFolderError, match="holds no run"):
        cn.load_run(tmp_path)
    with pytest.raises(RunFolderError, match="holds no episodes"):
        cn.batches(tmp_path / "run" / "figures")
    with pytest.raises(ConfigError, match=r"data=... is for curionav train"):
        cn.explore(cn.compose([f"data={run}"]), tmp_path / "new")
    with pytest.raises(RunFolderError, match="not held for 3 steps"):
        cn.batches(run, action_repeat=3)
    assert not (tmp_path / "new").exists()


def test_a_training_has_metrics_and_says_that_it_has_no_episodes(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "trained")
    folder.create(settings_yaml(cn.compose(["env=small_room"])), {}, {}, plan=None)
    folder.append_metrics({"iterations": 100})
    trained = cn.load_run(folder.path)
    assert trained.metrics == [{"iterations": 100}]
    with pytest.raises(RunFolderError, match="offline training runs no episodes"):
        _ = trained.episodes
