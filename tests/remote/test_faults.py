"""Faults of networks and servers, injected: nothing is lost, nothing is learned from twice, and the final weights are
those of a run without faults (the numbers are those of the list of faults in the design)."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from bad_server import BadServer, Fault
from remote.pair import Pair
from servers import Place, a_place, free_port

from curionav_cli.errors import Unreachable
from curionav_cli.remote.object_store import ObjectStore, TooLarge
from curionav_cli.remote.outbox import Outbox
from curionav_cli.remote.protocol import MARKED, Pointer


@pytest.fixture
def place(tmp_path: Path, no_credentials: None, monkeypatch: pytest.MonkeyPatch,
          request: pytest.FixtureRequest) -> Place:
    """The bad server."""
    return a_place("bad", request, tmp_path, monkeypatch)


def four(pair: Pair) -> None:
    """Four episodes, with a visit to the dock after each."""
    pair.dock()
    for seq in range(4):
        pair.record(seq)
        pair.dock()


@pytest.mark.parametrize("part", [".npz", ".json"])
@pytest.mark.parametrize("kind", ["truncate", "flip", "empty", "drop", "lose", "status"])
def test_a_spoilt_upload_is_sent_again(pair: Pair, bad: BadServer, kind: str, part: str) -> None:
    """31: truncated, flipped, empty, broken off, acknowledged and lost, refused: the episode or its marker."""
    bad.faults.append(Fault(kind, part="episodes/000002-", times=0))
    fault = bad.faults[0]
    pair.dock()
    for seq in range(4):
        if seq == 2:
            fault.part, fault.times = "episodes/000002-", 1 if part == ".npz" else 0
            if part == ".json":
                bad.faults.append(Fault(kind, part=".json", times=1))
        pair.record(seq)
        pair.dock()
    assert pair.acting == pair.learned == pair.expected(0, 1, 2, 3)
    assert pair.server.done == 4 and not pair.outbox.waiting() and pair.ledger.refused() == {}
    assert not list((pair.folder / "server" / "quarantine").glob("*"))
    assert pair.store().names("refused", MARKED) == []


def test_a_flipped_bit_waits_in_quarantine_for_the_next_try(pair: Pair, bad: BadServer) -> None:
    """Later episodes do not overtake it, so that the weights stay those of a run without faults."""
    bad.faults.append(Fault("flip", part="000000-", times=1))
    pair.server_works = False
    for seq in range(3):
        pair.record(seq)
    pair.robot.exchange(pair.recorded)
    pair.serve()
    [name] = pair.ledger.refused()
    broken = (pair.folder / "server" / "quarantine" / f"{name}.npz").read_bytes()
    good = pair.path(0).read_bytes()
    assert len(broken) == len(good) and sum(a != b for a, b in zip(broken, good, strict=True)) == 1
    assert pair.server.done == 0
    assert "are not the" in pair.said["server"][0]
    assert pair.said["server"][1].startswith("episode 1 is here and 0 is not")
    pair.server_works = True
    pair.dock()
    assert pair.learned == pair.acting == pair.expected(0, 1, 2)
    assert f"episode {name} came whole now" in pair.said["server"]


def test_a_robot_that_reboots_in_the_middle_of_an_upload(pair: Pair, bad: BadServer) -> None:
    """39: half of the episode is there, the marker is not."""
    bad.faults.append(Fault("drop", part="000000-", times=2))  # obstore tries twice
    pair.record(0)
    with pytest.raises(Unreachable, match="the connection broke off"):
        pair.robot.exchange(pair.recorded)
    assert [len(raw) < pair.path(0).stat().st_size for raw in bad.objects.values()] == [True]
    pair.boot_robot()
    pair.dock()
    assert pair.acting == pair.expected(0)


def test_spoilt_weights_are_written_again_and_never_acted_with(pair: Pair, bad: BadServer) -> None:
    bad.faults += [Fault("truncate", part="safetensors", times=1), Fault("flip", part="LATEST", times=1)]
    four(pair)
    assert pair.acting == pair.expected(0, 1, 2, 3)
    assert any("comes back as something else than was put there" in line for line in pair.said["server"])


def test_weights_that_are_spoilt_on_the_way_are_not_acted_with(pair: Pair, bad: BadServer) -> None:
    four(pair)
    bad.faults.append(Fault("truncate", part="never", times=1))
    pair.server_works = False
    pair.record(4)
    pair.robot.exchange(pair.recorded)
    pair.serve()
    key = next(key for key in bad.objects if "/weights/000005" in key)
    bad.objects[key] = bad.objects[key][:-1] + b"\0"
    pair.dock()
    assert "they are not what was announced" in pair.said["robot"][-1]
    assert pair.acting == pair.expected(0, 1, 2, 3) and pair.robot.version == 4


FAULTS = [
    (Fault("status", "GET", times=99, status=503, code="SlowDown"), "it is not able to answer now"),
    (Fault("status", times=99, status=507, code="InsufficientStorage"), "it is full"),
    (Fault("status", times=99, status=403, code="AccessDenied"), "it refuses our key"),
    (Fault("status", "GET", times=99, status=403, code="SignatureDoesNotMatch"), "it refuses our key"),
    (Fault("status", "GET", times=99, status=403, code="RequestTimeTooSkewed"),
     "it says that this machine's clock is wrong: set it"),
    (Fault("status", "GET", times=99, status=404, code="NoSuchBucket"), "it has no such bucket"),
    (Fault("status", "GET", times=99, status=418, code="Teapot"), "it answers Teapot"),
]


@pytest.mark.parametrize(("fault", "reason"), FAULTS, ids=[fault.code for fault, _ in FAULTS])
def test_a_storage_that_refuses_is_named_with_its_reason_and_waited_for(
        pair: Pair, bad: BadServer, fault: Fault, reason: str) -> None:
    """34, 38: the robot goes on with what it has; when the fault is over, nothing was lost."""
    pair.record(0)
    pair.dock()
    bad.faults.append(Fault(**vars(fault)))
    pair.server_works = False
    pair.record(1)
    pair.dock()
    assert pair.said["robot"] == [f"the storage is not reachable ({reason}): goes on with weights 1; "
                                  f"{'1 episode' if fault.method == 'PUT' else '0 episodes'} to be delivered"]
    bad.faults.clear()
    pair.server_works = True
    pair.record(2)
    pair.dock()
    assert pair.acting == pair.expected(0, 1, 2)


def test_no_secret_is_in_a_message(pair: Pair, bad: BadServer) -> None:
    """The bad server repeats the request, with its signature, in its answer."""
    bad.faults.append(Fault("status", "GET", times=9, status=403, code="AccessDenied"))
    with pytest.raises(Unreachable) as refused:
        pair.store().get("x", 9)
    assert str(refused.value) == "it refuses our key"
    assert refused.value.__cause__ is None and refused.value.__suppress_context__


def unreachable(monkeypatch: pytest.MonkeyPatch, endpoint: str, timeout: float = 5) -> str:
    monkeypatch.setenv("AWS_ENDPOINT_URL", endpoint)
    with pytest.raises(Unreachable) as error:
        ObjectStore.at("s3://bucket/x", timeout).get("anything", 9)
    return str(error.value)


def test_no_server_no_such_name_and_too_slow_are_three_reasons(
        place: Place, bad: BadServer, monkeypatch: pytest.MonkeyPatch) -> None:
    bad.objects["bucket/x/anything"] = b"x" * 9
    bad.faults.append(Fault("slow", "GET", times=9))
    assert unreachable(monkeypatch, bad.endpoint, timeout=0.1) == "no answer in time"
    assert unreachable(monkeypatch, f"http://127.0.0.1:{free_port()}") == "the connection was refused"
    assert unreachable(monkeypatch, "http://no-such-host.invalid") == "its name is not known (DNS)"


def test_a_storage_that_is_too_slow_for_a_while(pair: Pair, bad: BadServer) -> None:
    """34: 50 bytes a second, for robot and server."""
    pair.remote = replace(pair.remote, timeout=1.0)  # of a busy machine too
    pair.ledger.close()
    pair.boot_robot()
    pair.boot_server()
    pair.record(0)
    pair.dock()
    bad.faults.append(Fault("slow", "GET", times=99))
    pair.record(1)
    pair.dock()
    assert pair.said["robot"] == ["the storage is not reachable (no answer in time): goes on with weights 1; "
                                  "0 episodes to be delivered"]
    assert set(pair.said["server"]) == {"no answer in time"}
    bad.faults.clear()
    pair.record(2)
    pair.dock()
    pair.undisturbed(3)


def test_a_storage_that_dies_and_comes_back(pair: Pair, bad: BadServer, monkeypatch: pytest.MonkeyPatch) -> None:
    """34: the server's SIGKILL as its clients see it, with two episodes in between."""
    pair.record(0)
    pair.dock()
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{free_port()}")
    pair.server_works = False
    pair.robot.store = unreachable_store = pair.store()
    for seq in (1, 2):
        pair.record(seq)
        pair.dock()
    assert [line.partition(": goes")[0] for line in pair.said["robot"]] == [
        "the storage is not reachable (the connection was refused)"] * 2
    monkeypatch.setenv("AWS_ENDPOINT_URL", bad.endpoint)
    pair.robot.store, pair.server_works = pair.store(), True
    assert unreachable_store is not pair.robot.store
    pair.record(3)
    pair.dock()
    assert pair.acting == pair.expected(0, 1, 2, 3) and pair.robot.version == 4


def test_a_full_disk_stops_the_robot_too(pair: Pair, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = shutil.disk_usage(tmp_path)._replace(total=1000, used=801)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage)
    outbox = Outbox(tmp_path / "box", pair.mark, most=9, share=0.8)
    assert outbox.full() == ""  # nothing waits: it is not the outbox that fills it
    pair.record(0)
    outbox.add(0, pair.path(0), pair.episode(0), 0)
    assert outbox.full() == f"the disk of {tmp_path / 'box'} is filled to 80% (remote.disk=0.8)"


def test_an_object_is_never_larger_in_memory_than_it_may_be(pair: Pair, bad: BadServer) -> None:
    pair.store().put("large", b"x" * 1000)
    with pytest.raises(TooLarge, match="1000 bytes, of at most 999"):
        pair.store().get("large", 999)
    assert pair.store().get("large", 1000) == b"x" * 1000
    assert Pointer(3, "a" * 64, 1, "b" * 64, 2).key == "weights/000003-aaaaaaaaaaaaaaaa.safetensors"
