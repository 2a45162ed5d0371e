"""curionav compare: real runs into figures and tables, and one line for what is wrong."""

from __future__ import annotations

import csv
import json
import shutil
from base64 import b64encode
from pathlib import Path

import pytest
from entry import Cli
from paint import unpainted

from curionav_cli.app import main
from curionav_cli.results.integrity import noted
from curionav_cli.results.runs import Run
from curionav_cli.storage.run_folder import RunFolder

unseen = pytest.mark.usefixtures("blank_figures")


@pytest.fixture(scope="module")
def explored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    sweep = tmp_path_factory.mktemp("explored") / "sweep"
    words = ("-m", "agent=random,bounce", "seed=0,1", "loop.steps=40", "loop.episodes=2", f"hydra.sweep.dir={sweep}")
    with unpainted(), pytest.raises(SystemExit) as stop:
        main(["explore", *words])
    assert stop.value.code == 0
    return sweep


@pytest.fixture
def a_sweep(explored: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(explored, tmp_path / "sweep"))


@unseen
def test_what_a_run_notes_is_what_its_episodes_hold(cli: Cli, a_sweep: Path) -> None:
    """Also after it went on: compare need not open an episode."""
    longer = a_sweep / "2_small_room_bounce_0"
    assert cli("resume", str(longer), "loop.episodes=4").code == 0
    for path in sorted(a_sweep.glob("[0-9]*")):
        run = Run.open(path)
        recorded = noted(run.folder, run.plan, run.folder.metrics())
        assert recorded is not None and recorded.curve.found.tolist() == run.curve.found.tolist()
        assert (recorded.curve.steps, recorded.curve.total) == (run.curve.steps, run.curve.total)
        assert recorded.ends == run.readable.ends
    assert len(run.folder.metrics()) == 2 and len(RunFolder(longer).metrics()) == 4


@unseen
def test_broken_episodes_of_runs_that_noted_what_they_found_are_named(cli: Cli, a_sweep: Path, tmp_path: Path) -> None:
    cut, flipped = (a_sweep / f"{number}_small_room_{name}" / "episodes" / "000001.npz"
                    for number, name in ((1, "random_1"), (2, "bounce_0")))
    cut.write_bytes(cut.read_bytes()[:-100])
    shutil.rmtree(a_sweep / "3_small_room_bounce_1")  # so that the run with the flipped bytes is the arm's best
    data = bytearray(flipped.read_bytes())
    data[40:-22] = bytes(len(data) - 62)  # all but its end, which shows that it was written whole
    flipped.write_bytes(data)
    answer = cli("compare", "sweep", "out=out")
    assert answer.code == 0, answer.error
    for path in (cut, flipped):
        assert any(line.startswith("GAP") and str(path.relative_to(tmp_path)) in line
                   for line in answer.out.splitlines()), answer.out
    metrics = a_sweep / "0_small_room_random_0" / "metrics.jsonl"
    metrics.unlink()
    assert f"{metrics.relative_to(tmp_path)} is missing" in cli("compare", "sweep", "out=out").out


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


