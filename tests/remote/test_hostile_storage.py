"""Hostile objects in a storage: names, archives, markers and settings are refused before they are opened, or before
memory is taken for them."""

from __future__ import annotations

import io
import json
import struct
import tracemalloc
import warnings
import zipfile
import zlib

import numpy as np
import pytest
from remote.pair import STEPS, Pair
from servers import Place

from curionav_cli.decisions import Steps
from curionav_cli.errors import RunFolderError, Unreachable
from curionav_cli.remote.protocol import LATEST, SEAL, Marker, agree_on_settings, sha256, written

NAMES = ["x", "000001-0123456789ABCDEF", "deeper/000001-0123456789abcdef", "000001-0123456789abcdef.json",
         "1-0123456789abcdef", "000001-0123456789abcde", "9999999999-0123456789abcdef"]


@pytest.mark.parametrize("name", NAMES)
def test_names_that_are_none_are_never_opened(pair: Pair, name: str) -> None:
    pair.store().put(f"episodes/{name}.json", b"{}")
    pair.record(0)
    pair.dock()
    assert pair.acting == pair.expected(0) and pair.said["server"] == []


@pytest.mark.parametrize("name", ["../../etc/passwd", "000001-0123456789abcdef.json/../../x"])
def test_names_that_lead_elsewhere_lead_nowhere(pair: Pair, place: Place, name: str) -> None:
    """None of our keys can; a foreign one is reported, and nothing is lost meanwhile."""
    with pytest.raises(Unreachable, match="a name that leads elsewhere"):
        pair.store().get(f"episodes/{name}", 9)
    with pytest.raises(Unreachable, match="a name that leads elsewhere"):
        pair.store().put(f"episodes/{name}", b"")
    pair.record(0)
    if place.bad:
        key = f"{place.url.removeprefix('s3://')}/episodes/{name}.json"
        place.bad.objects[key] = b"{}"
        pair.dock()
        assert set(pair.said["server"]) == {"it holds an object with a name that leads elsewhere: remove that"}
        del place.bad.objects[key]
    pair.dock()
    assert pair.acting == pair.expected(0)


def npz(names: list[str], size: int = 10, header: bytes = b"", packed: int = zipfile.ZIP_DEFLATED,
        more: dict[str, int] | None = None) -> bytes:
    raw = io.BytesIO()
    with warnings.catch_warnings(action="ignore"), zipfile.ZipFile(raw, "w", packed) as archive:
        for name in names:
            archive.writestr(name, header + b"\0" * (more or {}).get(name, size))
    return raw.getvalue()


def claiming(shape: str, dtype: str = "|u1") -> bytes:
    """An npy header that declares this shape and type."""
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(117) + b"\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text


def lying(raw: bytes, at: int = 24, size: int = 10, checksum: int | None = None) -> bytes:
    """Another number in the table of contents, for the first member: at byte 24 the size that it unfolds to."""
    body, entry = bytearray(raw), raw.index(b"PK\1\2")
    struct.pack_into("<I", body, entry + at, size)
    if checksum is not None:
        struct.pack_into("<I", body, entry + 16, checksum)
    return bytes(body)


def longer_table(raw: bytes) -> bytes:
    """With a second table of contents, as archives of more than 65,535 members have one."""
    return raw[:-22] + b"PK\6\7" + b"\0" * 16 + raw[-22:]


