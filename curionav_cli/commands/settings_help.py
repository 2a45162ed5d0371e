"""The --help of a command with settings: Typer's page, then the groups and every setting with its default."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import Any

from rich.console import Console
from rich.panel import Panel
from rich.table import Table
from typer.core import TyperCommand

SETTINGS = "curionav.settings"  # the settings typed beside --help


class Part(StrEnum):
    """Which part of the composed configuration --cfg prints."""

    job = "job"
    hydra = "hydra"
    all = "all"


class Kind(StrEnum):
    """Which part of where the settings come from --info prints."""

    all = "all"
    config = "config"
    defaults = "defaults"
    tree = "defaults-tree"
    plugins = "plugins"
    searchpath = "searchpath"


class SettingsCommand(TyperCommand):
    """A command whose arguments are settings. Its help lists them; with agent=... those of that agent.

    --info alone means --info all.
    """

    def format_help(self, ctx: Any, formatter: Any) -> None:
        super().format_help(ctx, formatter)
        from curionav_cli.config import catalogue
        from curionav_cli.config.sources import COMMAND_DEFAULTS, opened

        with opened(str(self.name)) as hydra:
            chosen = [*COMMAND_DEFAULTS.get(str(self.name), ()), *ctx.meta[SETTINGS]]
            groups, config = catalogue.groups(hydra), catalogue.composed(hydra, chosen)
        settings, choices = catalogue.settings(config), catalogue.choices(config)
        console = Console()
        console.print(panel("Choices (env=..., agent=...; * is the default)", group_rows(groups, settings)))
        rows = setting_rows(groups, settings, choices)
        console.print(panel("Settings (seed=1, loop.episodes=50; * is the default)", rows))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        ctx.meta[SETTINGS] = [word for word in args if "=" in word and not word.startswith("-")]
        spelled = list(args)
        for index, word in enumerate(args):
            if word == "--info" and (index + 1 == len(args) or args[index + 1] not in list(Kind)):
                spelled[index] = "--info=all"
        return super().parse_args(ctx, spelled)


def group_rows(groups: dict[str, list[str]], settings: dict[str, Any]) -> list[tuple[str, str]]:
    """Each group and its options: (env, '*small_room, map, ...')."""
    rows = []
    for group, options in groups.items():
        chosen = settings.get(f"{group}.name", settings.get(group))
        rows.append((group, starred(options, chosen)))
    return rows


def setting_rows(groups: dict[str, list[str]], settings: dict[str, Any],
                 choices: dict[str, list[str]]) -> list[tuple[str, str]]:
    """Each key and its value: (loop.steps, '500'), (agent.view, '*pano, ego'); lists of a scene are only counted."""
    keys = (key for key in settings if key not in groups and key.rpartition(".")[2] != "name")
    return [(key, starred(choices[key], settings[key]) if key in choices else brief(settings[key])) for key in keys]


def starred(options: Sequence[str], chosen: Any) -> str:
    return ", ".join(f"*{option}" if option == chosen else option for option in options)


def brief(value: Any) -> str:
    if isinstance(value, list) and any(isinstance(item, dict) for item in value):
        return f"[{len(value)} items]"
    text = "null" if value is None else str(value).lower() if isinstance(value, bool) else str(value)
    return f"{text[:60]}..." if len(text) > 63 else text


def panel(title: str, rows: list[tuple[str, str]]) -> Panel:
    table = Table.grid(padding=(0, 2))
    table.add_column(style="bold cyan", no_wrap=True)
    table.add_column()
    for row in rows:
        table.add_row(*row)
    return Panel(table, title=title, title_align="left", border_style="dim")
