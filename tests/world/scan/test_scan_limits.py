"""Broken and lying files: one line each, before memory is allocated for what they claim."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from meshmaking import room, write_ply, write_stl

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.gltf_limits import BIN, JSON
from curionav_cli.world.scan.limits import refuse_broken
from curionav_cli.world.scan.reader import read_mesh

pytest.importorskip("trimesh", reason="the extra scan is not installed")

PLACES = np.float32([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]).tobytes() + np.uint32([0, 1, 2, 0, 2, 3]).tobytes()


def tree() -> dict[str, Any]:
    """A square in two triangles."""
    return {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                      {"bufferView": 1, "componentType": 5125, "count": 6, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "buffers": [{"byteLength": 72}],
    }


def glb(held: dict[str, Any] | bytes, body: bytes = PLACES, length: int | None = None) -> bytes:
    text = held if isinstance(held, bytes) else json.dumps(held).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON) + text + struct.pack("<II", len(body), BIN) + body
    return struct.pack("<4sII", b"glTF", 2, length or 12 + len(chunks)) + chunks


def with_change(change: Callable[[dict[str, Any]], Any]) -> bytes:
    held = tree()
    change(held)
    return glb(held)


def a_png(width: int, height: int) -> bytes:
    """The head of a PNG of that size, and next to nothing in it."""
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    def chunk(kind: bytes, raw: bytes) -> bytes:
        return struct.pack(">I", len(raw)) + kind + raw + struct.pack(">I", zlib.crc32(kind + raw))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0")) + chunk(b"IEND", b"")


def with_picture(width: int, height: int) -> bytes:
    held, raw = tree(), a_png(width, height)
    held["bufferViews"].append({"buffer": 0, "byteOffset": 72, "byteLength": len(raw)})
    held["buffers"][0]["byteLength"] = 72 + len(raw)
    held["images"] = [{"bufferView": 2, "mimeType": "image/png"}]
    return glb(held, PLACES + raw)


def twice(held: dict[str, Any]) -> None:
    """Nodes that hang in one another: 2^20 squares in a few bytes."""
    held["nodes"] = [{"children": [at + 1, at + 1]} for at in range(20)] + [{"mesh": 0}]


PLY = b"ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
FACES = b"element face %d\nproperty list uchar int vertex_indices\nend_header\n"
BAD = {
    "pointer.glb": b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n",
    "empty.glb": b"", "words.glb": b"once upon a time, a mesh", "cut.glb": glb(tree())[:-20],
    "long.glb": glb(tree(), length=1 << 31), "version.glb": struct.pack("<4sII", b"glTF", 1, 20) + b"\0" * 8,
    "chunk.glb": struct.pack("<4sIIII", b"glTF", 2, 20, 1 << 30, JSON), "json.glb": glb(b"{" * 5000),
    "list.glb": glb(b"[]"), "buffer.glb": with_change(lambda held: held["buffers"][0].update(byteLength=1 << 40)),
    "view.glb": with_change(lambda held: held["bufferViews"][1].update(byteOffset=1 << 20)),
    "count.glb": with_change(lambda held: held["accessors"][0].update(count=1 << 30)),
    "negative.glb": with_change(lambda held: held["accessors"][0].update(count=-1)),
    "sparse.glb": with_change(lambda held: held["accessors"][0].pop("bufferView")),
    "absent.glb": with_change(lambda held: held["meshes"].clear()), "twice.glb": with_change(twice),
    "circle.glb": with_change(lambda held: held["nodes"][0].update(children=[0])),
    "draco.glb": with_change(lambda held: held.update(extensionsRequired=["KHR_draco_mesh_compression"])),
    "outside.glb": with_change(lambda held: held["buffers"][0].update(uri="../../etc/passwd")),
    "beside.gltf": json.dumps({**tree(), "buffers": [{"byteLength": 72, "uri": "data.bin"}]}).encode(),
    "nothing.glb": glb({"asset": {"version": "2.0"}}), "picture.glb": with_picture(60000, 60000),
    "index.glb": glb(tree(), PLACES[:48] + np.uint32([0, 1, 2, 0, 2, 900]).tobytes()),
    "infinite.glb": glb(tree(), np.float32([[np.inf, 0, 0]] * 4).tobytes() + PLACES[48:]),
    "cut.ply": PLY % 1000 + FACES % 10 + b"\0" * 100, "bomb.ply": PLY % 50_000_000 + FACES % 50_000_000,
    "huge.ply": PLY % 10**12 + FACES % 1, "points.ply": PLY % 1 + b"end_header\n" + b"\0" * 12,
    "header.ply": b"ply\nformat ascii 1.0\n", "line.ply": b"ply\nelement vertex many\nend_header\n",
    "kind.ply": b"ply\nelement vertex 3\nproperty colour x\nend_header\n",
    "cut.stl": b"\0" * 80 + b"\xff\0\0\0" + b"\0" * 90,
    "words.stl": b"no mesh at all", "binary.obj": b"\0\1\2", "away.obj": b"mtllib /etc/passwd\nv 0 0 0\n",
    "points.obj": b"v 0 0 0\nv 1 0 0\n", "mesh.fbx": b"Kaydara", "corner.obj": b"v 0 0 0\nf 1 2 3\n",
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_gets_one_line(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(BAD[name])
    with pytest.raises(SceneError) as caught:
        read_mesh(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value) and len(str(caught.value)) < 450


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="There is no mesh"):
        read_mesh(tmp_path / "none.glb")


def test_sound_files_pass(tmp_path: Path) -> None:
    (tmp_path / "square.glb").write_bytes(glb(tree()))
    assert len(read_mesh(tmp_path / "square.glb").faces) == 2
    (tmp_path / "picture.glb").write_bytes(with_picture(8192, 8192))
    refuse_broken(tmp_path / "picture.glb")


@pytest.mark.parametrize("write", [write_ply, write_stl])
def test_a_file_cut_anywhere_gets_one_line(tmp_path: Path, write) -> None:
    raw = write(tmp_path / f"whole.{write.__name__[-3:]}", room(cells=1)).read_bytes()
    for length in np.linspace(1, len(raw) - 1, 25).astype(int).tolist():
        path = tmp_path / f"cut.{write.__name__[-3:]}"
        path.write_bytes(raw[:length])
        with pytest.raises(SceneError) as caught:
            read_mesh(path)
        assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_flipped_bytes_are_answered_or_read(tmp_path: Path) -> None:
    rng, raw = np.random.default_rng(0), np.frombuffer(glb(tree()), np.uint8)
    path = tmp_path / "flipped.glb"
    for _ in range(400):
        changed = raw.copy()
        changed[rng.integers(0, len(raw), 3)] = rng.integers(0, 256, 3)
        path.write_bytes(changed.tobytes())
        try:
            assert len(read_mesh(path).faces) >= 1
        except SceneError as error:
            assert "\n" not in str(error)
