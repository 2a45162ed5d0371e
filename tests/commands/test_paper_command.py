"""curionav paper: tables from configs and scenes; the paper's numbers beside those of a run, counted again here."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from entry import Cli

from curionav_cli.commands import diagram
from curionav_cli.config.compose import composed
from curionav_cli.results import docking_diagram
from curionav_cli.results.docking_diagram import PLACES
from curionav_cli.results.page_blocks import block
from curionav_cli.robot.docking.action import Phase

ROOT = Path(__file__).resolve().parents[2]


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def test_hyperparameters_come_from_the_configs(cli: Cli, tmp_path: Path) -> None:
    answer = cli("paper", "hyperparameters", "out=out")
    assert answer.code == 0, answer.error
    found = rows(tmp_path / "out" / "hyperparameters.csv")
    assert len(found) == 21 and all(float(row["paper"]) == float(row["ours"]) for row in found)
    small = (ROOT / "conf" / "scale" / "lbs_dreamer" / "cpu.yaml").read_text()
    written = dict(re.findall(r"^(\w+): ([\d.e-]+)", small, re.M))
    assert {row["key"][6:]: float(row["cpu"]) for row in found if row["key"][6:] in written} == {
        key: float(value) for key, value in written.items() if f"agent.{key}" in {row["key"] for row in found}}
    assert "\\toprule" in (tmp_path / "out" / "hyperparameters.tex").read_text()


def test_sizes_are_those_of_the_papers_table(cli: Cli, tmp_path: Path) -> None:
    assert cli("paper", "sizes", "out=out").code == 0
    homes = [row for row in rows(tmp_path / "out" / "sizes.csv") if row["env"].startswith("apartment")]
    assert [int(row["cells"]) for row in homes] == [23476, 21328, 18123]
    assert all(round(float(row["area"]), 2) == pytest.approx(float(row["paper_area"]), abs=0.011) for row in homes)


def test_numbers_are_counted_from_the_run_and_name_it(cli: Cli, tmp_path: Path) -> None:
    words = ("agent=bounce", "robot=turtlebot2i", "loop.steps=40", "loop.episodes=3", "hydra.run.dir=runs/run")
    assert cli("explore", *words).code == 0
    answer = cli("paper", "numbers", "runs/run", "nowhere", "out=out")
    assert answer.code == 0 and "There is no folder nowhere." in answer.out, answer.error
    page = (tmp_path / "out" / "paper-vs-ours.md").read_text()
    share = json.loads((tmp_path / "runs" / "run" / "status.json").read_text())["coverage"]
    assert f"| {share:.1%} after 120 steps | 1 | runs |" in page
    docks = [json.loads(str(np.load(path)["dock"])) for path in sorted((tmp_path / "runs").rglob("0*.npz"))]
    came = [dock["code"] == "docked" and not dock["human"] for dock in docks if dock]
    assert len(came) == 2 and f"| 572 of 596 (96 %) | {sum(came)} of 2: " in page
    assert "| 23,476 | 23,476 |" in page and "There is no folder nowhere." in page and "fewer than 5 seeds" in page


def test_runs_of_dock_are_counted_too(cli: Cli, tmp_path: Path) -> None:
    words = ("env=small_room", "loop.steps=20", "dock.requests=2", "hydra.run.dir=runs/dock")
    assert cli("dock", *words).code == 0
    (tmp_path / "out").mkdir()
    written = block("figures", "verdicts", "| 60 % of the lab | seen |")
    (tmp_path / "out" / "paper-vs-ours.md").write_text(f"# Old\n\n{written}\n")
    assert cli("paper", "numbers", "runs", "out=out").code == 0
    assert (page := (tmp_path / "out" / "paper-vs-ours.md").read_text()).count(written) == 1 and "# Old" not in page
    rows = [json.loads(line) for line in (tmp_path / "runs" / "dock" / "metrics.jsonl").read_text().splitlines()]
    docked = sum(row["code"] == "docked" for row in rows)
    assert f"| {docked} of 2: " in (tmp_path / "out" / "paper-vs-ours.md").read_text()


def test_the_diagram_has_every_phase_and_what_was_passed_through(tmp_path: Path) -> None:
    assert set(PLACES) == {phase.value for phase in Phase}
    room = composed("explore", "env=small_room", "agent=bounce", "robot=turtlebot2i", "loop.steps=20")
    moves = diagram.watched(room, 2)
    assert moves["idle", "nav_to_staging"] == 2
    assert sum(count for (_, after), count in moves.items() if after in ("docked", "human_intervention")) == 2
    drawn = docking_diagram.diagram(moves, ["rescan"], ["cancelled"], "two").axes[0]
    words = [text.get_text().replace("\n", "_") for text in drawn.texts]
    assert {phase.value for phase in Phase} <= set(words) and "2" in words


@pytest.mark.parametrize(("words", "said"), [
    ((), "paper: name one of hyperparameters, sizes, docking, numbers"), (("size",), "Did you mean sizes?"),
    (("sizes", "run"), "reads no runs"), (("numbers", "colour=red"), "paper has no setting colour"),
    (("numbers", "page=README.md"), "has no page="), (("changes", "page=README.md"), "No such file or directory"),
])
def test_wrong_words_have_one_clear_line(cli: Cli, words: tuple[str, ...], said: str) -> None:
    answer = cli("paper", *words)
    assert answer.code == 2 and said in answer.error and len(answer.error.strip().splitlines()) == 1


def test_folders_without_a_run_are_refused_and_a_page_stays_what_it_was(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "paper-vs-ours.md").write_text("mine")
    answer = cli("paper", "numbers", "nowhere", "out=out")
    assert answer.code == 2 and "There is no folder nowhere." in answer.error and "Traceback" not in answer.error
    assert (tmp_path / "out" / "paper-vs-ours.md").read_text() == "mine"


def test_returns_to_dock_are_counted_over_the_runs_that_had_any(cli: Cli, tmp_path: Path) -> None:
    short = ("env=small_room", "loop.steps=50", "loop.episodes=1")
    for agent in ("bounce", "cbet"):
        assert cli("explore", *short, f"agent={agent}", f"hydra.run.dir=runs/{agent}").code == 0
    assert cli("dock", "env=small_room", "loop.steps=20", "dock.requests=2", "hydra.run.dir=home").code == 0
    assert cli("dock", "env=small_room", "robot=turtlebot2i_plus", "loop.steps=20", "dock.requests=1",
               "hydra.run.dir=better").code == 0
    answer = cli("paper", "numbers", "runs", "home", "better", "out=out")
    assert answer.code == 0, answer.error
    rows = [line.split(" | ") for line in (tmp_path / "out" / "paper-vs-ours.md").read_text().splitlines()]
    docked = next(row for row in rows if row[1:] and row[1] == "auto docking, small_room")
    assert " of 2: " in docked[3] and docked[4] == "1 run" and "runs/" not in docked[5]
    theirs = next(row for row in rows if row[1:] and row[1] == "coverage, small_room, cbet")
    assert theirs[2] == "nothing"  # the paper has C-BET in the apartments only
