"""curionav sheet: a picture of any world, with the same settings as a run."""

from __future__ import annotations

from pathlib import Path

import cv2
import yaml
from entry import Cli


def test_a_sheet_is_drawn_and_counts_cells(cli: Cli, tmp_path: Path) -> None:
    answer = cli("sheet", "env=small_room", "hydra.run.dir=sheet")
    assert answer.code == 0, answer.error
    picture = cv2.imread(str(tmp_path / "sheet" / "sheet.png"))
    assert picture.shape[0] > 300 and picture.shape[1] > 600 and picture.std() > 20
    assert "449 visitable cells of 10 cm, 4.49 m2" in answer.out


def test_a_world_that_cannot_be_is_answered_before_anything_is_written(cli: Cli, tmp_path: Path) -> None:
    answer = cli("sheet", "env.start=[1.9,0.3,0]", "hydra.run.dir=sheet")
    assert answer.code == 2 and "inside a wall or furniture" in answer.error
    assert not (tmp_path / "sheet").exists()


def test_the_command_of_each_job_is_recorded(cli: Cli, tmp_path: Path) -> None:
    words = ("loop.steps=5", "loop.episodes=1", "agent=random")
    assert cli("explore", "-m", *words, "seed=3,4", "hydra.sweep.dir=sweep").code == 0
    commands = [yaml.safe_load(path.read_text())["command"] for path in sorted((tmp_path / "sweep").glob("*/run.json"))]
    assert commands == [f"curionav explore {' '.join(words)} seed={seed}" for seed in (3, 4)]
