"""A scene from the keywords of gymnasium.make and make_vec; error messages name the keywords."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields
from inspect import signature
from typing import Any

from curionav_cli.constants import IMAGE_SIDE
from curionav_cli.errors import UserError
from curionav_cli.world.render.optics import check_side
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain
from curionav_cli.world.scene.scene_format import hint
from curionav_cli.world.settings import Env, Scan

SETTINGS = [field.name for field in fields(Env)]
SCAN_SETTINGS = [field.name for field in fields(Scan)]


def build_scene(maker: Callable[..., Any], scene: str, settings: dict[str, Any]) -> tuple[Scene, str]:
    """Build the scene conf/env/<scene>.yaml with these settings, keywords of `maker`; returns it and its engine.

    Raises TypeError for an unknown keyword, in Python's words, because some trainers try a keyword and match the
    message; SceneError or MapError for a scene that cannot be built.
    """
    known = SCAN_SETTINGS if "mesh" in plain(scene)[0] else SETTINGS
    for key in settings:
        if key not in known:
            own = [*signature(maker).parameters][1:-1]
            raise TypeError(f"make() got an unexpected keyword argument {key!r}. {hint(key, [*own, *known])}")
    try:
        raw, source = plain(scene, **settings)
        return Scene.from_dict(raw, source), raw.get("engine", "numpy")
    except UserError as error:
        raise type(error)(as_keywords(str(error))) from None


def check_size(size: object, engine: str) -> int:
    """The side of the images, size=, in pixels. Raises ValueError for one that the engine does not draw."""
    side = check_side(size)
    if side != IMAGE_SIDE and engine == "numba":
        raise ValueError(f"engine='numba' draws images of {IMAGE_SIDE} x {IMAGE_SIDE} pixels, not size={side}. Leave "
                         "engine= out.")
    return side


def as_keywords(message: str) -> str:
    """Rewrite settings of the command line as keywords of Python: env.map=PATH.yaml as map='PATH.yaml'."""
    message = re.sub(r"(?<![\w./])env\.(\w+)=(PATH\.yaml|FILE\.glb|numpy|numba)", r"\1='\2'", message)
    return re.sub(r"(?<![\w./])env\.(\w+)", r"\1", message)
