"""logger=wandb and logger=trackio hold the rows of metrics.jsonl, once, also after SIGKILL; wandb sends nothing."""

from __future__ import annotations

import json
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from deadly import DEADLY
from entry import Cli
from tracked import HELD
from warm import Warm

from curionav_cli.errors import SoundnessWarning
from curionav_cli.storage import loggers
from curionav_cli.storage.loggers import Loggers, wandb_file
from curionav_cli.storage.loggers.logger import identity
from curionav_cli.storage.loggers.wandb_log import WandB
from curionav_cli.storage.run_folder import RunFolder

ROWS = [{"episode": n, "steps": 40 * (n + 1), "coverage": 0.125 * (n + 1), "loss": -1.5, "docked": n == 1,
         "found": [n, 7], "question": "which?"} for n in range(3)]
RUN = ("explore", "agent=random", "loop.steps=12", "loop.episodes=4")
TRACKERS = [pytest.param(name, marks=pytest.mark.skipif(bool(loggers.missing([name])), reason=f"extra {name}"))
            for name in ("wandb", "trackio")]
SLOW = pytest.mark.slow
# Kills its own process before or after the loggers have the third row, of which there is no checkpoint yet.
KILLED = DEADLY + """
from curionav_cli.storage.loggers import Loggers
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.execution import exploration

if moment == "logged": at(Loggers, "add", lambda loggers, row: row["episode"] == 2)
if moment == "stored": at(RunFolder, "append_metrics", lambda run, row: row["episode"] == 2)
if moment == "drawn": at(exploration, "draw", lambda run: True)
app.main()
"""


