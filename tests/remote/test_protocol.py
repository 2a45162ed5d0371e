"""Robot and server at every kind of storage: what is delivered, learned and returned."""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest
from remote.pair import Pair

from curionav_cli.errors import RunFailed, Unreachable
from curionav_cli.remote import outbox
from curionav_cli.remote.protocol import LATEST, SEAL, Pointer, Refusal, fingerprint, parsed, sha256, written


def everyday(pair: Pair, episodes: int = 3) -> None:
    pair.dock()
    for seq in range(episodes):
        pair.record(seq)
        pair.dock()


def test_everyday_use(pair: Pair) -> None:
    """Each episode is learned from once, in order; its weights act in the next one."""
    pair.dock()
    for seq in range(4):
        pair.record(seq)
        pair.dock()
        assert pair.robot.version == seq + 1 and pair.robot.newest_trained == seq
        assert pair.acting == pair.learned == pair.expected(*range(seq + 1))
        assert not pair.outbox.waiting() and not list(pair.outbox.folder.glob("*.npz"))
    assert pair.said == {"robot": [], "server": []}
    pointer = parsed(Pointer, pair.store().get(LATEST, 999))
    assert pointer == Pointer(4, sha256(pair.acting), 32, pair.mark, 3)
    kept = pair.store().names("weights", re.compile(r".*safetensors"))
    assert [name[:6] for name in kept] == ["000002", "000003", "000004"]


@pytest.mark.parametrize("order", [(2, 0, 1), (2, 1, 0), (1, 2, 0)])
def test_episodes_that_come_in_another_order_are_learned_from_in_their_own(pair: Pair, order) -> None:
    pair.server_works = False
    for seq in order:
        pair.record(seq)
        pair.robot.exchange(pair.recorded)
        pair.serve()
    assert pair.learned == pair.expected(0, 1, 2) and pair.server.done == 3


def test_a_number_that_never_comes_is_waited_for_and_then_left_out(pair: Pair) -> None:
    pair.record(0)
    pair.record(2)
    pair.dock()
    assert pair.learned == pair.expected(0, 2) and pair.now >= pair.remote.gap
    assert pair.said["server"] == ["episode 2 is here and 1 is not: waits up to 30 s for it",
                                   "episode 1 did not come: goes on with 2"]
    pair.record(1)
    pair.dock()  # late, but not lost
    pair.serve()
    assert pair.learned == pair.expected(0, 2, 1)


def test_sent_again_is_learned_from_once(pair: Pair) -> None:
    everyday(pair, 2)
    for marker in (pair.outbox.delivered(name) for name in sorted(pair.ledger.names())):
        pair.robot.send(marker, pair.path(marker.seq))
    pair.serve()
    pair.boot_server()
    pair.serve()
    assert pair.server.done == 2 and pair.learned == pair.expected(0, 1)


def test_one_number_with_two_contents_is_reported_and_both_are_kept(pair: Pair) -> None:
    everyday(pair, 1)
    other = pair.an_episode(steps=5, seed=77)
    pair.record(0, other)
    pair.robot.exchange(pair.recorded)
    pair.serve()
    assert pair.server.done == 2
    assert pair.said["server"] == ["episode 0 came twice, with different content: both are learned from"]


def test_data_without_a_marker_do_not_count(pair: Pair) -> None:
    """The robot crashed between the two; after its reboot it sends both."""
    pair.record(0)
    [marker] = pair.outbox.waiting()
    pair.store().put(f"episodes/{marker.name}.npz", pair.outbox.data(marker))
    pair.serve()
    assert pair.server.done == 0
    pair.boot_robot()
    pair.dock()
    assert pair.acting == pair.expected(0)


def test_a_marker_without_data_is_refused_until_they_come(pair: Pair) -> None:
    everyday(pair, 1)
    pair.record(1)
    [marker] = pair.outbox.waiting()
    pair.store().put(f"episodes/{marker.name}.json", written(marker))
    pair.serve()
    assert pair.ledger.refused() == {marker.name: "there is a marker and no episode"}
    pair.dock()
    assert pair.acting == pair.expected(0, 1) and pair.ledger.refused() == {}


def test_a_rebooted_robot_acts_with_what_it_had(pair: Pair) -> None:
    everyday(pair, 3)
    pair.boot_robot()
    assert pair.robot.version == 3 and pair.acting == pair.expected(0, 1, 2)
    newest = pair.folder / "robot" / "weights" / f"000003-{sha256(pair.acting)[:16]}.safetensors"
    newest.write_bytes(b"torn")
    pair.boot_robot()  # rolled back to the ones before
    assert pair.robot.version == 2 and pair.acting == pair.expected(0, 1)
    assert "cannot be used (its checksum is another one)" in pair.said["robot"][-1]
    pair.dock()
    assert pair.robot.version == 3 and pair.acting == pair.expected(0, 1, 2)


def test_without_new_weights_the_robot_waits_and_goes_on(pair: Pair) -> None:
    pair.server_works = False
    pair.record(0)
    pair.dock()
    assert pair.said["robot"] == [
        "at the dock: waits up to 50 s each time for new weights, which a curionav train storage=... has to make",
        "no new weights after 50 s: goes on with weights 0; 0 episodes to be delivered"]
    pair.serve()
    pair.record(1)
    pair.server_works = True
    pair.dock()
    assert pair.acting == pair.expected(0, 1) and pair.robot.version == 2


