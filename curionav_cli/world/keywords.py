"""A world from the keywords of gymnasium.make and make_vec; faults are told in the words of keywords."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields
from inspect import signature
from typing import Any

from curionav_cli.errors import UserError
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain
from curionav_cli.world.scene.scene_format import hint
from curionav_cli.world.settings import Env

SETTINGS = [field.name for field in fields(Env)]


def built(maker: Callable[..., Any], scene: str, settings: dict[str, Any]) -> tuple[Scene, str]:
    """The scene conf/env/<scene>.yaml with these settings, of those that maker was called with, and its engine.

    Raises TypeError for a keyword that is none, with Python's words, because some trainers try a keyword and go by
    them; SceneError or MapError for a world that cannot be.
    """
    for key in settings:
        if key not in SETTINGS:
            own = [*signature(maker).parameters][1:-1]
            raise TypeError(f"make() got an unexpected keyword argument {key!r}. {hint(key, [*own, *SETTINGS])}")
    try:
        raw, source = plain(scene, **settings)
        return Scene.from_dict(raw, source), raw.get("engine", "numpy")
    except UserError as error:
        raise type(error)(as_keywords(str(error))) from None


def as_keywords(words: str) -> str:
    """'env.map=PATH.yaml', as it is typed at a prompt, is map='PATH.yaml' in Python."""
    words = re.sub(r"(?<![\w./])env\.(\w+)=(PATH\.yaml|numpy|numba)", r"\1='\2'", words)
    return re.sub(r"(?<![\w./])env\.(\w+)", r"\1", words)
