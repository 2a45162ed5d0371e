"""curionav evaluate: a trained agent acts in another world and learns nothing."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest
from entry import Cli
from tiny import LEARNER

from curionav_cli.config.compose import composed
from curionav_cli.execution.exploration import explore

WEIGHTS = "weights.safetensors"
CBET = ("env=small_room", "device=cpu", "agent=cbet", "loop.steps=20", "loop.episodes=1", "agent.unroll=10",
        "agent.batch_size=2", "agent.conv_channels=[4,4]", "agent.dense_units=[8]", "agent.lstm_units=8")


RUNS = {
    "trained": (), "b": ("seed=1",), "other": ("agent.gru_units=8",), "cbet": CBET,
    "bounce": ("env=small_room", "agent=bounce", "loop.steps=5", "loop.episodes=1"),
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the runs of RUNS, of an episode each, without figures."""
    folder = tmp_path_factory.mktemp("runs")
    for name, words in RUNS.items():
        own = words if name in ("cbet", "bounce") else (*LEARNER, "loop.episodes=1", "loop.iterations=1", *words)
        settings = composed("explore", *{word.partition("=")[0]: word for word in own}.values())
        explore(settings, folder / name, drawn=False)
    return folder


def test_another_world_with_the_same_weights_and_the_same_bytes_twice(cli: Cli, runs: Path, tmp_path: Path) -> None:
    for name in ("once", "twice"):
        answer = cli("evaluate", f"{runs}/trained", "env=apartment_1", "loop.episodes=1", "seed=3",
                     f"hydra.run.dir={name}")
        assert answer.code == 0, answer.error
    once, twice = tmp_path / "once", tmp_path / "twice"
    before = (runs / "trained" / "checkpoint" / "000001" / WEIGHTS).read_bytes()
    assert (once / "checkpoint" / "000001" / WEIGHTS).read_bytes() == before
    for path in sorted((once / "episodes").iterdir()):
        assert path.read_bytes() == (twice / "episodes" / path.name).read_bytes()
    row, = csv.DictReader((once / "evaluation.csv").read_text().splitlines())
    assert (row["env"], row["trained_env"], row["trained_for"]) == ("apartment_1", "small_room", "1 episodes")
    assert float(row["open_loop"]) > 0 and float(row["surprise"]) > 0 and row["steps"] == "12"
    assert "| apartment_1 | lbs_dreamer | small_room |" in (once / "evaluation.md").read_text()


def test_several_runs_are_a_sweep_that_compare_reads_and_resume_continues(cli: Cli, runs: Path, tmp_path: Path) -> None:
    answer = cli("evaluate", f"{runs}/trained", f"{runs}/b", "loop.episodes=1", "hydra.sweep.dir=sweep")
    assert answer.code == 0, answer.error
    with (tmp_path / "sweep" / "evaluation.csv").open() as file:
        assert [(row["training_seed"], row["seed"], row["env"]) for row in csv.DictReader(file)] == [
            ("0", "0", "small_room"), ("1", "0", "small_room")]
    compared = cli("compare", "sweep", f"{runs}/trained", f"{runs}/b", "out=compared")
    assert compared.code == 0 and "LEFT OUT" not in compared.out, compared.out
    with (tmp_path / "compared" / "runs.csv").open() as file:
        assert {row["seed"] for row in csv.DictReader(file)} == {"0", "1", "0 / 0", "1 / 0"}
    begun_earlier(tmp_path / "sweep")
    answer = cli("resume", "sweep", "loop.episodes=2")
    assert answer.code == 0, answer.error
    assert len(list((tmp_path / "sweep").glob("*/episodes/000001.npz"))) == 2


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_worlds_seeds_and_a_robot_that_docks_are_one_table(cli: Cli, runs: Path, tmp_path: Path) -> None:
    """Each run has two episodes, and one return to dock between them, successful or not."""
    answer = cli("evaluate", "-m", f"{runs}/trained", "env=small_room,apartment_1", "seed=0,1", "robot=turtlebot2i",
                 "loop.episodes=2", "hydra.sweep.dir=sweep")
    assert answer.code == 0, answer.error
    rows = list(csv.DictReader((tmp_path / "sweep" / "evaluation.csv").read_text().splitlines()))
    assert [(row["env"], row["seed"]) for row in rows] == [
        (world, seed) for world in ("small_room", "apartment_1") for seed in ("0", "1")]
    assert [int(row["docked"]) + int(row["carried"]) for row in rows] == [1] * 4
    assert {row["trained_env"] for row in rows} == {"small_room"} and "docked" in answer.out
    before = (runs / "trained" / "checkpoint" / "000001" / WEIGHTS).read_bytes()
    assert [path.read_bytes() for path in (tmp_path / "sweep").glob(f"*/checkpoint/000002/{WEIGHTS}")] == [before] * 4
    compared = cli("compare", "sweep", "out=compared")
    assert compared.code == 0 and (tmp_path / "compared" / "figures" / "apartment_1.png").is_file(), compared.error


