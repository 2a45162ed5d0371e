"""The store: which URLs are places, whom a service takes us for, and that hostile things are refused early."""

from __future__ import annotations

import io
import json
import struct
import tracemalloc
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest
from servers import Place
from storage.remote.pair import STEPS, Pair

from curionav_cli.errors import ConfigError, Unreachable
from curionav_cli.storage.credentials import s3_options
from curionav_cli.storage.protocol import LATEST, Marker, Pointer, parsed, sealed, sha256, written
from curionav_cli.storage.store import Store, parts

SECRET = "wJalrXUtnFEMI"


@pytest.mark.parametrize(("url", "place"), [
    ("file:///srv/robot", ("file", "", "/srv/robot")), ("file:///srv/a/../b%20c", ("file", "", "/srv/b c")),
    ("file://localhost/srv", ("file", "", "/srv")), ("s3://bucket/a/b", ("s3", "bucket", "/a/b")),
    ("s3://bucket", ("s3", "bucket", "")),
])
def test_places(url: str, place: tuple[str, str, str]) -> None:
    assert parts(url) == place


@pytest.mark.parametrize("url", [
    f"s3://AKIA:{SECRET}@bucket/x", f"s3://bucket/x?secret={SECRET}", f"file:///x#{SECRET}", "ftp://x/y", "file://srv/x",
    "s3://b/../../x", "s3:///x", "/srv/robot", "", "file:relative",
])
def test_what_is_no_place_is_refused_without_repeating_secrets(url: str) -> None:
    with pytest.raises(ConfigError, match="storage: ") as refused:
        parts(url)
    assert SECRET not in str(refused.value)


def test_a_key_comes_from_the_environment_or_from_the_files_of_aws(tmp_path: Path) -> None:
    """The environment is read by obstore itself; a profile has its own section."""
    aws = tmp_path / ".aws"
    aws.mkdir()
    (aws / "credentials").write_text(f"[default]\naws_access_key_id = A\naws_secret_access_key = {SECRET}\n"
                                     "[lab]\naws_access_key_id = L\naws_secret_access_key = l%l\naws_session_token=t\n")
    (aws / "config").write_text("[profile lab]\nregion = eu-west-1\nendpoint_url = http://10.0.0.1:9\n")
    both = {"access_key_id": "A", "secret_access_key": SECRET, "region": "us-east-1"}
    assert s3_options({}, tmp_path) == both
    lab = {"access_key_id": "L", "secret_access_key": "l%l", "session_token": "t", "region": "eu-west-1",
           "endpoint": "http://10.0.0.1:9"}
    assert s3_options({"AWS_PROFILE": "lab"}, tmp_path) == lab
    here = {"AWS_ACCESS_KEY_ID": "E", "AWS_REGION": "x", "AWS_ENDPOINT_URL": "http://e"}
    assert s3_options(here, tmp_path) == {"endpoint": "http://e"}
    with pytest.raises(ConfigError, match="no key for the S3 service"):
        s3_options({"AWS_ENDPOINT_URL": "http://e"}, tmp_path / "nobody")
    (aws / "credentials").write_text(f"aws_secret_access_key = {SECRET}")
    with pytest.raises(ConfigError, match="cannot be read as AWS's tools write it") as refused:
        s3_options({}, tmp_path)
    assert SECRET not in str(refused.value) and refused.value.__context__ is None


def test_a_folder_that_is_not_mounted_is_not_made_anew(tmp_path: Path) -> None:
    store = Store.at((tmp_path / "mnt" / "x").as_uri(), 5)
    with pytest.raises(Unreachable, match="there is no folder"):
        store.put("episodes/a", b"x")
    assert not (tmp_path / "mnt").exists()


NAMES = ["x", "000001-0123456789ABCDEF", "deeper/000001-0123456789abcdef", "000001-0123456789abcdef.json",
         "1-0123456789abcdef", "000001-0123456789abcde", "9999999999-0123456789abcdef"]


@pytest.mark.parametrize("name", NAMES)
def test_names_that_are_none_are_never_opened(pair: Pair, name: str) -> None:
    pair.store().put(f"episodes/{name}.json", b"{}")
    pair.live(0)
    pair.dock()
    assert pair.acting == pair.expected(0) and pair.said["server"] == []


