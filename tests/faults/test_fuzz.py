"""Readers under fuzz: whatever a file holds, our own error or a value comes of it, and no more memory than it declares.

Quick: a few hundred examples, always the same. Slow: as long as CURIONAV_FUZZ_SECONDS says, a minute without it:
    CURIONAV_FUZZ_SECONDS=3600 pytest -s -m slow tests/faults/test_fuzz.py
"""

from __future__ import annotations

import json
import os
import resource
import struct
import tempfile
import time
import tracemalloc
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from PIL import Image
from samples import READERS, Sample, a_map, a_picture, a_scene, an_episode

from curionav_cli.errors import RunFolderError, UserError
from curionav_cli.world.scene.map_image import FORMATS, PACKED
from curionav_cli.world.scene.reachability import CELLS
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

hypothesis = pytest.importorskip("hypothesis", reason="needs the extra dev")
from hypothesis import HealthCheck, given, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402

QUICK, SLACK = 60, 2 * 2**20  # examples; bytes for what a reader needs whatever the file
MOST = 8 * 2**30  # bytes of addresses, so that a reader without bounds fails before the machine does
DEFLATED = 1032  # bytes that one byte of deflate becomes at most
SECONDS = float(os.environ.get("CURIONAV_FUZZ_SECONDS", "60"))
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
    | st.sampled_from([10**9, 1e308, -1, 0, "box", "[" * 50, float("nan")]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=3), max_leaves=8)
HARM = st.lists(st.tuples(st.floats(0, 1), st.binary(max_size=6), st.integers(0, 40)), min_size=1, max_size=4)


def harmed(body: bytes, places: list[tuple[float, bytes, int]]) -> bytes:
    """At some places some bytes are left out and others put in."""
    for place, new, gone in places:
        at = int(place * len(body))
        body = body[:at] + new + body[at + gone:]
    return body


def honest(path: Path) -> int:
    """Bytes that the file holds by its own word, as far as they can be packed into it."""
    size = path.stat().st_size
    with suppress(Exception), warnings.catch_warnings():  # what Pillow says of broken files is of every kind
        warnings.simplefilter("ignore")
        with Image.open(path, formats=FORMATS) as image:
            return size + 8 * min(image.width * image.height, PACKED * size)
    with suppress(zipfile.BadZipFile, OSError, ValueError, NotImplementedError), zipfile.ZipFile(path) as archive:
        return size + sum(min(info.file_size, DEFLATED * info.compress_size) for info in archive.infolist())
    return size


@contextmanager
def at_most(limit: int, of: str) -> Iterator[None]:
    """No more bytes are taken meanwhile."""
    tracemalloc.start()
    try:
        yield
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most <= limit, f"{most} bytes for {of}"


