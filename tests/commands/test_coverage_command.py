"""curionav coverage RUN: three marking rules, two denominators, from the poses of a finished run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from entry import Cli
from paint import unpainted

from curionav_cli.app import main
from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import cover
from curionav_cli.storage.run_folder import RunFolder

unseen = pytest.mark.usefixtures("blank_figures")


@pytest.fixture(scope="module")
def explored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run = tmp_path_factory.mktemp("explored") / "run"
    words = ("agent=bounce", "loop.steps=40", "loop.episodes=2", f"hydra.run.dir={run}")
    with unpainted(), pytest.raises(SystemExit) as stop:
        main(["explore", *words])
    assert stop.value.code == 0
    return run


@pytest.fixture
def a_run(explored: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(explored, tmp_path / "run"))


@pytest.mark.usefixtures("painted")
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


@unseen
def test_one_rule_can_be_asked_for(cli: Cli, a_run: Path) -> None:
    answer = cli("coverage", "run", "marking=swept", "denominator=floor")
    assert answer.code == 0 and "landing" not in answer.out and "swept" in answer.out
    assert sorted(path.name for path in (a_run / "figures").glob("*_*.png")) == [
        "coverage_swept_floor.png", "heatmap_swept_floor.png"]


@pytest.mark.usefixtures("painted")
def test_episodes_are_drawn_and_filmed_into_a_folder_of_their_own(cli: Cli, a_run: Path, tmp_path: Path) -> None:
    before = sorted(a_run.rglob("*"))
    words = ("coverage", "run", "marking=landing", "denominator=visitable", "episodes=1", "film=last")
    for turn in ("one", "two"):
        assert cli(*words, f"out={turn}").code == 0
    assert sorted(a_run.rglob("*")) == before
    made = {path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*.*")}
    names = {"run/card.png", "run/trajectories.pdf", "run/episode_000001.webm", "beside_small_room.png",
             "card_small_room.pdf", "run/heatmap_landing_visitable.png"}
    assert names <= {str(path) for path in made}
    for path in made:
        assert (tmp_path / "one" / path).read_bytes() == (tmp_path / "two" / path).read_bytes(), path


@unseen
def test_runs_in_different_worlds_of_one_name_are_drawn_apart(cli: Cli, a_run: Path, tmp_path: Path) -> None:
    words = ("agent=bounce", "env.camera=0.6", "loop.steps=40", "loop.episodes=2", "hydra.run.dir=higher")
    assert cli("explore", *words).code == 0
    answer = cli("coverage", "run", "higher", "marking=landing", "denominator=visitable", "out=out")
    assert answer.code == 0, answer.error
    assert sorted(path.name for path in (tmp_path / "out").glob("*.png")) == [
        f"{kind}_small_room_camera={camera}.png" for kind in ("beside", "card") for camera in ("0.45", "0.6")]


@unseen
def test_what_is_missing_is_named_and_the_rest_shown(cli: Cli, a_run: Path) -> None:
    (a_run / "episodes" / "000001.npz").unlink()
    with open(a_run / "metrics.jsonl", "a") as file:
        file.write('{"episode": 2, "cov')
    answer = cli("coverage", "run", "nowhere", "marking=landing", "denominator=visitable", "out=out")
    assert answer.code == 0, answer.error
    for said in ("000001.npz is missing. Shown up to there, 40 steps.", "line 3 is torn", "There is no folder nowhere"):
        assert len([line for line in answer.out.splitlines() if said in line]) == 1, (said, answer.out)
    for word, said in (("film=1", "has no episode 1. It has 0 to 0."), ("episodes=first", "not a list of episodes")):
        answer = cli("coverage", "run", word)
        assert answer.code == 2 and said in answer.error
    (a_run / "episodes" / "000000.npz").write_bytes(b"PK")
    answer = cli("coverage", "run")
    assert answer.code == 2 and "no finished episode" in answer.error and len(answer.error.strip().splitlines()) == 1


@unseen
def test_runs_of_one_name_have_folders_of_their_own(cli: Cli, a_run: Path, tmp_path: Path) -> None:
    for sweep in ("one", "two"):
        shutil.copytree(a_run, tmp_path / sweep / "run")
    assert cli("coverage", "one", "two", "marking=landing", "denominator=visitable", "out=out").code == 0
    assert {path.parent.name for path in tmp_path.glob("out/*/card.png")} == {"one_run", "two_run"}


@pytest.mark.parametrize(("words", "said"), [
    ((), "Name the folder of a run or a sweep"), (("nowhere",), "There is no folder nowhere"),
    (("run", "marking=swepd"), "Did you mean swept?"), (("run", "color=red"), "coverage has no setting color"),
    ((".",), "holds no run"), (("run", "out=file"), "file is a file. Name a folder."),
])
def test_wrong_words_have_one_clear_line(cli: Cli, tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    (tmp_path / "file").touch()
    answer = cli("coverage", *words)
    assert answer.code == 2 and said in answer.error and len(answer.error.strip().splitlines()) == 1
