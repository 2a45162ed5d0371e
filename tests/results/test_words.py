"""Numbers and labels as a person expects them: small shares, whole minutes, all columns in a file, names of files."""

from __future__ import annotations

import io
import json
from dataclasses import asdict
from pathlib import Path

import pytest
from rich.console import Console

from curionav_cli.commands.summary import print_columns
from curionav_cli.execution.progress import duration
from curionav_cli.files import file_name
from curionav_cli.records import DockReport
from curionav_cli.results import docking_plots
from curionav_cli.results.docking import counted
from curionav_cli.results.statistics import Estimate
from curionav_cli.results.tables import cells, percent
from curionav_cli.storage.run_folder import RunFolder

REPORT = DockReport("charge_not_found", "", True, 0, (), 60.0, 2.0, 1.0, 0.5)


@pytest.mark.parametrize(("share", "said"), [
    (263 / 700_000, "0.038%"), (1 / 4_000_000, "0.000025%"), (0.0, "0.0%"), (0.0006, "0.1%"), (0.454, "45.4%"),
    (0.9996, "99.9%"), (1.0, "100.0%"), (-0.02, "-2.0%")])
def test_a_share_of_something_is_never_nothing_nor_all(share: float, said: str) -> None:
    assert percent(share) == said
    assert cells({"coverage": share}, [("coverage", "coverage", "{:.1%}")]) == [said]
    assert f"{Estimate(share, share, share):.1%}" == f"{said} [{said[:-1]}, {said[:-1]}]"


@pytest.mark.parametrize(("seconds", "said"), [
    (2819.7, "47 min 00 s"), (59.4, "0 min 59 s"), (59.6, "1 min 00 s"), (3599.8, "1 h 00 min"),
    (11_220, "3 h 07 min")])
def test_minutes_have_sixty_seconds(seconds: float, said: str) -> None:
    assert duration(seconds) == said


COLUMNS = [(f"heading {number:02}", f"key_{number}", "{}") for number in range(30)]


def printed(width: int, terminal: bool, count: int) -> str:
    console = Console(file=io.StringIO(), width=width, force_terminal=terminal, color_system=None)
    shown = [heading for heading, _, _ in COLUMNS[:count]]
    print_columns([{key: "地図" for _, key, _ in COLUMNS}], COLUMNS, console, shown)
    return console.file.getvalue()  # type: ignore[attr-defined]


def test_a_file_gets_every_column_and_a_terminal_a_line_about_those_left_out() -> None:
    whole = printed(140, False, 30)
    assert "heading 29" in whole and "wider" not in whole and len(whole.strip().splitlines()) == 3
    assert "20 more columns need a wider terminal." in printed(130, True, 30)
    assert "1 more column needs a wider terminal." in printed(130, True, 11)


def test_names_of_files_keep_letters_and_stay_short_enough_for_a_disk() -> None:
    assert file_name("north/plan, seed 0") == "north_plan_seed_0" and file_name("地図") != file_name("部屋")
    names = {file_name("x" * 200 + end) for end in "ab"} | {file_name("地" * 200)}
    assert len(names) == 3 and max(len(name.encode()) for name in names) < 140


def test_without_an_arrival_at_the_dock_there_is_no_legend() -> None:
    axes = docking_plots.arrivals([REPORT], 30.0, 2.0, 0.18, "0 of 1 docked").axes[0]
    assert axes.get_legend() is None and axes.get_title() == "0 of 1 docked"


def test_returns_to_dock_in_two_maps_of_one_name_are_named_by_their_folders(tmp_path: Path, a_plan) -> None:
    """fixed.json holds the cells of a map and not its path."""
    runs = []
    for where in ("north", "south"):
        run = RunFolder(tmp_path / where)
        config = {"seed": 0, "scale": "cpu", "agent": {"name": "bounce"}, "robot": {"name": "turtlebot2i"},
                  "env": {"name": "map", "map": f"/data/{where}/office.yaml"}}
        fixed = {"env": {"name": "map"}, "agent": config["agent"], "robot": config["robot"], "loop": {"steps": 5},
                 "seed": 0, "visitable cells (sha256)": where}
        run.create(json.dumps(config), fixed, {}, a_plan())
        run.append_metrics({"episode": 0, **asdict(REPORT)})
        runs.append(run)
    each, _ = counted(runs)
    assert [one.where["env"] for one in each] == ["north/office", "south/office"]
