"""Rays into a mesh: Embree by the package embreex, from the extra `scan`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.mesh import Mesh

FARTHEST = np.float32(1e4)  # metres; a ray that meets nothing ends here


class Hits(NamedTuple):
    """Where N rays end. face (N,) int32, -1 for none; far (N,) float32 in lengths of the direction; u, v (N,) float32
    weights of the triangle's second and third corner; cross (N, 3) float32, its normal, twice as long as its area."""

    face: np.ndarray
    far: np.ndarray
    u: np.ndarray
    v: np.ndarray
    cross: np.ndarray


class Tracer:
    """The tree of a mesh's triangles. Raises SceneError where embreex is not installed."""

    def __init__(self, mesh: Mesh):
        self._scene = _embree_scene()
        self._tree = _triangles()(self._scene, mesh.vertices, mesh.faces)  # kept: the scene goes on reading it

    def cast(self, origins: np.ndarray, directions: np.ndarray) -> Hits:
        """The nearest hits of rays; origins, directions (N, 3) float32."""
        found = self._scene.run(np.ascontiguousarray(origins), np.ascontiguousarray(directions), output=True)
        face = found["primID"]
        return Hits(face, np.where(face < 0, FARTHEST, found["tfar"]), found["u"], found["v"], found["Ng"])


def extra(error: ImportError) -> SceneError:
    """What to install where a package of the extra is missing."""
    return SceneError(f"env=scan needs {error.name}, which is not installed: pip install 'curionav[scan]', or in a "
                      "checkout: .venv/bin/pip install -c constraints.txt -e '.[scan]'")


def _embree_scene():
    try:
        from embreex.rtcore_scene import EmbreeScene
    except ImportError as error:
        raise extra(error) from None
    return EmbreeScene()


def _triangles():
    from embreex.mesh_construction import TriangleMesh

    return TriangleMesh