@pytest.mark.usefixtures("painted")
def test_a_sweep_becomes_figures_and_tables_and_the_same_again(cli: Cli, a_sweep: Path, tmp_path: Path) -> None:
    answer = cli("compare", "sweep", "out=one", "baseline=random", "at=20")
    assert answer.code == 0, answer.error
    assert "fewer than 5 seeds" in answer.out and "cells, marked by landing" in answer.out
    [arm, other] = rows(tmp_path / "one" / "arms.csv")
    assert [arm["arm"], other["arm"]] == ["random", "bounce"] and arm["n"] == "2" and arm["steps"] == "80"
    assert float(arm["cpu_seconds"]) > 0 and float(arm["seconds"]) > 0 and arm["updates"] == ""
    runs = rows(tmp_path / "one" / "runs.csv")
    status = [json.loads((Path(row["folder"]) / "status.json").read_text()) for row in runs]
    assert [float(row["coverage"]) for row in runs] == [one["coverage"] for one in status]
    assert float(arm["coverage"]) == pytest.approx(sum(float(row["coverage"]) for row in runs[:2]) / 2)
    [pair, _] = rows(tmp_path / "one" / "pairs.csv")
    assert (pair["arm"], pair["minus"], pair["n"], pair["p"]) == ("bounce", "random", "2", "0.5")
    page = (tmp_path / "one" / "comparison.md").read_text()
    film = (tmp_path / "one" / "figures" / "film.webm").read_bytes()
    assert film[:4] == b"\x1a\x45\xdf\xa3"
    assert b64encode(film).decode() in (tmp_path / "one" / "report.html").read_text()
    assert "curionav compare sweep out=one" in page and "| small_room | bounce | 2 |" in page
    assert cli("compare", "sweep", "out=two", "baseline=random", "at=20").code == 0
    names = sorted(str(path.relative_to(tmp_path / "one")) for path in (tmp_path / "one").rglob("*.*"))
    assert {"figures/small_room.png", "figures/small_room.pdf", "figures/all.png", "comparison.tex",
            "figures/curves.pdf", "figures/heatmaps_small_room.png"} <= set(names)
    for name in names:
        one, two = ((tmp_path / turn / name).read_bytes() for turn in ("one", "two"))
        assert one.replace(b"out=one", b"out=two") == two, name


@unseen
def test_without_a_folder_named_it_goes_where_runs_go(cli: Cli, a_sweep: Path, tmp_path: Path) -> None:
    answer = cli("compare", *map(str, sorted(a_sweep.glob("[0-9]*"))), "denominator=floor", "marking=swept")
    assert answer.code == 0 and "floor cells, marked by swept" in answer.out
    [folder] = (tmp_path / "outputs").glob("*/*_compare")
    assert len(rows(folder / "runs.csv")) == 4


@unseen
def test_what_is_wrong_is_said_and_the_rest_shown(cli: Cli, a_sweep: Path, tmp_path: Path) -> None:
    jobs = sorted(a_sweep.glob("[0-9]*"))
    (jobs[0] / "episodes" / "000001.npz").unlink()
    (jobs[1] / "config.yaml").unlink()
    (jobs[2] / "status.json").write_text(json.dumps({"state": "failed", "error": "it broke", "episode": 2}))
    answer = cli("compare", "sweep", "sweep", "nowhere", "out=out")
    assert answer.code == 0, answer.error
    lines = answer.out.splitlines()
    for said in ("000001.npz is missing. Shown up to there, 40 steps.", f"{jobs[1].name} did not begin",
                 "There is no folder nowhere.", "LEFT OUT: small_room, random, seed 0 (done): 40 steps, and 80",
                 "Not finished (failed), but long enough: small_room, bounce, seed 0"):
        assert len([line for line in lines if said in line]) == 1, (said, answer.out)
    assert len(rows(tmp_path / "out" / "runs.csv")) == 3 and len(rows(tmp_path / "out" / "arms.csv")) == 1
    for page in ("comparison.md", "report.html"):
        text = (tmp_path / "out" / page).read_text()
        assert "did not begin" in text and "it broke" in text and "There is no folder nowhere." in text


@pytest.mark.parametrize(("words", "said"), [
    ((), "There is no run to compare"), (("nowhere",), "There is no folder nowhere"), ((".",), "holds neither"),
    (("sweep", "baseline=randon"), "Did you mean random?"), (("sweep", "at=soon"), "not a list of steps"),
    (("sweep", "marking=swepd"), "Did you mean swept?"), (("sweep", "colour=red"), "compare has no setting colour"),
    (("sweep", "out=sweep/multirun.yaml/x"), "sweep/multirun.yaml is a file. Name a folder."),
])
def test_wrong_words_are_answered(cli: Cli, a_sweep: Path, words: tuple[str, ...], said: str) -> None:
    answer = cli("compare", *words)
    assert answer.code == 2 and said in answer.error and "Traceback" not in answer.error
    assert not (a_sweep.parent / "outputs").exists()
