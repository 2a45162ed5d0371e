"""curionav export env=...: one of our worlds as a mesh, for Blender, for other simulators, and for env=scan."""

from __future__ import annotations

import shlex
from pathlib import Path

from curionav_cli import build
from curionav_cli.commands.arguments import choice
from curionav_cli.commands.summary import print_next
from curionav_cli.config.compose import composed
from curionav_cli.errors import ConfigError
from curionav_cli.execution.screen import a_console
from curionav_cli.places import place

CHOICES: dict[str, tuple[str, ...]] = {"to": ("glb",), "episode": (), "out": ()}


def run(words: list[str]) -> int:
    """Write the mesh of a world; returns the exit code.

    Raises UserError where there is no such world, or a file would be overwritten.
    """
    from curionav_cli.world.scan.export import export

    own = [word for word in words if word.partition("=")[0] in CHOICES]
    chosen = {"to": "glb", "episode": "0", **dict(choice("export", word, CHOICES) for word in own)}
    if folder := next((word for word in words if "=" not in word), None):
        raise ConfigError(f"--to glb writes a world, and {folder} is no setting of one. Name it, as in: "
                          "curionav export env=small_room --to glb")
    settings = composed("explore", *(word for word in words if word not in own))
    world = build.scene(settings)
    path = place(chosen.get("out", f"{world.name}.{chosen['to']}"))
    if path.suffix.lower() != ".glb":
        raise ConfigError(f"out={path}: the file's name must end in .glb, by which others know what it is.")
    if path.exists():
        raise ConfigError(f"{path} exists already. Name another file with out=FILE.glb, or remove it first.")
    now, _ = world.at(episode_of(chosen["episode"]), settings.seed)
    path.parent.mkdir(parents=True, exist_ok=True)
    count = export(now, path)
    console = a_console()
    console.print(f"{path}: {count:,} triangles, {path.stat().st_size / 1e6:.1f} MB", soft_wrap=True, highlight=False)
    print_next(console, [reopened(path, now.plan.cell, now.plan.radius)])
    return 0


def episode_of(text: str) -> int:
    """The number of an episode. Raises ConfigError."""
    if not text.isdecimal() or len(text) > 9:
        raise ConfigError(f"episode: {text!r} is not the number of an episode; the first is 0.")
    return int(text)


def reopened(path: Path, cell: float, radius: float) -> str:
    """The command that draws the file as a scan."""
    return f"curionav sheet env=scan env.mesh={shlex.quote(str(path))} env.cell={cell:g} env.radius={radius:g}"
