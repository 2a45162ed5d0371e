"""curionav map: what the mapping explorer or the docking robot mapped, as a ROS map that opens as the same cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from entry import Cli

from curionav_cli.storage.robot_map import explored_part, newest_map
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, read_map

SHORT = ("explore", "env=small_room", "loop.steps=40")


@pytest.mark.parametrize("words", [("agent=mapper", "loop.episodes=1"),
                                   ("agent=bounce", "robot=turtlebot2i", "loop.episodes=1")])
def test_a_map_opens_as_the_cells_that_were_mapped(cli: Cli, tmp_path: Path, words: tuple[str, ...]) -> None:
    assert cli(*SHORT, *words, "hydra.run.dir=run").code == 0
    answer = cli("map", "run", "--out", "maps")
    assert answer.code == 0 and "free" in answer.out, answer.error
    occupancy = newest_map(RunFolder(tmp_path / "run"))
    cells, corner = explored_part(occupancy, tmp_path / "run")
    opened = read_map(tmp_path / "maps" / "map.yaml")
    np.testing.assert_array_equal(opened.cells, cells)
    assert opened.resolution == occupancy.cell and opened.origin[:2] == corner
    assert (cells == FREE).sum() > 50 and (cells == OCCUPIED).sum() > 5
    sheet = cli("sheet", "env=map", "env.map=maps/map.yaml", "env.radius=0.1", "hydra.run.dir=sheet")
    assert sheet.code == 0 and "visitable cells" in sheet.out


def test_a_docking_trial_maps_by_its_camera(cli: Cli, tmp_path: Path) -> None:
    answer = cli("dock", "env=small_room", "agent=mapper", "dock.requests=1", "loop.steps=40", "hydra.run.dir=run")
    assert answer.code == 0 and cli("map", "run").code == 0, answer.error
    assert (read_map(tmp_path / "run" / "map.yaml").cells == FREE).sum() > 100


def test_what_has_no_map_is_answered_in_a_line(cli: Cli, tmp_path: Path) -> None:
    assert cli(*SHORT, "agent=random", "loop.episodes=1", "hydra.run.dir=run").code == 0
    (tmp_path / "begun").mkdir()
    (tmp_path / "begun" / "config.yaml").write_text("seed: 0\n")
    for words, said in (((), "Name the folder of one run"), (("nowhere",), "There is no folder"),
                        (("run", "run"), "Name the folder of one run"), (("begun",), "no episode is finished"),
                        (("run",), "agent=random makes none"), (("run", "in=maps"), "map has no setting in")):
        answer = cli("map", *words)
        assert answer.code == 2 and said in answer.error and answer.error.count("\n") == 1, answer.error


def test_nothing_is_overwritten(cli: Cli, tmp_path: Path) -> None:
    assert cli(*SHORT, "agent=mapper", "loop.episodes=1", "hydra.run.dir=run").code == 0
    (tmp_path / "run" / "map.pgm").write_bytes(b"mine")
    answer = cli("map", "run")
    assert answer.code == 2 and "map.pgm exists already" in answer.error
    assert (tmp_path / "run" / "map.pgm").read_bytes() == b"mine" and not (tmp_path / "run" / "map.yaml").exists()
    assert cli("map", "run", "out=elsewhere").code == 0
