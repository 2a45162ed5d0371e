#!/usr/bin/env bash
# One would guess that coherent rays of a camera are traced faster in packets of 16 (rtcIntersect16) than one by one, as the package
# does. In a room of a million triangles, of which each of 64 x 64 rays meets another one, packets called through ctypes take longer
# than embreex's own loop over rtcIntersect1, calls from Python included. embreex 4.4.0.post1 (Embree 4.4), AVX-512, 2026-11-30.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check embreex==4.4.0.post1 numpy==2.4.6

cat > packets.py <<'EOP'
import ctypes
import time
from importlib.metadata import files, version

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

SIDE, PACKET, FRAMES, FIELDS = 290, 16, 60, 22
extent, rng = np.array([8.0, 6.0, 2.5]), np.random.default_rng(0)
places, corners = [], []
for first, second, across in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
    for far in (0.0, 1.0):
        at = np.zeros((SIDE, SIDE, 3))
        at[..., first], at[..., second] = np.meshgrid(np.linspace(0, extent[first], SIDE), np.linspace(0, extent[second], SIDE))
        at[..., across] = far * extent[across] + rng.normal(0, 0.004, (SIDE, SIDE))
        n = np.arange(SIDE * SIDE).reshape(SIDE, SIDE) + len(places) * SIDE * SIDE
        corners += [np.stack(three, -1).reshape(-1, 3) for three in ((n[:-1, :-1], n[1:, :-1], n[1:, 1:]), (n[:-1, :-1], n[1:, 1:], n[:-1, 1:]))]
        places.append(at.reshape(-1, 3))
vertices = np.concatenate([*places, np.zeros((2, 3))]).astype(np.float32)  # Embree reads 16 bytes at the last vertex
faces = np.concatenate(corners).astype(np.int32)
offset = 0.82 * ((np.arange(64) + 0.5) / 32 - 1)
way = np.ones((64, 64, 3), np.float32)
way[..., 1], way[..., 2] = -offset, -offset[:, None]
flat, start = np.ascontiguousarray(way.reshape(-1, 3)), np.tile(np.float32([4, 3, 0.45]), (4096, 1))
single = EmbreeScene()
kept = TriangleMesh(single, vertices[:-2], faces)

library = ctypes.CDLL(str(next(file for file in files("embreex") if "libembree4" in file.name).locate()))
P, I, N = ctypes.c_void_p, ctypes.c_int, ctypes.c_size_t


def bound(name, result, *arguments):
    function = getattr(library, name)
    function.restype, function.argtypes = result, arguments
    return function


device = bound("rtcNewDevice", P, ctypes.c_char_p)(b"threads=1")
scene, geometry = bound("rtcNewScene", P, P)(device), bound("rtcNewGeometry", P, P, I)(device, 0)
share = bound("rtcSetSharedGeometryBuffer", None, P, I, ctypes.c_uint, I, P, N, N, N)
share(geometry, 0, 0, 0x5003, faces.ctypes.data, 0, 12, len(faces))
share(geometry, 1, 0, 0x9003, vertices.ctypes.data, 0, 12, len(vertices) - 2)
bound("rtcCommitGeometry", None, P)(geometry)
bound("rtcAttachGeometry", ctypes.c_uint, P, P)(scene, geometry)
bound("rtcCommitScene", None, P)(scene)
trace = bound("rtcIntersect16", None, P, P, P, P)


def aligned(shape, kind):
    size = int(np.prod(shape)) * np.dtype(kind).itemsize
    raw = np.zeros(size + 64, np.uint8)
    first = -raw.ctypes.data % 64
    return raw[first:first + size].view(kind).reshape(shape)


packets = aligned((4096 // PACKET, FIELDS, PACKET), np.float32)
words, valid, options = packets.view(np.uint32), aligned((PACKET,), np.int32), aligned((16,), np.uint32)
valid[:], options[0], options[1] = -1, 1 << 16, 0xFFFFFFFF  # coherent, all features
tiles = way.reshape(16, 4, 16, 4, 3).transpose(0, 2, 4, 1, 3).reshape(-1, 3, PACKET)
addresses = [packets.ctypes.data + number * FIELDS * PACKET * 4 for number in range(len(packets))]


def frame():
    packets[:, 0], packets[:, 1], packets[:, 2], packets[:, 3] = 4, 3, 0.45, 0
    packets[:, 4:7], packets[:, 7], packets[:, 8] = tiles, 0, np.inf
    words[:, 9], words[:, 11], words[:, 17:19] = 0xFFFFFFFF, 0, 0xFFFFFFFF
    for address in addresses:
        trace(valid.ctypes.data, scene, address, options.ctypes.data)


def rate(draw):
    began = time.process_time()
    for _ in range(FRAMES):
        draw()
    return FRAMES / (time.process_time() - began)


frame()
far = packets[:, 8].reshape(16, 16, 4, 4).transpose(0, 2, 1, 3).reshape(-1)
same = np.isclose(far, single.run(start, flat, output=True)["tfar"], atol=1e-3).mean()
ones, sixteens = (np.median([rate(draw) for _ in range(5)]) for draw in (lambda: single.run(start, flat, output=True), frame))
print(f"embreex {version('embreex')}, {len(faces):,} triangles: {ones:.0f} frames a CPU-second ray by ray, {sixteens:.0f} in packets "
      f"of {PACKET}; {same:.2%} of the depths agree")
assert same > 0.99 and sixteens < ones
EOP
OMP_NUM_THREADS=1 env/bin/python packets.py
