"""A disk that is full under the storage, the server or the robot (34): one line, nothing lost, and the same weights."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import test_disk
from entry import Answer
from forked import Forks
from test_disk import resized
from tiny import at_storage

from curionav_cli.storage import checkpoint

pytest.importorskip("obstore")
pytestmark = [pytest.mark.faults, pytest.mark.skipif(os.geteuid() != 0, reason="needs root, to mount small disks")]
disk = test_disk.disk
PAGE = 4096


class Pair:
    """A robot that does not wait, and a server that ends when all is learned; each called again and again."""

    def __init__(self, forks: Forks, storage: Path, robot: Path, server: Path):
        self.forks, self.url, self.folders = forks, storage.as_uri(), (storage, robot, server)

    def robot(self) -> Answer:
        return self.forks("explore", *at_storage(self.url, self.folders[1], "learner=remote", "remote.wait=0",
                                                 "remote.offline=0"))

    def server(self) -> Answer:
        return self.forks("train", *at_storage(self.url, self.folders[2]))

    def weights(self) -> dict[str, bytes]:
        newest = checkpoint.finished(self.folders[2] / "checkpoint")[-1]
        return {path.name: path.read_bytes() for path in newest.iterdir() if path.suffix == ".safetensors"}

    def end(self) -> dict[str, bytes]:
        """With room enough; nothing was lost or learned from twice."""
        for answer in (self.robot(), self.server()):
            assert answer.code == 0, answer.error
        assert len(list((self.folders[2] / "episodes").iterdir())) == 4
        assert not list((self.folders[1] / "outbox").glob("*.npz"))
        return self.weights()


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> tuple[dict[str, bytes], list[int]]:
    """The weights without a fault, and the bytes of storage, robot and server."""
    folder = tmp_path_factory.mktemp("quiet")
    pair = Pair(forks, folder / "storage", folder / "robot", folder / "server")
    return pair.end(), [sum(path.lstat().st_blocks * 512 for path in one.rglob("*")) for one in pair.folders]


def plain(answer: Answer) -> bool:
    """One line of why, and where the traceback is; whether it was stopped at all."""
    assert answer.code in (0, 1) and "Traceback" not in answer.error and len(answer.error.splitlines()) <= 2
    assert not answer.code or "full" in answer.error or "be delivered" in answer.error or "No space" in answer.error
    return answer.code == 1


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("whose", ["storage", "robot", "server"])
def test_a_full_disk_changes_no_weights(
        disk: Path, tmp_path: Path, forks: Forks, quiet: tuple[dict[str, bytes], list[int]], whose: str,
        share: float) -> None:
    weights, sizes = quiet
    names = ("storage", "robot", "server")
    pair = Pair(forks, *((disk if name == whose else tmp_path) / name for name in names))
    resized(disk, f"size={int(share * sizes[names.index(whose)]) // PAGE * PAGE}")
    stopped = plain(pair.robot())
    if whose != "robot":  # later episodes would be recorded with weights learned from earlier ones
        stopped |= plain(pair.server())
    assert stopped
    resized(disk, "size=64m")
    assert pair.end() == weights


def test_a_storage_that_is_full_when_weights_are_to_be_published(
        disk: Path, tmp_path: Path, forks: Forks, quiet: tuple[dict[str, bytes], list[int]]) -> None:
    pair = Pair(forks, disk / "storage", tmp_path / "robot", tmp_path / "server")
    assert pair.robot().code == 0
    used = os.statvfs(disk)
    resized(disk, f"size={(used.f_blocks - used.f_bfree + 1) * used.f_frsize}")
    full = pair.server()
    assert full.code == 1 and "The storage is not reachable (it is full). What was learned is saved" in full.error
    resized(disk, "size=64m")
    assert pair.end() == quiet[0]
