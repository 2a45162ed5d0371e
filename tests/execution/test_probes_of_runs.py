"""results.probe_every: rows of metrics.jsonl during a run and a training, killed and resumed, compared and drawn."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
from itertools import product
from pathlib import Path

import pytest
from deadly import DEADLY
from entry import Cli
from leftovers import leftovers
from tiny import LEARNER

from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer
from curionav_cli.app import main
from curionav_cli.commands.resume import refuse_other_changes
from curionav_cli.config.settings import read_settings
from curionav_cli.execution import exploration, training
from curionav_cli.execution.exploration import explore
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world import walks

TINY = tuple(word for word in LEARNER if not word.startswith("loop."))
SHORT = (*(word for word in LEARNER if not word.startswith("loop.episodes")), "loop.episodes=2")
PROBED = {"probe", "probe_error", "probe_error_free", "probe_repeat", "probe_surprise"}


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(walks, "SEQUENCES", 4)


@pytest.fixture(scope="module")
def probed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two episodes that was measured after the second."""
    run = tmp_path_factory.mktemp("probed") / "run"
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as stop:
        patch.setattr(walks, "SEQUENCES", 4)
        main(["explore", *SHORT, "results.probe_every=2", f"hydra.run.dir={run}"])
    assert stop.value.code == 0
    return run


def again(run: Path, folder: Path, *changes: str) -> None:
    """The same run in another folder, with changes and without figures; one that has begun there goes on."""
    explore(read_settings(run / "config.yaml", changes), folder, drawn=False)


def rows(run: Path) -> list[dict]:
    return RunFolder(run).metrics()


def left(run: Path, *without: str) -> dict:
    """All that a run leaves behind but for figures, and these metrics."""
    files = {name: content for name, content in leftovers(run).items() if not name.startswith("figures")}
    return {**files, "metrics": [{key: row[key] for key in row if key not in without} for row in files["metrics"]]}


