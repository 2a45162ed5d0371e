"""Writing GLB: rectangles with pictures on them, as one file that Blender and trimesh open."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any, NamedTuple

import cv2
import numpy as np

JSON, BIN = 0x4E4F534A, 0x004E4942
FLOAT, UNSIGNED = 5126, 5125
VERTEX_BUFFER, INDEX_BUFFER = 34962, 34963
REPEAT, NEAREST, NEAREST_MIPMAP = 10497, 9728, 9986
DISPLAY = 2.2  # glTF multiplies light, and pictures hold its root
TO_Y_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


class Quads(NamedTuple):
    """n rectangles that share a picture and a light. corners (n, 4, 3) metres, z up, anticlockwise as seen from
    outside; uv (n, 4, 2) float, v upwards."""

    name: str
    picture: str
    light: float
    corners: np.ndarray
    uv: np.ndarray


@dataclass
class GlbWriter:
    """Collects the parts of a file; `bytes_of` makes the file."""

    pictures: dict[str, np.ndarray]

    def __post_init__(self) -> None:
        self._body = bytearray()
        self._tree: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "curionav"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [],
            "meshes": [], "materials": [], "textures": [], "images": [], "accessors": [], "bufferViews": [],
            "samplers": [{"magFilter": NEAREST, "minFilter": NEAREST_MIPMAP, "wrapS": REPEAT, "wrapT": REPEAT}],
            "extensionsUsed": ["KHR_materials_unlit"],
        }
        self._texture_of: dict[str, int] = {}

    def add(self, node: str, parts: list[Quads]) -> None:
        """Add one object of several parts."""
        number = len(self._tree["meshes"])
        self._tree["meshes"].append({"name": node, "primitives": [self._primitive(part) for part in parts]})
        self._tree["nodes"].append({"name": node, "mesh": number})
        self._tree["scenes"][0]["nodes"].append(number)

    def bytes_of(self) -> bytes:
        """The file."""
        self._tree["buffers"] = [{"byteLength": len(self._body)}]
        text = json.dumps(self._tree, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), JSON) + text + struct.pack("<II", len(self._body), BIN) + self._body
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def _primitive(self, part: Quads) -> dict[str, Any]:
        count = len(part.corners)
        places = (part.corners.reshape(-1, 3) @ TO_Y_UP.T).astype("<f4")
        flipped = np.stack([part.uv[..., 0], 1.0 - part.uv[..., 1]], axis=-1).reshape(-1, 2).astype("<f4")
        index = (4 * np.arange(count)[:, None] + [0, 1, 2, 0, 2, 3]).astype("<u4").ravel()
        bounds = {"min": places.min(axis=0).tolist(), "max": places.max(axis=0).tolist()}
        return {"attributes": {"POSITION": self._accessor(places, "VEC3", FLOAT, VERTEX_BUFFER, **bounds),
                               "TEXCOORD_0": self._accessor(flipped, "VEC2", FLOAT, VERTEX_BUFFER)},
                "indices": self._accessor(index, "SCALAR", UNSIGNED, INDEX_BUFFER), "material": self._material(part)}

    def _accessor(self, array: np.ndarray, kind: str, component: int, target: int, **bounds: Any) -> int:
        view = self._view(array.tobytes(), target=target)
        self._tree["accessors"].append({"bufferView": view, "componentType": component, "count": len(array),
                                        "type": kind, **bounds})
        return len(self._tree["accessors"]) - 1

    def _view(self, raw: bytes, **more: int) -> int:
        self._tree["bufferViews"].append({"buffer": 0, "byteOffset": len(self._body), "byteLength": len(raw), **more})
        self._body += raw + b"\0" * (-len(raw) % 4)
        return len(self._tree["bufferViews"]) - 1

    def _material(self, part: Quads) -> int:
        light, picture = part.light ** DISPLAY, {"index": self._texture(part.picture)}
        self._tree["materials"].append({
            "name": part.name, "doubleSided": True, "extensions": {"KHR_materials_unlit": {}},
            "pbrMetallicRoughness": {"baseColorFactor": [light, light, light, 1.0], "metallicFactor": 0.0,
                                     "roughnessFactor": 1.0, "baseColorTexture": picture},
        })
        return len(self._tree["materials"]) - 1

    def _texture(self, name: str) -> int:
        if name not in self._texture_of:
            _, raw = cv2.imencode(".png", self.pictures[name][..., ::-1])
            view = self._view(raw.tobytes())
            self._tree["images"].append({"name": name, "mimeType": "image/png", "bufferView": view})
            number = len(self._tree["images"]) - 1
            self._tree["textures"].append({"source": number, "sampler": 0})
            self._texture_of[name] = len(self._tree["textures"]) - 1
        return self._texture_of[name]
