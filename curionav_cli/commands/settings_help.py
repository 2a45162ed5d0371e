"""--help of a command with settings: Typer's page, then the groups and every setting with its default."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

from rich.console import Console
from rich.panel import Panel
from rich.table import Table
from typer.core import TyperCommand

CHOSEN = {"dock": ("agent=bounce", "robot=turtlebot2i")}  # where a command's defaults are others


class Part(StrEnum):
    """Which part of the composed configuration --cfg prints."""

    job = "job"
    hydra = "hydra"
    all = "all"


class Kind(StrEnum):
    """What --info prints of how the configuration came about."""

    all = "all"
    config = "config"
    defaults = "defaults"
    tree = "defaults-tree"
    plugins = "plugins"
    searchpath = "searchpath"


class SettingsCommand(TyperCommand):
    """A command whose arguments are settings; its help shows them. --info alone means --info all."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        super().format_help(ctx, formatter)
        from curionav_cli.config import listing
        from curionav_cli.config.sources import opened

        with opened(str(self.name)) as hydra:
            groups, settings = listing.groups(hydra), listing.settings(hydra, list(CHOSEN.get(str(self.name), ())))
        console = Console()
        console.print(panel("Choices (env=..., agent=...; * is the default)", group_rows(groups, settings)))
        console.print(panel("Settings (seed=1, loop.episodes=50)", setting_rows(groups, settings)))

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        spelled = list(args)
        for index, word in enumerate(args):
            if word == "--info" and (index + 1 == len(args) or args[index + 1] not in list(Kind)):
                spelled[index] = "--info=all"
        return super().parse_args(ctx, spelled)


def group_rows(groups: dict[str, list[str]], settings: dict[str, Any]) -> list[tuple[str, str]]:
    """(env, '*small_room, map, ...'): each group and its options."""
    rows = []
    for group, options in groups.items():
        chosen = settings.get(f"{group}.name", settings.get(group))
        rows.append((group, ", ".join(f"*{option}" if option == chosen else option for option in options)))
    return rows


def setting_rows(groups: dict[str, list[str]], settings: dict[str, Any]) -> list[tuple[str, str]]:
    """(loop.steps, '500'): each key and its default; the lists of a scene are only counted."""
    keys = (key for key in settings if key not in groups and key.rpartition(".")[2] != "name")
    return [(key, brief(settings[key])) for key in keys]


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