def begun_earlier(folder: Path) -> None:
    """Write a run or a sweep of an earlier version, in which `init` was called `weights`."""
    for file in [*folder.rglob("config.yaml"), *folder.glob("multirun.yaml")]:
        text = file.read_text()
        older = text.replace("\ninit:", "\nweights:").replace("- init=", "- weights=")
        assert older != text, file
        file.write_text(older)


def test_an_evaluation_of_an_earlier_version_is_resumed(cli: Cli, runs: Path, tmp_path: Path) -> None:
    assert cli("evaluate", f"{runs}/trained", "loop.episodes=1", "hydra.run.dir=run").code == 0
    begun_earlier(tmp_path / "run")
    answer = cli("resume", "run", "loop.episodes=2")
    assert answer.code == 0 and "\ninit:" in (tmp_path / "run" / "config.yaml").read_text(), answer.error


def test_cbet_is_evaluated_without_its_counts(cli: Cli, runs: Path, tmp_path: Path) -> None:
    answer = cli("evaluate", f"{runs}/cbet", "env=apartment_0", "loop.episodes=1", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    assert json.loads((tmp_path / "run" / "fixed.json").read_text())["trained"] == {"env": "small_room", "episodes": 1}
    names = [run / "checkpoint" / "000001" / WEIGHTS for run in (runs / "cbet", tmp_path / "run")]
    assert names[0].read_bytes() == names[1].read_bytes()


def test_mistakes_are_answered_in_a_line(cli: Cli, runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(runs)
    for words, said in (
        ([], "evaluate needs the run whose agent is evaluated: curionav evaluate outputs/DATE/RUN"),
        (["nowhere"], "There is no folder nowhere"),
        (["bounce"], "agent=bounce does not learn, so there is nothing to evaluate"),
        (["trained", "agent.gru_units=8"], "agent.gru_units=... is a setting of the trained agent. Leave it out"),
        (["trained", "agent=bounce"], "agent=... is a setting of the trained agent"),
        (["trained", "other"], "has an agent of other settings than"),
        (["trained", "loop.iterations=3"], "loop.iterations=3 would train the agent, and evaluate does not"),
        (["trained", "learner=remote"], "learner=remote has no meaning for curionav evaluate"),
        (["trained", "init=other"], "name the trained run twice"),
    ):
        answer = cli("evaluate", *words, "loop.episodes=1", "hydra.run.dir=wrong")
        assert answer.code == 2 and said in answer.error, (words, answer)
        assert len(answer.error.strip().splitlines()) == 1 and not (runs / "wrong" / "config.yaml").exists()
    answer = cli("explore", "init=trained", "agent=bounce", "hydra.run.dir=wrong")
    assert answer.code == 2 and "agent=bounce does not learn, so it has no weights to take from" in answer.error


def test_a_run_without_a_checkpoint_is_named(cli: Cli, runs: Path, tmp_path: Path) -> None:
    shutil.copytree(runs / "trained", tmp_path / "trained")
    broken = tmp_path / "trained" / "checkpoint" / "000001" / WEIGHTS
    broken.write_bytes(broken.read_bytes()[:100])
    answer = cli("evaluate", "trained")
    assert answer.code == 2 and "weights.safetensors is not whole" in answer.error
    for path in (tmp_path / "trained" / "checkpoint" / "000001").iterdir():
        path.unlink()
    answer = cli("evaluate", "trained")
    assert answer.code == 2 and "has no checkpoint, so there is no trained agent in it" in answer.error


@pytest.mark.parametrize("value, text", [("a'b", r"'a\'b'"), ([1, "x"], "[1,'x']"), (None, "null"), (True, "true"),
                                         (1e-5, "1e-05"), ([{"x": 1.5}], "[{x:1.5}]")])
def test_values_in_hydras_grammar(value: object, text: str) -> None:
    from curionav_cli.commands.initial import literal

    assert literal(value) == text
