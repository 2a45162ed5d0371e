"""curionav sheet: a picture of any world, with the same settings as a run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from entry import Cli
from matplotlib.colors import to_rgb

from curionav_cli.results.floor_plans import KINDS, REACHED, SOLID, UNKNOWN
from curionav_cli.world.contact_sheet import MIST

pytestmark = pytest.mark.usefixtures("painted")


def test_a_sheet_is_drawn_and_counts_cells(cli: Cli, tmp_path: Path) -> None:
    answer = cli("sheet", "env=small_room", "hydra.run.dir=sheet")
    assert answer.code == 0, answer.error
    picture = cv2.imread(str(tmp_path / "sheet" / "sheet.png"))
    assert picture.shape[0] > 300 and picture.shape[1] > 600 and picture.std() > 20
    assert "449 visitable cells of 10 cm, 4.49 m2" in answer.out


def test_a_map_is_drawn_in_its_own_axes_with_everything_that_helps_to_read_it(cli: Cli, tmp_path: Path) -> None:
    pixels = np.full((40, 60), 205, np.uint8)
    pixels[5:35, 5:55], pixels[6:34, 6:54] = 0, 254
    cv2.imwrite(str(tmp_path / "office.png"), pixels)
    (tmp_path / "office.yaml").write_text("image: office.png\nresolution: 0.05\norigin: [2.0, 3.0, 0.5]\nnegate: 0\n"
                                          "occupied_thresh: 0.65\nfree_thresh: 0.19\n")
    answer = cli("sheet", "env=map", "env.map=office.yaml", "hydra.run.dir=sheet")
    assert answer.code == 0 and f"{Path('sheet') / 'plan.png'} and sheet.png" in answer.out
    written = {path.name for path in (tmp_path / "sheet").glob("*.p*")}
    assert written == {"plan.png", "plan.pdf", "sheet.png", "above.png"}
    drawn = cv2.imread(str(tmp_path / "sheet" / "plan.png"))[..., ::-1].reshape(-1, 3)
    for number in (SOLID, UNKNOWN, REACHED):
        assert (np.abs(drawn - 255 * np.array(to_rgb(KINDS[number].color))).max(1) < 2).sum() > 5000
    above = cv2.imread(str(tmp_path / "sheet" / "above.png"))[..., ::-1]
    assert (above == MIST).all(-1).sum() > 500, "unknown is no wall there either"


def test_a_backend_that_a_notebook_left_behind_does_not_matter(tmp_path: Path) -> None:
    words = ("explore", "agent=random", "loop.steps=5", "loop.episodes=1", "hydra.run.dir=run")
    command = [sys.executable, "-m", "curionav_cli", *words]
    environment = {**os.environ, "MPLBACKEND": "module://not_installed_here.backend_inline"}
    ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert (tmp_path / "run" / "figures" / "heatmap.png").stat().st_size > 5000


def test_a_world_that_cannot_be_is_answered_before_anything_is_written(cli: Cli, tmp_path: Path) -> None:
    answer = cli("sheet", "env.start=[1.9,0.3,0]", "hydra.run.dir=sheet")
    assert answer.code == 2 and "inside a wall or furniture" in answer.error
    assert not (tmp_path / "sheet").exists()


def test_the_command_of_each_job_is_recorded(cli: Cli, tmp_path: Path) -> None:
    words = ("loop.steps=5", "loop.episodes=1", "agent=random")
    assert cli("explore", "-m", *words, "seed=3,4", "hydra.sweep.dir=sweep").code == 0
    commands = [yaml.safe_load(path.read_text())["command"] for path in sorted((tmp_path / "sweep").glob("*/run.json"))]
    assert commands == [f"curionav explore {' '.join(words)} seed={seed}" for seed in (3, 4)]