def endure(read: Callable[[Path], Any], path: Path) -> None:
    """Reads it, or is refused by name; and takes little more memory than twice what the file holds."""
    with at_most(2 * honest(path) + SLACK, f"a file of {honest(path)}"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            read(path)
        except UserError as error:
            assert str(error)
        except (yaml.YAMLError, UnicodeDecodeError):
            assert path.name == "scene.yaml"  # which Hydra opens, and answers for


def tried(make: Callable[[Path], Sample], examples: int, fixed: bool) -> None:
    """Examples of one reader: bytes of a sound file changed at some places."""
    with tempfile.TemporaryDirectory() as name:
        path, read = make(Path(name))
        whole = path.read_bytes()
        endure(read, path)

        @settings(max_examples=examples, deadline=None, derandomize=fixed, database=None,
                  suppress_health_check=list(HealthCheck))
        @given(HARM)
        def one(places: list[tuple[float, bytes, int]]) -> None:
            path.write_bytes(harmed(whole, places))
            endure(read, path)
        one()


@pytest.mark.parametrize("make", READERS, ids=lambda make: make.__name__)
def test_a_changed_file_is_read_or_refused(make: Callable[[Path], Sample]) -> None:
    tried(make, QUICK if make is not a_scene else 10, fixed=True)


def changed_scenes(examples: int, fixed: bool) -> None:
    """Scenes in which a value somewhere is another one."""
    raw = {key: value for key, value in plain("small_room")[0].items() if not key.startswith("visitable")}
    places = list(spots(raw))

    @settings(max_examples=examples, deadline=None, derandomize=fixed, database=None,
              suppress_health_check=list(HealthCheck))
    @given(st.sampled_from(places), VALUES)
    def one(place: tuple[Any, ...], value: Any) -> None:
        scene = json.loads(json.dumps(raw))
        spot = scene
        for key in place[:-1]:
            spot = spot[key]
        spot[place[-1]] = value
        with at_most(32 * CELLS + SLACK, "a building of the largest size"):
            try:
                Scene.from_dict(scene, "scene.yaml")
            except UserError as error:
                assert len(str(error)) < 10_000
    one()


def spots(tree: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to every value of nested lists and dictionaries."""
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for key, value in inner:
        yield (*place, key)
        yield from spots(value, (*place, key))


def test_a_scene_with_another_value_stands_or_is_refused() -> None:
    changed_scenes(40, fixed=True)


@pytest.mark.parametrize(("name", "channels"), [
    ("map.pgm", 1), ("map.png", 1), ("map.png", 3), ("map.png", 4), ("map.bmp", 3), ("map.jpg", 1), ("map.ppm", 3),
    ("map.tiff", 1), ("map.tiff", 3), ("map.webp", 3), ("map.webp", 4), ("map.gif", 3)])
def test_a_large_map_takes_twice_its_pixels(tmp_path: Path, name: str, channels: int) -> None:
    where, read = a_map(tmp_path)
    where.write_text(where.read_text().replace("map.pgm", name))
    pixels = np.random.default_rng(0).integers(0, 256, (1500, 1500, channels), np.uint8)
    cv2.imwrite(str(tmp_path / name), pixels)
    with at_most(2 * pixels.nbytes + SLACK, "its pixels"):
        assert read(where).cells.shape == (1500, 1500)


CLAIMS = {  # where columns and rows stand: so many bytes after a mark
    "png": [(b"IHDR", 4, ">I"), (b"IHDR", 8, ">I")], "bmp": [(b"BM", 18, "<i"), (b"BM", 22, "<i")],
    "jpg": [(b"\xff\xc0", 5, ">H"), (b"\xff\xc0", 7, ">H")], "gif": [(b"GIF", 6, "<H"), (b"GIF", 8, "<H")],
    "tiff": [(b"\x00\x01\x04\x00", 8, "<I"), (b"\x01\x01\x04\x00", 8, "<I")]}


@pytest.mark.parametrize("kind", CLAIMS)
def test_a_picture_that_claims_more_than_it_holds(tmp_path: Path, kind: str) -> None:
    """335 bytes of such a JPEG took 1.8 GB."""
    path, read = a_picture(tmp_path, kind, 1)
    raw = bytearray(path.read_bytes())
    for side in (9000, 60000):
        for mark, further, form in CLAIMS[kind]:
            struct.pack_into(form, raw, raw.find(mark) + further, side)
        if kind == "png":
            struct.pack_into(">I", raw, 29, zlib.crc32(raw[12:29]))
        path.write_bytes(raw)
        with at_most(SLACK, "what is refused"), pytest.raises(UserError, match=r"pixels"):
            read(path)


@pytest.mark.slow
@pytest.mark.timeout(0)
def test_other_examples_each_time() -> None:
    """Every reader in turn, at least once; what it did is printed."""
    allowed = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (MOST, allowed[1]))
    try:
        fuzzed(SECONDS)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, allowed)


def fuzzed(seconds: float) -> None:
    end, examples = time.monotonic() + seconds, 0
    while not examples or time.monotonic() < end:
        for make in READERS:
            count = 300 if make is not a_scene else 30
            tried(make, count, fixed=False)
            examples += count
        changed_scenes(100, fixed=False)
        examples += 100
        print(f"{examples} examples, {time.process_time():.0f} CPU-seconds", flush=True)


def test_what_is_refused_is_named(tmp_path: Path) -> None:
    path, read = an_episode(tmp_path)
    path.write_bytes(b"")
    with pytest.raises(RunFolderError, match=r"episode\.npz"):
        read(path)
