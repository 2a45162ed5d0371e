"""Faults on each kind of storage: nothing is lost, nothing is learned from twice, and the final weights are those of
a run without faults (the numbers are those of the list of faults in the design)."""

from __future__ import annotations

import itertools
import os
from pathlib import Path
from types import SimpleNamespace

import pytest
from remote.pair import Pair
from remote.storm import KINDS, Storm
from servers import KEYS, Place, free_port, process, s3_words

from curionav_cli.errors import RunFailed
from curionav_cli.remote import outbox
from curionav_cli.remote.protocol import LATEST, Pointer, parsed, sha256, written


@pytest.mark.parametrize("part", [".npz", ".json"])
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_becomes_of_an_upload(pair: Pair, monkeypatch: pytest.MonkeyPatch, kind: str, part: str) -> None:
    """31, 32, 34: the episode or its marker, truncated, flipped, empty, broken off, lost, refused, without place or
    twice; and the next try once more."""
    storm = Storm(monkeypatch, part)
    pair.dock()
    for seq in range(4):
        storm.part, storm.faults = f"episodes/{seq:06d}", []
        pair.record(seq)
        if seq in (1, 2):
            storm.part, storm.faults = part, [kind] * seq
        pair.dock()
        storm.faults.clear()
    assert len(storm.struck) == (2 if kind == "twice" and part == ".npz" else 3)  # which is no fault to be mended
    pair.undisturbed(4)


@pytest.mark.parametrize("part", ["safetensors", "LATEST"])
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_becomes_of_weights(pair: Pair, monkeypatch: pytest.MonkeyPatch, kind: str, part: str) -> None:
    """37: those of our own server, damaged as they are written."""
    storm = Storm(monkeypatch, part)
    pair.dock()
    for seq in range(4):
        pair.record(seq)
        storm.faults = [kind] * (seq == 2)
        pair.dock()
    pair.serve()
    assert len(storm.struck) == 1
    pair.undisturbed(4)


HARM = {"truncated": lambda raw: raw[:-9], "nan": lambda raw: b"nan" + raw[3:], "foreign": lambda raw: raw[::-1],
        "nothing": lambda raw: b""}


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("harm", HARM)
def test_weights_that_cannot_be_used(pair: Pair, harm: str, named: bool) -> None:
    """37: they replace the server's, under its pointer or one of their own: the robot keeps the old ones until usable
    ones come."""
    pair.dock()
    pair.record(0)
    pair.dock()
    pair.server_works = False
    pair.record(1)
    pair.robot.exchange(pair.recorded)
    pair.serve()
    whole = pair.store().get(LATEST, 999) or b""
    pointer, raw = parsed(Pointer, whole), HARM[harm](pair.learned)
    if named:
        pointer = Pointer(**{**vars(pointer), "sha256": sha256(raw), "size": len(raw)})
        pair.store().put(LATEST, written(pointer))
    pair.store().put(pointer.key, raw)
    pair.dock()
    taken = named and harm == "foreign"  # with a pointer that fits them: no check can find these
    assert pair.robot.version == 1 + taken and (pair.acting == pair.expected(0)) is not taken
    assert taken or "new weights cannot be used" in pair.said["robot"][-1]
    pair.store().put(LATEST, whole)
    if taken:
        return
    pair.server_works = True
    pair.record(2)
    pair.dock()
    pair.undisturbed(3)


def test_a_full_outbox_stops_the_robot_and_loses_nothing(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    """36"""
    storm = Storm(monkeypatch)
    storm.faults = ["refuse"] * 10**4
    pair.server_works = False
    with pytest.raises(RunFailed, match=r"The outbox is full: 6 episodes wait in .*\(remote\.outbox=6\), and the st"):
        for seq in range(9):
            pair.record(seq)
            pair.dock()
    assert len(pair.outbox.waiting()) == 6
    storm.faults.clear()
    pair.boot_robot()
    pair.server_works = True
    pair.dock()
    pair.undisturbed(6)


def test_a_place_that_is_gone_for_a_while(pair: Pair, place: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    """34: its folder is not mounted, its server does not listen; two episodes are recorded meanwhile."""
    pair.record(0)
    pair.dock()
    root, endpoint = pair.store().root, os.environ.get("AWS_ENDPOINT_URL", "")
    if root:
        root.rename(root.with_name("away"))
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{free_port()}")
    pair.robot.store = pair.server.inbox.store = pair.server.publisher.store = pair.store()
    for seq in (1, 2):
        pair.record(seq)
        pair.dock()
    why = f"there is no folder {root}" if root else "the connection was refused"
    assert [line.partition(": goes")[0] for line in pair.said["robot"]] == [f"the storage is not reachable ({why})"] * 2
    assert set(pair.said["server"]) == {why}
    if root:
        root.with_name("away").rename(root)
    monkeypatch.setenv("AWS_ENDPOINT_URL", endpoint)
    pair.robot.store = pair.server.inbox.store = pair.server.publisher.store = pair.store()
    pair.record(3)
    pair.dock()
    pair.undisturbed(4)


def test_a_real_server_that_is_killed_and_started_again(
        no_credentials: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, an_episode) -> None:
    """34: SIGKILL of rclone, twice, while robot and server go on."""
    (tmp_path / "s3" / "bucket").mkdir(parents=True)
    port = free_port()
    words = s3_words(tmp_path / "s3", port)
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
    for name, value in KEYS.items():
        monkeypatch.setenv(name, value)
    with process(*words, port=port):
        pair = Pair("s3://bucket/x", tmp_path, an_episode)
        pair.record(0)
        pair.dock()
    for seq in (1, 2):
        pair.record(seq)
        pair.dock()
        assert "(the connection was refused): goes on with weights 1" in pair.said["robot"][-1]
    with process(*words, port=port):
        pair.record(3)
        pair.dock()
    pair.record(4)
    pair.dock()
    with process(*words, port=port):
        pair.dock()
        pair.undisturbed(5)
    pair.ledger.close()


def test_both_clocks_a_day_off(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    """38: the robot's a day late and falling back, the server's a day early: nothing is named or ordered by them."""
    walls = itertools.cycle([1.8e9 - 86400, 1.8e9 + 86400, 0.0])
    monkeypatch.setattr(outbox, "time", SimpleNamespace(time=lambda: next(walls), monotonic=lambda: 0.0))
    pair.dock()
    for seq in range(4):
        pair.record(seq)
        pair.dock()
    pair.undisturbed(4)