@pytest.mark.parametrize("name", ["../../etc/passwd", "000001-0123456789abcdef.json/../../x"])
def test_names_that_lead_elsewhere_lead_nowhere(pair: Pair, place: Place, name: str) -> None:
    """No key that we write can; where somebody else's does, it is told, and nothing is lost meanwhile."""
    with pytest.raises(Unreachable, match="a name that leads elsewhere"):
        pair.store().get(f"episodes/{name}", 9)
    with pytest.raises(Unreachable, match="a name that leads elsewhere"):
        pair.store().put(f"episodes/{name}", b"")
    pair.live(0)
    if place.bad:
        key = f"{place.url.removeprefix('s3://')}/episodes/{name}.json"
        place.bad.objects[key] = b"{}"
        pair.dock()
        assert set(pair.said["server"]) == {"it holds an object with a name that leads elsewhere: remove that"}
        del place.bad.objects[key]
    pair.dock()
    assert pair.acting == pair.expected(0)


def npz(names: list[str], size: int = 10, header: bytes = b"") -> bytes:
    raw = io.BytesIO()
    with warnings.catch_warnings(action="ignore"), zipfile.ZipFile(raw, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in names:
            archive.writestr(name, header + b"\0" * size)
    return raw.getvalue()


def claiming(shape: str, dtype: str = "|u1") -> bytes:
    """An npy header that says so much."""
    text = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(117) + b"\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(text)) + text


FIVE = [f"{name}.npy" for name in ("image", "action", "pose", "collided", "events")]
HOSTILE = {
    "a bomb of 200 MB": npz(FIVE, 40_000_000), "a thousand members": npz([str(i) for i in range(1000)]),
    "other names": npz(["../../evil.npy", *FIVE[1:]]), "the same name twice": npz([*FIVE[:4], FIVE[0]]),
    "no archive": b"x" * 100, "nothing": b"", "a shape of terabytes": npz(FIVE, 8, claiming("(1000000000000,)")),
    "objects": npz(FIVE, 8, claiming("(1,)", "|O")), "a header of code": npz(FIVE, 8, claiming("__import__('os')")),
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
    ({"settings": "0" * 64}, "it was lived with other settings"), ({"boot": "\x1b[2J"}, "its boot is not what"),
    ({"seq": 3}, "its marker tells of another one"), ({"monotonic": "now"}, "its monotonic is not what"),
])
def test_a_marker_that_cannot_be_meant_is_refused(pair: Pair, change: dict, said: str) -> None:
    pair.live(0)
    [marker] = pair.outbox.waiting()
    pair.store().put(f"episodes/{marker.name}.npz", pair.outbox.data(marker))
    pair.store().put(f"episodes/{marker.name}.json", sealed({**vars(marker), **change}))
    pair.serve()
    [reason] = pair.ledger.refused().values()
    assert (said in reason or change == {"steps": 4}) and pair.server.done == 0
    pair.dock()
    assert pair.acting == pair.expected(0)


def test_poses_that_are_not_finite_and_foreign_actions_are_refused(pair: Pair) -> None:
    bad = pair.an_episode(steps=STEPS)
    bad.pose[2] = np.nan
    pair.live(0, bad)
    pair.robot.exchange(1)
    pair.serve()
    assert list(pair.ledger.refused().values()) == ["it holds no 6 poses"]


def test_settings_of_a_megabyte_and_deep_json_are_no_settings(pair: Pair) -> None:
    from curionav_cli.commands.remote import agree
    from curionav_cli.errors import RunFolderError

    for raw in (b"[" * 100_000, b"{", b"\xff"):
        pair.store().put("settings.json", raw)
        with pytest.raises(RunFolderError, match=r"its settings\.json is broken"):
            agree(pair.store(), {"seed": 0})
    pair.store().put("settings.json", json.dumps({"seed": 1}).encode())
    with pytest.raises(RunFolderError, match="it is used with other settings: seed was 1, now 0"):
        agree(pair.store(), {"seed": 0})


def test_the_everyday_life_on_servers_that_others_wrote(real: Place, tmp_path: Path, an_episode) -> None:
    """A little of all of it, each time; the whole is run with -m slow."""
    with Pair(real.url, tmp_path, an_episode).at_work() as pair:
        for seq in range(3):
            pair.live(seq)
            pair.dock()
        assert pair.acting == pair.expected(0, 1, 2) and pair.said == {"robot": [], "server": []}
        pair.boot_robot()
        pair.boot_server()
        pair.live(3)
        [marker] = pair.outbox.waiting()
        pair.store().put(f"episodes/{marker.name}.npz", b"half of it")
        pair.store().put(f"episodes/{marker.name}.json", written(marker))
        pair.serve()
        assert list(pair.ledger.refused()) == [marker.name]
        pair.dock()
        assert pair.acting == pair.expected(0, 1, 2, 3)
        assert parsed(Pointer, pair.store().get(LATEST, 999)).version == 4
        with pytest.raises(Unreachable, match="it has no such bucket"):
            Store.at("s3://no-such-bucket/x", 5).get(LATEST, 999)
