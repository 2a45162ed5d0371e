"""A disk that is full at any write, and one that cannot be written: one line, nothing lost, and the run goes on."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from forked import Forks
from leftovers import leftovers
from tiny import LEARNER

from curionav_cli.storage.run_folder import RunFolder

pytestmark = pytest.mark.faults
GROUPS = 10


@pytest.fixture
def disk(tmp_path: Path) -> Iterator[Path]:
    """A disk in memory, of a size that `resized` sets."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if os.geteuid() != 0:
        pytest.skip("needs root, to mount small disks")
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64m", "tmpfs", folder], capture_output=True).returncode:
        pytest.skip("this machine mounts no disks in memory")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", folder], check=True)


def resized(disk: Path, options: str) -> None:
    subprocess.run(["mount", "-o", f"remount,{options}", disk], check=True)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> tuple[dict[str, Any], int]:
    run = tmp_path_factory.mktemp("undisturbed") / "run"
    assert forks("explore", *LEARNER, f"hydra.run.dir={run}").code == 0
    return leftovers(run), sum(path.lstat().st_blocks * 512 for path in run.rglob("*"))


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> int:
    """How many places of the program write to the disk while it explores."""
    run = tmp_path_factory.mktemp("counted") / "run"
    assert forks("explore", *LEARNER, f"hydra.run.dir={run}", phase="writing").code == 0
    return forks.events["writing"]


@pytest.mark.timeout(1200)
@pytest.mark.parametrize("group", range(GROUPS))
def test_a_disk_that_is_full_at_one_write(
        tmp_path: Path, forks: Forks, undisturbed: tuple[dict[str, Any], int], places: int, group: int) -> None:
    """At each of the places, once: the run ends there in one line, and goes on to the same bytes.

    A folder that is there need not be made: where that fails, nothing does.
    """
    assert places > 40
    for place in range(group + 1, places + 1, GROUPS):
        run = tmp_path / str(place)
        full = forks("explore", *LEARNER, f"hydra.run.dir={run}", phase="writing", at=place)
        assert "Traceback" not in full.error, (place, full.error)
        assert full.code == 0 or "disk is full" in full.error or "No space left" in full.error, (place, full.error)
        again = forks("resume", str(run))
        assert again.code == 0, (place, again.error)
        ours = leftovers(run)
        assert [name for name in ours.keys() | undisturbed[0].keys()
                if ours.get(name) != undisturbed[0].get(name)] == [], place
        assert not list(run.rglob("*.part"))
        shutil.rmtree(run)


@pytest.mark.parametrize("share", [number / 20 for number in range(1, 20)])
def test_a_disk_that_is_full(disk: Path, forks: Forks, undisturbed: tuple[dict[str, Any], int], share: float) -> None:
    whole, size = undisturbed
    resized(disk, f"size={int(share * size) // 4096 * 4096}")
    run = disk / "run"
    full = forks("explore", *LEARNER, f"hydra.run.dir={run}")
    if full.code == 0:  # two checkpoints of three are gone by the end: it may have fitted
        return
    assert full.code == 1 and "Traceback" not in full.error, full.error
    assert "disk is full" in full.error or "No space left" in full.error
    resized(disk, "size=64m")
    again = forks("resume", str(run)) if (run / ".hydra" / "hydra.yaml").exists() else \
        forks("explore", *LEARNER, f"hydra.run.dir={run}")
    assert again.code == 0, again.error
    ours = leftovers(run)
    assert [name for name in whole if ours.get(name) != whole[name]] == []


def test_a_folder_that_cannot_be_written(disk: Path, forks: Forks, undisturbed: tuple[dict[str, Any], int]) -> None:
    words = (*LEARNER[:-1], "loop.episodes=2", LEARNER[-1])
    run = RunFolder(disk / "run")
    assert forks("explore", *words, f"hydra.run.dir={run.path}").code == 0
    resized(disk, "ro")
    for said in (forks("resume", str(run.path), "loop.episodes=4"),
                 forks("explore", *LEARNER, f"hydra.run.dir={disk / 'other'}"),
                 forks("explore", *words, "loop.episodes=4", f"hydra.run.dir={run.path}"),
                 forks("coverage", str(run.path), f"out={disk / 'figures'}"), forks("init", str(disk / "mine"))):
        assert said.code in (1, 2) and "Read-only file system" in said.error, said.error
        assert "Traceback" not in said.error and len(said.error.strip().splitlines()) <= 2
    resized(disk, "rw")
    assert forks("resume", str(run.path), "loop.episodes=4").code == 0
    assert leftovers(run.path).keys() == undisturbed[0].keys()
    shutil.rmtree(run.path)