@pytest.fixture(autouse=True)
def no_settings_of_wandb(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in (*(f"WANDB_{name}" for name in ("MODE", "PROJECT", "RUN_GROUP", "ERROR_REPORTING", "SERVICE")),
                 "TRACKIO_DIR"):
        monkeypatch.delenv(name, raising=False)


def log(run: RunFolder, name: str, rows: list[dict]) -> None:
    run.path.mkdir(parents=True, exist_ok=True)
    logger = Loggers(run, [name])
    for row in rows:
        run.append_metrics(row)
        logger.add(row)
    logger.close()


@pytest.mark.parametrize("name", TRACKERS)
def test_every_row_once_also_when_the_run_goes_on_or_was_rewound(tmp_path: Path, name: str) -> None:
    run = RunFolder(tmp_path / "sweep" / "0_run")
    log(run, name, ROWS[:2])
    first = HELD[name](run)
    log(run, name, ROWS[2:])
    assert HELD[name](run).rows == ROWS and HELD[name](run).id == first.id == identity(run)
    run.write_metrics(ROWS[:1])
    log(run, name, [])
    assert HELD[name](run).rows == ROWS[:1]


@SLOW
@pytest.mark.parametrize("name", TRACKERS)
def test_offline_training_has_iterations(tmp_path: Path, name: str) -> None:
    run = RunFolder(tmp_path / "run")
    log(run, name, [{"iterations": 100, "loss": 0.5}, {"iterations": 200, "loss": 0.25}])
    assert HELD[name](run).rows == run.metrics()


@pytest.mark.parametrize("moment", ["logged", pytest.param("stored", marks=SLOW), pytest.param("drawn", marks=SLOW)])
@pytest.mark.parametrize("name", TRACKERS)
def test_rows_equal_metrics_after_a_kill_and_resume(tmp_path: Path, warm: Warm, name: str, moment: str) -> None:
    run = RunFolder(tmp_path / "one" / "run")
    killed = warm(moment, *RUN, f"logger=[{name}]", f"hydra.run.dir={run.path}", program=KILLED)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    before = identity(run)
    resumed = warm("resume", str(run.path))
    assert resumed.returncode == 0 and "warning" not in resumed.stderr, resumed.stderr
    held = HELD[name](run)
    assert held.rows == run.metrics() and len(held.rows) == 4
    assert held.id == before and held.name == "run"
    assert held.figures == {f"figures/{path.stem}" for path in run.figures.glob("*.png")} >= {"figures/heatmap"}


@SLOW
@pytest.mark.parametrize("name", TRACKERS)
def test_runs_of_a_sweep_are_one_group(tmp_path: Path, cli: Cli, blank_figures: None, name: str) -> None:
    sweep = tmp_path / "made"
    answer = cli(*RUN, "-m", "seed=0,1", f"logger=[{name},local]", f"hydra.sweep.dir={sweep}")
    assert answer.code == 0, answer.error
    held = [HELD[name](run) for run in RunFolder.inside(sweep)]
    assert [one.group for one in held] == ["made", "made"] and len({one.id for one in held}) == 2


@pytest.mark.parametrize("logger, said", [
    ("wandv", "Did you mean wandb?"), ("[local,trakio]", "'trakio' is not one of"), ("[tensorboad]", "tensorboard?"),
    ("[]", "names no logger"), ("3", "3 is not one of"), ("null", "None is not one of")])
def test_a_misspelt_logger_is_answered_with_the_nearest(cli: Cli, logger: str, said: str) -> None:
    answer = cli(*RUN, f"logger={logger}")
    assert answer.code == 2 and said in answer.error and "Traceback" not in answer.error
    assert len(answer.error.splitlines()) == 1 and not list(Path("outputs").glob("*/*"))


@pytest.mark.parametrize("name, file", [("wandb", "constraints.txt"), ("trackio", "constraints-trackio.txt")])
def test_a_missing_package_is_named_before_the_run(
        cli: Cli, monkeypatch: pytest.MonkeyPatch, name: str, file: str) -> None:
    monkeypatch.setattr(loggers, "find_spec", lambda package: None if package == name else "found")
    answer = cli(*RUN, f"logger=[tensorboard,{name}]")
    assert answer.code == 2 and len(answer.error.splitlines()) == 1
    assert f"pip install -c {file} -e '.[{name}]'" in answer.error and not list(Path("outputs").glob("*/*"))


@pytest.mark.parametrize("when", ["__init__", "add", "add_figures", "close"])
def test_a_logger_that_fails_says_so_once_and_the_run_goes_on(
        cli: Cli, monkeypatch: pytest.MonkeyPatch, when: str) -> None:
    kept: list[dict] = []

    class Full(loggers.Local):
        """A logger whose disk is full."""

    class Kept(loggers.Local):
        def add(self, row: dict) -> None:
            kept.append(row)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Full, when, full, raising=False)
    monkeypatch.setitem(loggers.LOGGERS, "tensorboard", Full)
    monkeypatch.setitem(loggers.LOGGERS, "local", Kept)
    with pytest.warns(SoundnessWarning, match="logger=tensorboard failed .*No space left.*metrics.jsonl") as said:
        answer = cli(*RUN, "logger=[tensorboard,local]", "hydra.run.dir=run")
    assert answer.code == 0 and len(said) == 1
    assert kept == RunFolder(Path("run")).metrics() and len(kept) == 4
    assert "No space left" in Path("run/explore.log").read_text()


@SLOW
@pytest.mark.parametrize("name", TRACKERS)
def test_a_run_may_get_other_loggers_when_it_is_resumed(cli: Cli, blank_figures: None, name: str) -> None:
    assert cli(*RUN, "hydra.run.dir=run").code == 0
    assert cli("resume", "run", "loop.episodes=5", f"logger=[local,{name}]").code == 0
    run = RunFolder(Path("run").resolve())
    assert HELD[name](run).rows == run.metrics() and len(run.metrics()) == 5
    answer = cli("resume", "run", "loop.episodes=6", "logger=wandv")
    assert answer.code == 2 and "Did you mean wandb?" in answer.error


def test_rows_that_wandb_lost_are_missed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a full disk wandb's file ends early, and wandb says nothing."""
    pytest.importorskip("wandb", reason="needs the extra wandb")
    run = RunFolder(tmp_path / "run")
    log(run, "wandb", ROWS)
    (path,) = run.path.glob("wandb/offline-run-*/*.wandb")
    wandb_file.refuse_lost(path, 3)
    monkeypatch.setattr(wandb_file, "PATIENCE", 0.0)
    with pytest.raises(OSError, match="holds 3 of 4 rows; is the disk full"):
        wandb_file.refuse_lost(path, 4)
    path.write_bytes(path.read_bytes()[:-150])
    with pytest.raises(OSError, match=r"of 3 rows and no end; is the disk full"):
        wandb_file.refuse_lost(path, 3)


