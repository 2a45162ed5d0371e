"""curionav export: episodes of runs as ROS 2 bags (--to mcap), what runs covered (--to summary), or a world
as a mesh (--to glb)."""

from __future__ import annotations

from curionav_cli.commands import export_bags, export_summary, export_world
from curionav_cli.commands.arguments import choice
from curionav_cli.errors import ConfigError

CHOICES: dict[str, tuple[str, ...]] = {**export_world.CHOICES, **export_bags.CHOICES, "to": ("mcap", "summary", "glb")}
WRITERS = {"mcap": export_bags.run, "summary": export_summary.run, "glb": export_world.run}


def run(words: list[str]) -> int:
    """Write what the format holds; returns the exit code. Raises UserError."""
    named = [word for word in words if word.startswith("to=")]
    if not named:
        raise ConfigError("Name the format, as in: curionav export outputs/DATE/RUN --to mcap, or "
                          "--to summary, or: curionav export env=small_room --to glb")
    _, to = choice("export", named[-1], CHOICES)
    return WRITERS[to](words)
