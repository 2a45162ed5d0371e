"""curionav coverage RUN: three marking rules, two denominators, from the poses of a finished run."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import cover
from curionav_cli.storage.run_folder import RunFolder


@pytest.fixture
def a_run(cli: Cli, tmp_path: Path) -> Path:
    assert cli("explore", "agent=bounce", "loop.steps=40", "loop.episodes=2", "hydra.run.dir=run").code == 0
    return tmp_path / "run"


def test_every_rule_and_denominator_has_a_row_and_pictures(cli: Cli, a_run: Path) -> None:
    answer = cli("coverage", "run")
    assert answer.code == 0, answer.error
    folder = RunFolder(a_run)
    shares = {}
    for rule in ("landing", "swept", "footprint"):
        for denominator in ("visitable", "floor"):
            counted = cover(FloorPlan.load(a_run / "plan.npz"), folder.poses(), rule, denominator)
            line = next(line for line in answer.out.splitlines() if rule in line and f" {denominator} " in line)
            assert f"{counted.share:.1%}" in line and f" {counted.total} " in line
            shares[rule, denominator] = counted.share
            for kind in ("heatmap", "coverage"):
                assert (a_run / "figures" / f"{kind}_{rule}_{denominator}.png").stat().st_size > 3000
    assert shares["landing", "visitable"] < shares["swept", "visitable"] < shares["footprint", "visitable"]
    assert shares["landing", "floor"] < shares["landing", "visitable"]


def test_one_rule_can_be_asked_for(cli: Cli, a_run: Path) -> None:
    answer = cli("coverage", "run", "marking=swept", "denominator=floor")
    assert answer.code == 0 and "landing" not in answer.out and "swept" in answer.out
    assert sorted(path.name for path in (a_run / "figures").glob("*_*.png")) == [
        "coverage_swept_floor.png", "heatmap_swept_floor.png"]


@pytest.mark.parametrize(("words", "said"), [
    ((), "Name the folder of a run or a sweep"), (("nowhere",), "There is no folder nowhere"),
    (("run", "marking=swepd"), "Did you mean swept?"), (("run", "color=red"), "coverage has no setting color"),
    ((".",), "holds no run"),
])
def test_wrong_words_have_one_clear_line(cli: Cli, words: tuple[str, ...], said: str) -> None:
    answer = cli("coverage", *words)
    assert answer.code == 2 and said in answer.error and len(answer.error.strip().splitlines()) == 1
