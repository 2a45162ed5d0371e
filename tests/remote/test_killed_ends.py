"""Robots and servers that are killed, and two servers, on each kind of storage: nothing is lost, nothing is learned
from twice, and the final weights are those of a run without faults (the numbers are those of the list of faults)."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Callable

import pytest
from remote.pair import Pair

from curionav_cli.errors import RunFailed, RunFolderError
from curionav_cli.remote import outbox
from curionav_cli.remote.ledger import Ledger
from curionav_cli.remote.object_store import ObjectStore
from curionav_cli.remote.outbox import Outbox
from curionav_cli.remote.protocol import LATEST
from curionav_cli.remote.robot_sync import RobotSync
from curionav_cli.remote.weight_cache import WeightCache
from curionav_cli.storage import checkpoint


class Killed(BaseException):
    """SIGKILL in this process: no `except Exception` catches it."""


def die(*_: object) -> None:
    raise Killed


def deadly(monkeypatch: pytest.MonkeyPatch, owner: object, name: str, after: bool,
           now: Callable[[], bool]) -> list[int]:
    """While `now` is true, kill the caller of owner.name before or after the call, five times at most; the kills."""
    plain, kills = getattr(owner, name), list[int]()

    def wrapped(*words: object, **named: object) -> object:
        dies = len(kills) < 5 and now()
        result = plain(*words, **named) if after or not dies else None
        if dies:
            kills.append(1)
            raise Killed
        return result

    monkeypatch.setattr(owner, name, wrapped)
    return kills


@pytest.mark.parametrize(("owner", "name", "after"), [
    (Outbox, "add", False), (outbox, "link", True), (Outbox, "add", True), (ObjectStore, "put", False),
    (ObjectStore, "put", True),
    (RobotSync, "send", True), (Outbox, "deliver", True), (RobotSync, "fetch", True), (WeightCache, "keep", False),
    (WeightCache, "keep", True),
])
def test_a_robot_that_is_rebooted_at_any_boundary_of_a_delivery(
        pair: Pair, monkeypatch: pytest.MonkeyPatch, owner, name: str, after: bool) -> None:
    """39: from its third episode on, three times at least; it repeats that episode, or goes on after it, as the
    loop does."""
    serving: list[int] = []
    serve = pair.serve
    monkeypatch.setattr(pair, "serve", lambda: (serving.append(1), serve(), serving.clear()))
    kills = deadly(monkeypatch, owner, name, after, lambda: pair.recorded >= 3 and not serving)
    pair.dock()
    seq = 0
    while seq < 5:
        try:
            pair.record(seq)
            pair.dock()
            seq += 1
        except Killed:
            pair.boot_robot()
    assert len(kills) >= 3
    pair.undisturbed(5)


def test_a_robot_that_crashed_repeats_its_episode_with_the_weights_that_it_had(pair: Pair) -> None:
    """39: it crashed between its outbox and its checkpoint, and newer weights came meanwhile."""
    pair.server_works = False
    pair.dock()
    for seq in range(2):
        pair.record(seq)
        pair.dock()
    pair.record(2)
    pair.boot_robot()
    pair.serve()
    pair.recorded, pair.server_works = 2, True
    pair.dock()
    assert pair.robot.version == 0  # though version 2 is there
    pair.record(2)
    pair.dock()
    pair.undisturbed(3)


@pytest.mark.parametrize(("owner", "name", "after"), [
    (Ledger, "take", False), (Ledger, "take", True), (Pair, "learn", False), (checkpoint, "flush", False),
    (Pair, "learn", True), (Ledger, "publish", True), (ObjectStore, "put", False), (ObjectStore, "put", True),
])
def test_a_server_that_is_killed_at_any_boundary_ends_with_the_weights_of_a_quiet_run(
        pair: Pair, monkeypatch: pytest.MonkeyPatch, owner, name: str, after: bool) -> None:
    """33: five times, at the third episode first; each time it is started again on what is on the disk."""
    pair.server_works = False
    for seq in range(5):
        pair.record(seq)
    pair.robot.exchange(pair.recorded)
    kills = deadly(monkeypatch, owner, name, after, lambda: pair.server.done >= 2)
    for _ in range(9):
        try:
            pair.serve()
        except Killed:
            pair.ledger.close()
            pair.boot_server()
    assert len(kills) == (3 if (name, after) == ("learn", True) else 5) and pair.server.done == 5
    assert pair.learned == pair.expected(0, 1, 2, 3, 4)
    pair.dock()
    assert pair.acting == pair.learned and pair.robot.version == 5


def test_a_server_killed_between_weights_and_pointer_mends_the_pointer(pair: Pair, monkeypatch) -> None:
    pair.dock()
    for seq in range(4):
        pair.record(seq)
        pair.dock()
    take = pair.robot.take_newest
    pair.server_works = False
    pair.record(4)
    pair.robot.exchange(pair.recorded)
    with monkeypatch.context() as patched:
        patched.setattr("curionav_cli.remote.weight_publisher.written", die)  # what the pointer says
        with pytest.raises(Killed):
            pair.serve()
    take(9)
    assert pair.robot.version == 4
    pair.boot_server()
    pair.server.publish()
    take(9)
    assert pair.robot.version == 5 and pair.acting == pair.expected(*range(5))


def test_a_server_that_goes_on_from_an_older_checkpoint_does_not_set_robots_back(pair: Pair) -> None:
    """Its newest is broken: what it did after the older one it does again, to the same weights."""
    pair.dock()
    for seq in range(3):
        pair.record(seq)
        pair.dock()
    before = pair.store().get(LATEST, 999)
    shutil.rmtree(pair.folder / "server" / "checkpoint" / "000003")
    pair.ledger.close()
    pair.boot_server()
    assert pair.server.done == 2
    pair.server.publish()
    assert pair.store().get(LATEST, 999) == before
    pair.record(3)
    pair.dock()
    pair.undisturbed(4)
    assert pair.said == {"robot": [], "server": []}


def test_a_ledger_on_a_full_disk_and_a_broken_one(pair: Pair) -> None:
    pair.ledger.rows.execute("pragma max_page_count = 1")
    pair.record(0)
    with pytest.raises(OSError, match="full") as full:
        for number in range(9999):
            pair.ledger.refuse(f"{number:06d}", "x" * 200)
    assert full.value.errno == errno.ENOSPC
    pair.ledger.close()
    with pytest.raises(RunFolderError, match=r"ledger\.sqlite cannot be used .*\. Restore it from a copy\."):
        pair.ledger.names()
    (pair.folder / "server" / "ledger.sqlite").write_bytes(b"no database" * 999)
    with pytest.raises(RunFolderError, match=r"ledger\.sqlite cannot be used .*\. Restore it from a copy\."):
        pair.boot_server()


def test_two_servers_at_once_from_the_beginning_publish_the_same(pair: Pair, an_episode) -> None:
    """35: both learn from the same, in the same order, so that it does no harm; the slower one then stops."""
    second = Pair(pair.url, pair.folder / "second", an_episode)
    pair.server_works = False
    for seq in range(3):
        pair.record(seq)
    pair.robot.exchange(pair.recorded)
    pair.server.turn()
    assert pair.learned == pair.expected(0)
    second.serve()
    pair.dock()
    assert pair.acting == second.learned == pair.expected(0, 1, 2)
    with pytest.raises(RunFailed, match="weights of version 3 that are not of this training"):
        pair.serve()
    second.ledger.close()
