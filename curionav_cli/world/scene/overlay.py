"""Overlays of ROS maps: env.overlay=PATH, a file with the lists of a scene file for what a 2-D map does not hold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import yaml

from curionav_cli.errors import SceneError
from curionav_cli.safe_yaml import refuse_bomb
from curionav_cli.world.scene.scene_format import refuse_unknown
from curionav_cli.world.settings import Env

KEYS = ("note", "start", "dock", "rooms", "walls", "solids", "posters", "lamps", "furniture", "repeat", "light",
        "moves")


def overlaid(env: Env, source: str) -> tuple[Env, str]:
    """Add the overlay's lists to the settings; returns them and the name of the file that holds the lists.

    Settings of the command line or the scene file take precedence. Raises SceneError.
    """
    if not env.overlay:
        return env, source
    if not env.map:
        raise SceneError(f"{source}: overlay adds to a ROS map (env.map=PATH.yaml), and this scene opens none.")
    path = Path(env.overlay).expanduser()
    if not path.is_file():
        raise SceneError(f"There is no overlay {path}. env.overlay is the path of a YAML file.")
    try:
        text = path.read_text(encoding="utf-8")
        refuse_bomb(text)
        raw = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError) as error:
        where = getattr(error, "problem_mark", None)
        line = f" in line {where.line + 1}" if where else ""
        raise SceneError(f"{path} is not YAML{line}, so it is no overlay.") from None
    if not isinstance(raw, dict):
        raise SceneError(f"{path} is no overlay: it must hold keys, as posters: or rooms:")
    refuse_unknown(raw, KEYS, str(path), "an overlay")
    return replace(env, **{key: raw[key] for key in raw if key == "note" or not getattr(env, key)}), str(path)
