"""Broken, odd and hostile bags: a line for each, a non-zero exit, bounded memory. The inputs here do no harm."""

from __future__ import annotations

import signal
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drives import IMAGE, ODOM, Drive, mcap, ros1, ros2
from entry import Cli
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from curionav_cli.bags import ours, reader, sandbox, source
from curionav_cli.bags.library import refuse_without_rosbags
from curionav_cli.errors import BagError, ConfigError

LEGS = [(3.0, 0.2, 0.0)]
STORE = get_typestore(Stores.ROS2_HUMBLE)
BROKEN = "cannot be read as a bag"


def a_drive(**changes: Any) -> Drive:
    return Drive(LEGS, **{"images": 10.0, "odometry": 20.0, "side": 16, **changes})


def cut_off(path: Path, share: float) -> Path:
    raw = path.read_bytes()
    path.write_bytes(raw[:int(share * len(raw))])
    return path


def written(path: Path, raw: bytes) -> Path:
    path.write_bytes(raw)
    return path


def texts(folder: Path, topic: str, count: int = 3, kind: str = "std_msgs/msg/String") -> Path:
    """A bag of text on one topic."""
    writer = Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP)
    writer.open()
    connection = writer.add_connection(topic, kind, typestore=STORE)
    for at in range(count):
        writer.write(connection, at + 1, STORE.serialize_cdr(STORE.types[kind]("x"), kind))
    writer.close()
    return folder / f"{folder.name}.mcap"


def record(code: int, body: bytes) -> bytes:
    return struct.pack("<BQ", code, len(body)) + body


def text(words: str) -> bytes:
    return struct.pack("<I", len(words)) + words.encode()


def chunk_that_states(path: Path, stated: int, true: int, crc: int = 0) -> Path:
    """An MCAP file of one chunk, whose content has another size than it states."""
    from backports import zstd

    packed = zstd.compress(bytes(true))
    chunk = struct.pack("<QQQI", 1, 2, stated, crc) + text("zstd") + struct.pack("<Q", len(packed)) + packed
    magic = b"\x89MCAP0\r\n"
    body = record(1, text("ros2") + text("test")) + record(6, chunk) + record(15, struct.pack("<I", 0))
    return written(path, magic + body + record(2, struct.pack("<QQI", 0, 0, 0)) + magic)


Make = Callable[[Path], Path]
CASES: dict[str, tuple[Make, str]] = {
    "empty": (lambda d: written(d / "a.mcap", b""), BROKEN),
    "text": (lambda d: written(d / "a.mcap", b"This is no bag.\n" * 9), BROKEN),
    "text .bag": (lambda d: written(d / "a.bag", b"This is no bag.\n" * 9), BROKEN),
    "text .db3": (lambda d: written(d / "a.db3", b"This is no bag.\n" * 9), BROKEN),
    "mcap cut short": (lambda d: cut_off(mcap(d / "a", a_drive()), 0.6), BROKEN),
    "ros1 cut short": (lambda d: cut_off(ros1(d / "a.bag", a_drive()), 0.6), BROKEN),
    "sqlite cut short": (lambda d: cut_off(ros2(d / "a", a_drive(), StoragePlugin.SQLITE3) / "a.db3", 0.3), BROKEN),
    "metadata without a file": (lambda d: gone(ros2(d / "a", a_drive()) / "a.mcap"), BROKEN),
    "metadata that is none": (lambda d: written(ros2(d / "a", a_drive()) / "metadata.yaml", b"[1, 2").parent, BROKEN),
    "more than stated": (lambda d: chunk_that_states(d / "a.mcap", 100, 10_000), BROKEN),
    "less than stated": (lambda d: chunk_that_states(d / "a.mcap", 1 << 60, 10_000), BROKEN),
    "another checksum": (lambda d: chunk_that_states(d / "a.mcap", 10, 10, zlib.crc32(b"x")), BROKEN),
    "no topics": (lambda d: texts(d / "a", "/chatter", 0), "lacks the images or the odometry"),
    "other topics": (lambda d: texts(d / "a", "/chatter"), "It has /chatter"),
    "images of another type": (lambda d: texts(d / "a", IMAGE), f"It has {IMAGE}"),
    "no odometry": (lambda d: mcap(d / "a", only(IMAGE)), "lacks the images or the odometry"),
    "no images": (lambda d: mcap(d / "a", only(ODOM)), "lacks the images or the odometry"),
    "one image": (lambda d: mcap(d / "a", a_drive(change=first_image)), "holds no move"),
    "it stands still": (lambda d: mcap(d / "a", Drive([(2.0, 0.0, 0.0)], side=16)), "holds no move"),
    "another encoding": (lambda d: mcap(d / "a", a_drive(raw=True, image="/camera/image_raw", encoding="yuv422")),
                         "an image with encoding 'yuv422'"),
    "images that are none": (lambda d: mcap(d / "a", a_drive(change=no_pictures)), "neither JPEG nor PNG"),
    "odometry of nan": (lambda d: mcap(d / "a", a_drive(change=not_finite)), "odometry that is not finite"),
    "stamps that fall": (lambda d: mcap(d / "a", a_drive(change=falling)), "late odometry messages"),
    "a huge message": (lambda d: mcap(d / "a", a_drive()), "the most is 50"),
    "ours without images": (lambda d: texts(d / "a", ours.EPISODE), "lacks the images"),
}