FIVE = [f"{name}.npy" for name in ("image", "action", "pose", "collided", "events")]
LARGE = {FIVE[0]: 40_000_000}
HOSTILE = {
    "a bomb of 200 MB": npz(FIVE, 40_000_000), "a thousand members": npz([str(i) for i in range(1000)]),
    "other names": npz(["../../evil.npy", *FIVE[1:]]), "the same name twice": npz([*FIVE[:4], FIVE[0]]),
    "no archive": b"x" * 100, "nothing": b"", "a shape of terabytes": npz(FIVE, 8, claiming("(1000000000000,)")),
    "objects": npz(FIVE, 8, claiming("(1,)", "|O")), "a header of code": npz(FIVE, 8, claiming("__import__('os')")),
    "a bomb that says it is small": lying(npz(FIVE, more=LARGE)),
    "with the checksum of what it says": lying(npz(FIVE, more=LARGE), checksum=zlib.crc32(b"\0" * 10)),
    "a bomb in bzip2": lying(npz(FIVE, packed=zipfile.ZIP_BZIP2, more=LARGE)),
    "a longer table of contents": longer_table(npz(FIVE)),
    "an unknown method": lying(npz(FIVE), at=10, size=99),
    "a header that does not end": npz(FIVE, 8, claiming("(")),
    "events of a megabyte": npz(FIVE, 8, claiming("(8,)"), more={FIVE[4]: 1_100_000}),
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_archive_is_refused_before_memory_is_taken(pair: Pair, kind: str) -> None:
    raw = HOSTILE[kind]
    marker = Marker(0, sha256(raw), len(raw), STEPS, 0, pair.mark, "boot", 0.0, 0.0)
    pair.store().put(f"episodes/{marker.name}.npz", raw)
    pair.store().put(f"episodes/{marker.name}.json", written(marker))
    tracemalloc.start()
    pair.serve()
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert list(pair.ledger.refused()) == [marker.name] and pair.server.done == 0
    assert taken < 4_000_000


@pytest.mark.parametrize(("change", "said"), [
    ({"size": 2**50}, "5 steps in 1125899906842624 bytes cannot be"), ({"size": -1}, "its size is not what it should"),
    ({"steps": 6}, "6 steps in"), ({"steps": 4}, "it holds no 5 poses"), ({"steps": True}, "its steps is not"),
    ({"settings": "0" * 64}, "it was recorded with other settings"), ({"boot": "\x1b[2J"}, "its boot is not what"),
    ({"seq": 3}, "its marker names another episode"), ({"monotonic": "now"}, "its monotonic is not what"),
])
def test_a_marker_that_does_not_fit_is_refused(pair: Pair, change: dict, said: str) -> None:
    pair.record(0)
    [marker] = pair.outbox.waiting()
    pair.store().put(f"episodes/{marker.name}.npz", pair.outbox.data(marker))
    pair.store().put(f"episodes/{marker.name}.json", SEAL.sealed({**vars(marker), **change}).encode())
    pair.serve()
    [reason] = pair.ledger.refused().values()
    assert (said in reason or change == {"steps": 4}) and pair.server.done == 0
    pair.dock()
    assert pair.acting == pair.expected(0)


def test_poses_that_are_not_finite_and_foreign_actions_are_refused(pair: Pair) -> None:
    bad = pair.an_episode(steps=STEPS)
    bad.pose[2] = np.nan
    pair.record(0, bad)
    pair.robot.exchange(1)
    pair.serve()
    assert list(pair.ledger.refused().values()) == ["it holds no 6 poses"]


def test_a_pointer_of_a_megabyte_is_no_pointer(pair: Pair) -> None:
    pair.store().put(LATEST, b"[" * 2**20)
    pair.server_works = False
    pair.record(0)
    pair.dock()
    assert "new weights cannot be used (it has 1048576 bytes, of at most 65536)" in pair.said["robot"][-1]
    pair.serve()
    pair.dock()
    assert pair.acting == pair.expected(0)


def test_settings_of_a_megabyte_and_deep_json_are_no_settings(pair: Pair) -> None:
    for raw in (b"[" * 100_000, b"{", b"\xff", b" " * 2**21):
        pair.store().put("settings.json", raw)
        with pytest.raises(RunFolderError, match=r"its settings\.json is broken"):
            agree_on_settings(pair.store(), {"seed": 0})
    pair.store().put("settings.json", json.dumps({"seed": 1}).encode())
    with pytest.raises(RunFolderError, match="it is used with other settings: seed was 1, now 0"):
        agree_on_settings(pair.store(), {"seed": 0})


def test_an_episode_whose_actions_were_not_held_is_refused(pair: Pair) -> None:
    """It is well formed, and learning from it would end the server, each time anew."""
    pair.record(0)
    pair.server.inbox.every = Steps(2)
    pair.dock()
    assert pair.learned == b"\0" * 32
    assert any("is refused: it was recorded without agent.action_repeat=2" in line for line in pair.said["server"])
