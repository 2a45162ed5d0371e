"""Meshes for the tests of scans: a small building as triangles, written in the formats of scanners."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from PIL import Image

from curionav_cli.world.scan.mesh import AXES


def quad(corner, along, across, cells: int = 1) -> np.ndarray:
    """(n, 3, 3): a rectangle as 2 cells^2 triangles."""
    corner, along, across = (np.array(part, float) for part in (corner, along, across))
    steps = [(corner + (i * along + j * across) / cells) for i in range(cells) for j in range(cells)]
    one, other = along / cells, across / cells
    return np.array([[at, at + one, at + one + other] for at in steps]
                    + [[at, at + one + other, at + other] for at in steps])


def box(low, high) -> np.ndarray:
    """(12, 3, 3): a box without regard to which way its triangles turn."""
    low, (w, d, h) = np.array(low, float), np.array(high, float) - np.array(low, float)
    sides = [((0, 0, 0), (w, 0, 0), (0, 0, h)), ((0, d, 0), (w, 0, 0), (0, 0, h)), ((0, 0, 0), (0, d, 0), (0, 0, h)),
             ((w, 0, 0), (0, d, 0), (0, 0, h)), ((0, 0, 0), (w, 0, 0), (0, d, 0)), ((0, 0, h), (w, 0, 0), (0, d, 0))]
    return np.concatenate([quad(low + np.array(at), along, across) for at, along, across in sides])


def room(z: float = 0.0, width: float = 4.0, depth: float = 3.0, cells: int = 4) -> np.ndarray:
    """(n, 3, 3): floor, four walls and a chest of 1 x 0.6 x 0.8 m in a corner, without a ceiling."""
    walls = [quad((0, 0, z), (width, 0, 0), (0, 0, 2.4)), quad((0, depth, z), (width, 0, 0), (0, 0, 2.4)),
             quad((0, 0, z), (0, depth, 0), (0, 0, 2.4)), quad((width, 0, z), (0, depth, 0), (0, 0, 2.4))]
    floor = quad((0, 0, z), (width, 0, 0), (0, depth, 0), cells)
    return np.concatenate([floor, *walls, box((0, 0, z), (1, 0.6, z + 0.8))])


def y_up(triangles: np.ndarray) -> np.ndarray:
    """The same with y up, as GLB and OBJ have it."""
    return triangles @ np.array(AXES["y"], float)


def write_ply(path: Path, triangles: np.ndarray, colour: tuple[int, int, int] = (200, 40, 40)) -> Path:
    """A binary PLY with colours at its vertices."""
    places = triangles.reshape(-1, 3)
    vertex = np.zeros(len(places), [("place", "<f4", 3), ("colour", "u1", 3)])
    vertex["place"], vertex["colour"] = places, colour
    face = np.zeros(len(triangles), [("count", "u1"), ("corner", "<i4", 3)])
    face["count"], face["corner"] = 3, np.arange(len(places)).reshape(-1, 3)
    names = "".join(f"property float {name}\n" for name in "xyz") + "".join(
        f"property uchar {name}\n" for name in ("red", "green", "blue"))
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n{names}"
            f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(head.encode() + vertex.tobytes() + face.tobytes())
    return path


def write_quads(path: Path, triangles: np.ndarray) -> Path:
    """A binary PLY of faces with four corners, as Replica has them: each triangle with the middle of a side added."""
    a, b, c = triangles.transpose(1, 0, 2)
    places = np.stack([a, b, (b + c) / 2.0, c], axis=1).reshape(-1, 3).astype("<f4")
    face = np.zeros(len(triangles), [("count", "u1"), ("corner", "<i4", 4)])
    face["count"], face["corner"] = 4, np.arange(len(places)).reshape(-1, 4)
    names = "".join(f"property float {name}\n" for name in "xyz")
    head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n{names}"
            f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(head.encode() + places.tobytes() + face.tobytes())
    return path


def write_stl(path: Path, triangles: np.ndarray) -> Path:
    """A binary STL."""
    held = np.zeros(len(triangles), [("normal", "<f4", 3), ("corner", "<f4", (3, 3)), ("more", "<u2")])
    held["corner"] = triangles
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(triangles)) + held.tobytes())
    return path


def write_obj(path: Path, triangles: np.ndarray) -> Path:
    """An OBJ with a colour after each vertex."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f} 0.2 0.4 0.8" for x, y, z in triangles.reshape(-1, 3)]
    lines += [f"f {at + 1} {at + 2} {at + 3}" for at in range(0, 3 * len(triangles), 3)]
    path.write_text("\n".join(lines) + "\n")
    return path


def floor_plan_uv(triangles: np.ndarray) -> np.ndarray:
    """(n, 3, 2): texture coordinates by x and y, a metre for the tenth of a picture."""
    return triangles[..., :2] / 10.0


def write_textured_obj(path: Path, triangles: np.ndarray, side: int = 8) -> Path:
    """An OBJ, y up, with NAME.mtl and NAME.png beside it: red where x is below 5 m, blue beyond; other.png is green."""
    half = np.repeat(np.array([[[220, 30, 30], [30, 30, 220]]], np.uint8), side // 2, axis=1).repeat(side, axis=0)
    Image.fromarray(half).save(path.with_suffix(".png"))
    Image.fromarray(np.full_like(half, (30, 220, 30))).save(path.with_name("other.png"))
    path.with_suffix(".mtl").write_text(f"newmtl paint\nKd 1 1 1\nmap_Kd {path.stem}.png\n")
    places = triangles @ np.array(AXES["y"], float)
    lines = [f"mtllib {path.stem}.mtl", *(f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in places.reshape(-1, 3)),
             *(f"vt {u:.6f} {v:.6f}" for u, v in floor_plan_uv(triangles).reshape(-1, 2)), "usemtl paint",
             *(f"f {at}/{at} {at + 1}/{at + 1} {at + 2}/{at + 2}" for at in range(1, 3 * len(triangles), 3))]
    path.write_text("\n".join(lines) + "\n")
    return path