def table(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file."""
    return list(csv.DictReader(path.read_text().splitlines()))


def test_a_run_is_measured_every_so_often_and_is_otherwise_the_same_run(probed: Path, tmp_path: Path) -> None:
    assert [row.keys() >= PROBED for row in rows(probed)] == [False, True]
    assert len(list((probed.parent / "probes").iterdir())) == 1 and (probed / "figures" / "probe.png").is_file()
    assert "| probe error | surprise |" in (probed / "table.md").read_text()
    [row] = table(probed / "results.csv")
    assert float(row["probe_error"]) == rows(probed)[-1]["probe_error"]
    again(probed, tmp_path / "plain", "results.probe_every=0")
    assert not (tmp_path / "probes").exists()
    ours, plain = left(probed, *PROBED), left(tmp_path / "plain")
    assert ours.keys() == plain.keys() and [name for name in plain if ours[name] != plain[name]] == []


def test_interrupted_while_it_is_measured_it_ends_as_an_undisturbed_run(
        probed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(LBSDreamer, "probe", interrupted)
        again(probed, tmp_path / "run")
    shutil.rmtree(tmp_path / "probes")  # is made anew, to the byte
    again(probed, tmp_path / "run")
    ours, undisturbed = left(tmp_path / "run"), left(probed)
    assert ours.keys() == undisturbed.keys() and [name for name in ours if ours[name] != undisturbed[name]] == []
    [kept], [theirs] = (tmp_path / "probes").iterdir(), (probed.parent / "probes").iterdir()
    assert kept.name == theirs.name and kept.read_bytes() == theirs.read_bytes()


def interrupted(*_: object) -> None:
    raise KeyboardInterrupt


def test_a_measure_may_be_begun_later_and_finds_the_probe_of_other_runs(probed: Path, tmp_path: Path) -> None:
    refuse_other_changes("explore", ["results.probe_every=1"])
    again(probed, tmp_path / "run", "results.probe_every=0", "loop.episodes=1")
    shutil.copytree(probed.parent / "probes", tmp_path / "probes")
    [kept] = (tmp_path / "probes").iterdir()
    made = kept.stat().st_ino
    again(probed, tmp_path / "run", "results.probe_every=1")
    assert ["probe_error" in row for row in rows(tmp_path / "run")] == [False, True] and kept.stat().st_ino == made


def test_an_agent_without_a_world_model_says_so_in_a_line(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exploration, "draw", lambda run: None)
    answer = cli("explore", "agent=random", "loop.steps=5", "loop.episodes=1", "results.probe_every=1",
                 "hydra.run.dir=run")
    assert answer.code == 0 and not Path("probes").exists()
    assert (answer.out + answer.error).count("agent=random has no world model, so results.probe_every=1 measures") == 1


@pytest.mark.parametrize(("words", "said"), [
    (("learner=remote", "storage=file:///tmp/nowhere", "results.probe_every=1"), "which the server learns"),
    (("results.probe_every=-1",), "results.probe_every"), (("results.probe_every=often",), "results.probe_every"),
])
def test_wrong_use_is_answered_in_a_line(cli: Cli, words: tuple[str, ...], said: str) -> None:
    answer = cli("explore", *LEARNER, *words, "hydra.run.dir=run")
    assert answer.code == 2 and said in answer.error and len(answer.error.splitlines()) == 1
    assert not Path("run").exists()


@pytest.fixture
def taught(cli: Cli, probed: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Trainings that were measured after 3 and 6 updates, as if on what random and bounce collected, seeds 0 and 1."""
    monkeypatch.setattr(training, "EVERY", 3)
    answer = cli("train", *TINY, f"data={probed}", "loop.iterations=7", "results.probe_every=1", "hydra.run.dir=one")
    assert answer.code == 0, answer.error
    for said in (f"lbs_dreamer seed 0 on {probed.name}: iteration 6/7", "steps of lbs_dreamer\n"):
        assert said in answer.out
    for explorer, seed in product(("random", "bounce"), (0, 1)):
        run = RunFolder(shutil.copytree("one", f"taught/{explorer}_{seed}"))
        about = json.loads((run.path / "run.json").read_text())
        about["data"] = [{"agent": {"name": explorer}, "seed": seed}]
        run.write("run.json", json.dumps(about))
        run.write("config.yaml", run.config.read_text().replace("seed: 0", f"seed: {seed}"))
        worse = 1 + 0.1 * seed + (explorer == "random")
        run.write_metrics([{**row, **({"probe_error": worse * row["probe_error"]} if "probe" in row else {})}
                           for row in run.metrics()])
    return Path("taught")


def test_what_explorers_teach_is_compared(cli: Cli, taught: Path) -> None:
    measured = [row for row in rows(Path("one")) if "probe" in row]
    assert [row["iterations"] for row in measured] == [3, 6] and Path("one/figures/probe.png").is_file()
    [data] = json.loads(Path("one/run.json").read_text())["data"]
    assert (data["agent"]["name"], data["agent"]["curiosity"], data["seed"]) == ("lbs_dreamer", "lbs", 0)
    answer = cli("compare", str(taught), "baseline=lbs_dreamer on random", "out=compared")
    assert answer.code == 0, answer.error
    assert [(row["arm"], row["n"], row["at"], row["axis"]) for row in table(Path("compared/probes.csv"))] == [
        ("lbs_dreamer on bounce", "2", "6", "updates"), ("lbs_dreamer on random", "2", "6", "updates")]
    [pair] = table(Path("compared/probe_pairs.csv"))
    assert (pair["arm"], pair["minus"], pair["n"]) == ("lbs_dreamer on bounce", "lbs_dreamer on random", "2")
    assert float(pair["probe_error"]) == pytest.approx(-measured[-1]["probe_error"])
    assert len(table(Path("compared/probe_points.csv"))) == 8 and not Path("compared/runs.csv").exists()
    assert Path("compared/figures/probe_updates_small_room.png").is_file()
    assert "fixed probe" in Path("compared/report.html").read_text() and "LEFT OUT" not in answer.out


@pytest.mark.slow
def test_runs_and_trainings_are_compared_side_by_side_and_coverage_shows_the_measure(
        cli: Cli, taught: Path, probed: Path) -> None:
    answer = cli("compare", str(taught), str(probed), "out=both")
    assert answer.code == 0, answer.error
    assert {path.name for path in Path("both/figures").glob("probe_*.png")} == {
        "probe_steps_small_room.png", "probe_updates_small_room.png"}
    assert Path("both/runs.csv").is_file()
    answer = cli("coverage", str(probed), "out=shown", "marking=landing", "denominator=visitable")
    assert answer.code == 0 and "probe error" in answer.out and "surprise" in answer.out
    assert Path("shown/run/probe.png").is_file()


KILLED = DEADLY + """
from curionav_cli.execution.probing import Prober
from curionav_cli.storage import checkpoint, probe_cache
from curionav_cli.probe import Probe
from curionav_cli.storage.run_folder import RunFolder

if moment == "measuring": at(Prober, "metrics", lambda prober, done: done == 4)
if moment == "noting": at(RunFolder, "append_metrics", lambda run, row: row["episode"] == 3)
if moment == "drawing": at(Probe, "save", lambda probe, path: True)
app.main()
"""


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["measuring", "noting", "drawing"])
def test_a_killed_run_ends_as_an_undisturbed_one(tmp_path: Path, moment: str) -> None:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}

    def curionav(*words: str, program: tuple[str, ...] = ("-m", "curionav_cli")) -> int:
        return subprocess.run([sys.executable, *program, *words], capture_output=True, env=environment).returncode

    words = ("explore", *LEARNER, "results.probe_every=2")
    assert curionav(*words, f"hydra.run.dir={tmp_path / 'quiet' / 'run'}") == 0
    run = tmp_path / "killed" / "run"
    assert curionav(moment, *words, f"hydra.run.dir={run}", program=("-c", KILLED)) == -signal.SIGKILL
    assert curionav("resume", str(run)) == 0
    ours, undisturbed = leftovers(run), leftovers(tmp_path / "quiet" / "run")
    assert ours.keys() == undisturbed.keys()
    assert [name for name in ours if ours[name] != undisturbed[name]] == []