def gone(path: Path) -> Path:
    path.unlink()
    return path.parent


def only(topic: str) -> Drive:
    return a_drive(change=lambda of, number, fields: fields if of == topic else None)


def first_image(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any] | None:
    return fields if topic == ODOM or number == 0 else None


def no_pictures(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any]:
    return fields if topic == ODOM else {**fields, "data": np.frombuffer(b"no picture", np.uint8)}


def not_finite(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any]:
    return {**fields, "x": float("nan")} if topic == ODOM else fields


def falling(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any]:
    return {**fields, "stamp": 1000.0 - 0.001 * number}


def one_line(error: BagError, path: Path) -> str:
    words = str(error)
    assert "\n" not in words and len(words) < 1000 and words.startswith(str(path)) and words.endswith("."), words
    return words


@pytest.mark.parametrize("name", CASES)
def test_a_bag_that_cannot_be_used_gets_one_line(tmp_path: Path, read, name: str,
                                                 monkeypatch: pytest.MonkeyPatch) -> None:
    make, said = CASES[name]
    path = make(tmp_path)
    if name == "a huge message":
        monkeypatch.setattr(reader, "LARGEST", 50)
    with pytest.raises(BagError) as caught:
        read(path)
    assert said in one_line(caught.value, path)


def refused(path: Path, bounds: sandbox.Bounds) -> str:
    out = path.parent / "out"
    out.mkdir()
    with pytest.raises(BagError) as caught:
        sandbox.convert(path, source.known(), out, "a", bounds)
    assert [left for left in out.iterdir() if left.suffix == ".npz"] == []
    return one_line(caught.value, path)


def test_what_unpacks_to_more_than_the_bound_gets_no_memory(tmp_path: Path) -> None:
    path = chunk_that_states(tmp_path / "a.mcap", 300 << 20, 300 << 20)
    assert path.stat().st_size < 100_000
    assert "needs more than 0.5 GB of memory to be unpacked" in refused(path, sandbox.Bounds(memory=1 << 29))


@pytest.mark.parametrize(("bounds", "said"), [
    (sandbox.Bounds(patience=0), "it took more than 0 s"),
    (sandbox.Bounds(file=1000), "File too large"),
], ids=["time", "files"])
def test_other_bounds_hold_too(tmp_path: Path, bounds: sandbox.Bounds, said: str) -> None:
    assert said in refused(mcap(tmp_path / "a", a_drive()), bounds)


@pytest.mark.parametrize(("code", "words", "said"), [
    (-signal.SIGXCPU, "", "it took more than 7 s of processor time, or all memory"),
    (-signal.SIGSEGV, "", "reading it ended by SIGSEGV; it is broken"),
    (1, "Traceback\n  line\nImportError: no rosbags\n", "ImportError: no rosbags"),
    (0, "", "reading it ended without a word"),
])
def test_a_process_that_ends_otherwise_is_told_of(code: int, words: str, said: str) -> None:
    assert sandbox.cause(code, words, 7) == said


def test_the_command_says_it_and_leaves_nothing(cli: Cli, tmp_path: Path) -> None:
    folder = tmp_path / "bags"
    folder.mkdir()
    mcap(folder / "good", a_drive())
    written(folder / "bad.mcap", b"no bag")
    written(folder / "worse.bag", b"no bag")
    answer = cli("train", "data=bags", "loop.iterations=1", "agent.action_repeat=1", "hydra.run.dir=run")
    lines = answer.error.strip().splitlines()
    assert answer.code == 2 and len(lines) == 2 and all(BROKEN in line for line in lines), answer.error
    assert "bad.mcap" in lines[0] and "worse.bag" in lines[1]
    assert not (tmp_path / "run").exists() and list((tmp_path / "cache" / "curionav" / "bags").iterdir()) == []


def test_a_file_that_is_no_bag_is_answered(cli: Cli, tmp_path: Path) -> None:
    written(tmp_path / "notes.txt", b"words")
    answer = cli("train", "data=notes.txt", "loop.iterations=1")
    assert answer.code == 2 and "neither a folder nor a bag (.mcap, .bag, .db3)" in answer.error


def test_without_the_extra_a_line_names_it(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("curionav_cli.bags.library.find_spec", lambda name: None)
    with pytest.raises(ConfigError, match=r"e '\.\[bags\]'"):
        refuse_without_rosbags()
    written(tmp_path / "a.mcap", b"")
    answer = cli("train", "data=a.mcap", "loop.iterations=1")
    assert answer.code == 2 and "'.[bags]'" in answer.error and len(answer.error.strip().splitlines()) == 1