@pytest.mark.parametrize(("harm", "said"), [
    (lambda pointer: {"settings": fingerprint({"seed": 1})}, "they were trained with other settings"),
    (lambda pointer: {"size": 2**50}, "they have 1125899906842624 bytes, this agent's have 32"),
    (lambda pointer: {"sha256": "0" * 64}, "they are not what was announced"),
    (lambda pointer: {"version": 1}, "version 1 is older than 2"),
    (lambda pointer: {"version": "9"}, "its version is not what it should be"),
    (lambda pointer: {"sha256": "../../../etc/passwd"}, "its sha256 is not what it should be"),
])
def test_weights_that_are_not_what_they_should_be_are_not_taken(pair: Pair, harm, said) -> None:
    everyday(pair, 2)
    acting, pointer = pair.acting, vars(parsed(Pointer, pair.store().get(LATEST, 999)))
    pair.store().put(LATEST, SEAL.sealed({**pointer, "version": 3, **harm(pointer)}).encode())
    pair.server_works = False
    pair.record(2)
    pair.dock()
    assert pair.said["robot"] == [f"new weights cannot be used ({said}): goes on with weights 2; "
                                  "0 episodes to be delivered"]
    assert pair.acting == acting and pair.robot.version == 2


@pytest.mark.parametrize(("raw", "said"), [(b"nan" + b"\1" * 29, "they are no links of the chain"),
                                           (b"\1" * 31, "they have 31 bytes, this agent's have 32")])
def test_weights_that_do_not_act_leave_the_old_ones(pair: Pair, raw: bytes, said: str) -> None:
    everyday(pair, 1)
    pointer = Pointer(2, sha256(raw), len(raw), pair.mark, 1)
    pair.store().put(pointer.key, raw)
    pair.store().put(LATEST, written(pointer))
    pair.server_works = False
    pair.record(1)
    pair.dock()
    assert said in pair.said["robot"][-1] and pair.acting == pair.expected(0)


@pytest.mark.parametrize("raw", [b"", b"\xff\xfe", b"[]", b"{", b"[" * 60000, b'{"version": NaN}',
                                 SEAL.sealed({"a": 1}).encode(),
                                 written(Pointer(9, "0" * 64, 32, "0" * 64, 9)).replace(b"9", b"8")])
def test_a_pointer_that_is_garbage_is_no_pointer(pair: Pair, raw: bytes) -> None:
    pair.store().put(LATEST, raw)
    pair.server_works = False
    pair.record(0)
    pair.dock()
    assert "new weights cannot be used" in pair.said["robot"][-1]
    pair.serve()  # and is mended by the server
    pair.dock()
    assert pair.acting == pair.expected(0)


def test_two_servers(pair: Pair, an_episode) -> None:
    """The second is warned, and does not write over what it did not make."""
    everyday(pair, 2)
    second = Pair(pair.url, pair.folder / "second", an_episode)
    second.server.publisher.announce()
    assert second.said["server"] == ["another curionav train says that it serves this storage. "
                                     "One of the two is too many."]
    before = pair.store().get(LATEST, 999)
    with pytest.raises(RunFailed, match="weights of version 2 that are not of this training"):
        second.serve()
    assert pair.store().get(LATEST, 999) == before
    second.ledger.close()


def test_no_clock_decides_anything(pair: Pair, monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot whose clock jumps by days, back and forth; the keys hold no time."""
    times = iter([1e9, 0.0, 1e9 + 86400, 3.0, 1e9 - 86400, 1.0, 0.0, 2.0])
    monkeypatch.setattr(outbox, "time", SimpleNamespace(time=lambda: next(times), monotonic=lambda: next(times)))
    pair.server_works = False
    for seq in range(4):
        pair.record(seq)
    keys = [marker.name for marker in pair.outbox.waiting()]
    assert keys == [f"{seq:06d}-{sha256(pair.path(seq).read_bytes())[:16]}" for seq in range(4)]
    pair.server_works = True
    pair.dock()
    assert pair.acting == pair.expected(0, 1, 2, 3)


def test_a_refusal_is_answered_once_each_time(pair: Pair) -> None:
    everyday(pair, 1)
    name = next(iter(pair.ledger.names()))
    pair.store().put(f"refused/{name}.json", written(Refusal(1, "torn")))
    for _ in range(3):
        pair.robot.exchange(pair.recorded)
    assert pair.said["robot"] == ["the server could not use episode 0 (torn): sends it again"]
    pair.store().put(f"refused/{name}.json", written(Refusal(9, "\x1b[2J")))  # no text for a terminal
    pair.robot.exchange(pair.recorded)
    assert len(pair.said["robot"]) == 1


def test_a_place_that_is_gone_is_not_an_empty_place(pair: Pair) -> None:
    everyday(pair, 1)
    store = pair.store()
    assert store.get("weights/000009-none", 9) is None and store.size("nothing") is None
    if store.root:
        store.root.rename(store.root.with_name("away"))
        with pytest.raises(Unreachable, match="there is no folder"):
            pair.store().get(LATEST, 999)