def test_a_file_that_wandb_wrote_elsewhere_is_missed(tmp_path: Path) -> None:
    logger = WandB.__new__(WandB)
    logger.folder, logger.stored, logger.run = tmp_path, True, SimpleNamespace(id="x", finish=lambda: None)
    with pytest.raises(OSError, match=r"holds no run-x\.wandb"):
        logger.close()


class Server:
    """A stand-in for a run of wandb that goes on online, where the server has two rows."""

    step, resumed, id = 2, True, "some"

    def __init__(self) -> None:
        self.logged: list[int] = []

    def define_metric(self, *_: object, **__: object) -> None:
        pass

    def log(self, row: dict, step: int) -> None:
        self.logged.append(step)


def test_online_only_rows_that_the_server_lacks_are_sent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wandb = pytest.importorskip("wandb", reason="needs the extra wandb")
    asked: dict = {}
    server = Server()
    monkeypatch.setattr(wandb, "init", lambda **words: asked.update(words) or server)
    monkeypatch.setenv("WANDB_MODE", "online")
    run = RunFolder(tmp_path)
    run.write_metrics(ROWS)
    logger = Loggers(run, ["wandb"])
    logger.add({"episode": 3})
    assert server.logged == [2, 3]
    assert asked["mode"] == "online" and asked["resume"] == "allow" and asked["id"] == identity(run)


# Runs a command in a network namespace without any route, and prints how many packets found none.
ALONE = """
import subprocess, sys
subprocess.run(["ip", "link", "set", "lo", "up"], check=False)
def refused():
    fields, values = [line.split() for line in open("/proc/net/snmp") if line.startswith("Ip:")]
    return int(dict(zip(fields, values))["OutNoRoutes"])
before = refused()
ended = subprocess.run([sys.executable, "-m", "curionav_cli", *sys.argv[1:]], stdin=subprocess.DEVNULL)
print("refused", refused() - before, "code", ended.returncode)
"""


def alone(folder: Path, *words: str) -> str:
    """The last line of ALONE: 'refused 0 code 0'."""
    if not shutil.which("unshare") or subprocess.run(["unshare", "-rn", "true"], capture_output=True).returncode:
        pytest.skip("no network namespace can be made here")
    done = subprocess.run(["unshare", "-rn", sys.executable, "-c", ALONE, *words], cwd=folder, capture_output=True,
                          text=True)
    return done.stdout.splitlines()[-1]


@pytest.mark.parametrize("name", TRACKERS)
@pytest.mark.parametrize("mode", ["", pytest.param("offline", marks=SLOW), pytest.param("disabled", marks=SLOW)])
def test_nothing_tries_to_leave_the_machine(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, mode: str) -> None:
    monkeypatch.setenv("WANDB_MODE", mode)
    monkeypatch.setenv("WANDB_API_KEY", "0123456789" * 4)
    assert alone(tmp_path, *RUN, f"logger={name}", "hydra.run.dir=run") == "refused 0 code 0"
    assert len(RunFolder(tmp_path / "run").metrics()) == 4


@SLOW
def test_what_would_leave_the_machine_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The control of the test above: WANDB_MODE=online asks for a route."""
    pytest.importorskip("wandb", reason="needs the extra wandb")
    monkeypatch.setenv("WANDB_MODE", "online")
    monkeypatch.setenv("WANDB_API_KEY", "0123456789" * 4)
    monkeypatch.setenv("WANDB_INIT_TIMEOUT", "5")
    _, refused, _, code = alone(tmp_path, *RUN, "logger=wandb", "hydra.run.dir=run").split()
    assert int(refused) > 0 and code == "0", "the run goes on without its logger"


def test_the_pins_of_trackio_change_pillow_alone() -> None:
    root = Path(__file__).resolve().parents[2]
    usual, other = ({line.partition("==")[0].lower().replace("_", "-"): line for line in
                     (root / name).read_text().splitlines() if line[0] != "#"}
                    for name in ("constraints.txt", "constraints-trackio.txt"))
    assert usual.keys() & other.keys() == {"pillow"}
    assert json.dumps(other["pillow"]).startswith('"pillow==12.')
