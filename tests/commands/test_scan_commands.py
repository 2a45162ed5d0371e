"""env=scan and curionav export through the entry point: sheet, explore, resume, robots, wrong words."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from entry import Cli

from curionav_cli.config.sources import conf_dir
from curionav_cli.records import FloorPlan
from curionav_cli.storage.run_folder import RunFolder

pytest.importorskip("trimesh", reason="the extra scan is not installed")
pytest.importorskip("embreex", reason="the extra scan is not installed")
pytestmark = pytest.mark.usefixtures("blank_figures")
SCAN = ("env=scan", "env.mesh=room.glb", "env.cell=0.1", "env.radius=0.18")
SHORT = ("loop.steps=20", "loop.iterations=0")


@pytest.fixture(autouse=True)
def kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "kept"))


@pytest.fixture
def a_mesh(cli: Cli, tmp_path: Path) -> Path:
    answer = cli("export", "env=small_room", "--to", "glb", "out=room.glb")
    assert answer.code == 0, answer.error
    assert "258 triangles" in answer.out and "env=scan env.mesh=room.glb" in answer.out
    return tmp_path / "room.glb"


def test_a_sheet_counts_the_cells_and_names_what_was_found(cli: Cli, a_mesh: Path, tmp_path: Path) -> None:
    answer = cli("sheet", *SCAN, "env.counted=450", "hydra.run.dir=sheet")
    assert answer.code == 0, answer.error
    assert "449 visitable cells of 10 cm, 4.49 m2" in answer.out and "258 triangles" in answer.out
    assert "others counted 450 visitable cells there: ours are -0.2%" in answer.out
    assert cv2.imread(str(tmp_path / "sheet" / "sheet.png")).std() > 20


def test_a_run_is_made_resumed_and_keeps_the_picture(cli: Cli, a_mesh: Path, tmp_path: Path) -> None:
    answer = cli("explore", *SCAN, *SHORT, "agent=bounce", "loop.episodes=2", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    moved = a_mesh.rename(tmp_path / "elsewhere.glb")
    answer = cli("resume", "run", "loop.episodes=3", f"env.mesh={moved}")
    assert answer.code == 0, answer.error
    run = RunFolder(tmp_path / "run")
    assert run.status["episode"] == 3
    plan = FloorPlan.load(run.path / "plan.npz")
    assert plan.picture is not None and plan.picture.std() > 10 and plan.visitable.sum() == 449


@pytest.mark.parametrize("words", [("robot=turtlebot2i", "agent=bounce"), ("agent=mapper",), ("agent=frontier",),
                                   ("agent=cbet", "loop.steps=16", "agent.unroll=16")])
def test_robots_and_explorers_work_in_a_scan(cli: Cli, a_mesh: Path, tmp_path: Path, words: tuple[str, ...]) -> None:
    answer = cli("explore", *SCAN, *SHORT, *words, "loop.episodes=2", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    with np.load(tmp_path / "run" / "episodes" / "000001.npz") as episode:
        assert episode["image"].std() > 10


def test_what_cannot_be_exported_is_answered(cli: Cli, a_mesh: Path) -> None:
    for words, about in ((("env=small_room", "out=room.glb"), "exists already"),
                         (("env=small_room", "out=room.obj"), "must end in .glb"),
                         (("env=small_room", "to=obj"), "is not one of mcap, summary, glb"),
                         (("env=small_room", "episode=x"), "is not the number of an episode"),
                         ((*SCAN, "out=b.glb"), "is a mesh already"), (("env=nowhere",), "nowhere")):
        answer = cli("export", "to=glb", *words)
        assert answer.code == 2 and about in answer.error, answer.error


def test_an_episode_is_exported_as_it_stands(cli: Cli, tmp_path: Path) -> None:
    for episode in (0, 5):
        assert cli("export", "env=large_lab", "to=glb", f"episode={episode}", f"out={episode}.glb").code == 0
    assert (tmp_path / "0.glb").read_bytes() != (tmp_path / "5.glb").read_bytes()


def test_replica_is_to_be_brought(cli: Cli, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("REPLICA_ROOT", raising=False)
    names = sorted(path.stem for path in (conf_dir() / "env").glob("replica_*.yaml"))
    assert names == [f"replica_apartment_{number}" for number in range(3)]
    for name in names:
        answer = cli("sheet", f"env={name}")
        assert answer.code == 2 and "export REPLICA_ROOT=FOLDER" in answer.error
    monkeypatch.setenv("REPLICA_ROOT", str(tmp_path))
    answer = cli("sheet", f"env={names[0]}")
    assert answer.code == 2 and f"There is no mesh {tmp_path}/apartment_0/mesh.ply" in answer.error
