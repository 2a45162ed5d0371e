"""curionav doctor: check packages, devices, launchers and folders, and that a small run repeats to the byte."""

from __future__ import annotations

import io
import os
import platform
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import redirect_stdout
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from curionav_cli.config.compose import composed
from curionav_cli.config.plugins import broken
from curionav_cli.errors import RunFailed, UserError
from curionav_cli.execution import exploration
from curionav_cli.execution.precision import speeds
from curionav_cli.execution.screen import a_console, table
from curionav_cli.storage import checkpoint
from curionav_cli.storage.provenance import PACKAGES
from curionav_cli.storage.run_folder import RunFolder

EXTRAS = {"fast": "numba", "sweep": "hydra-joblib-launcher", "slurm": "hydra-submitit-launcher",
          "tensorboard": "tensorboard", "scan": "embreex", "hpo": "hydra-optuna-sweeper", "ros": "roslibpy",
          "bags": "rosbags"}
OK, NOT_THERE, LEFT_OUT, BROKEN = "ok", "not there", "left out", "BROKEN"
SMALL = (  # takes seconds, and still acts, learns and saves
    "env=small_room", "agent=lbs_dreamer", "device=cpu", "loop.steps=12", "loop.iterations=4", "loop.episodes=2",
    "agent.batch_size=3", "agent.sequence_length=6", "agent.gru_units=16", "agent.rssm_hidden=16",
    "agent.mlp_units=16", "agent.mlp_layers=1", "agent.latent_dimension=4", "agent.latent_classes=4",
    "agent.horizon=4", "agent.imagination_starts=12", "agent.action_repeat=2",
)
Finding = tuple[str, str, str]  # what, its state, details


def run() -> int:
    """Print all findings; returns the exit code, 1 where something is broken."""
    findings = [*versions(), *plugins(), *devices(), *launchers(), *folders(), self_test()]
    a_console().print(table((("", "left"), ("", "left"), ("", "left")), findings))
    return int(any(state == BROKEN for _, state, _ in findings))


def versions() -> Iterator[Finding]:
    """The versions of Python, the packages and the extras."""
    yield "python", OK, f"{platform.python_version()}, {platform.system()} {platform.machine()}"
    for package in PACKAGES:
        found = installed(package)
        yield package, OK if found else BROKEN, found or "not installed"
    for extra, package in EXTRAS.items():
        found = installed(package)
        how = f"the extra {extra}: .venv/bin/pip install -c constraints.txt -e '.[{extra}]'"
        yield package, OK if found else NOT_THERE, found or how


def plugins() -> Iterator[Finding]:
    """The Hydra plugins that cannot be imported; no command here needs them."""
    for package, why in broken().items():
        yield package, LEFT_OUT, f"a Hydra plugin that cannot be imported: {why}"


def installed(package: str) -> str:
    """The version of a package; "" where it is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def devices() -> Iterator[Finding]:
    """Cores and CUDA devices, and the precision that suits them."""
    from curionav_cli.agents.arithmetic import quick
    from curionav_cli.agents.device import devices as computing
    from curionav_cli.agents.device import resolve_device

    threads = os.environ.get("OMP_NUM_THREADS", "?")
    yield "cores", OK, f"{os.cpu_count()}; a run computes with OMP_NUM_THREADS={threads}"
    for name, about in computing():
        yield name, OK, about
    paper = quick(resolve_device("auto").type).value
    yield "agent.precision=auto", OK, f"{paper} at scale=paper, float32 at scale=cpu ({speeds()})"


def launchers() -> Iterator[Finding]:
    """Which launchers can be used here; Slurm with its partitions."""
    yield "launcher=local", OK, "one run after the other"
    joblib, submitit = installed(EXTRAS["sweep"]), installed(EXTRAS["slurm"])
    yield "launcher=cores", OK if joblib else NOT_THERE, "runs side by side" if joblib else "needs the extra sweep"
    if not submitit or not shutil.which("sbatch"):
        missing = "no sbatch on this machine" if submitit else "needs the extra slurm"
        yield "launcher=slurm", NOT_THERE, missing
        return
    try:
        asked = subprocess.run(["sinfo", "-h", "-o", "%P %D nodes %t"], capture_output=True, text=True, timeout=5)
    except subprocess.TimeoutExpired:
        yield "launcher=slurm", NOT_THERE, "sinfo does not answer"
        return
    answer = "; ".join((asked.stdout if not asked.returncode else asked.stderr).strip().splitlines()[:8])
    yield "launcher=slurm", OK if not asked.returncode else NOT_THERE, answer


def folders() -> Iterator[Finding]:
    """Whether the folders for runs and for temporary files can be written, and their free space."""
    for what, folder in (("outputs", Path("outputs")), ("temporary", Path(tempfile.gettempdir()))):
        there = next(path for path in [folder.absolute(), *folder.absolute().parents] if path.exists())
        try:
            with tempfile.TemporaryFile(dir=there):
                free = shutil.disk_usage(there).free
            yield what, OK, f"{folder.absolute()}, {free / 1e9:.1f} GB free"
        except OSError as error:
            yield what, BROKEN, f"{there} cannot be written ({error.strerror})"


def self_test() -> Finding:
    """A small run, twice: the same seed must give the same bytes. Takes five CPU-seconds, mostly for the figures."""
    began, cpu = time.perf_counter(), time.process_time()
    try:
        settings = composed("explore", *SMALL)
        with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()):
            runs = [exploration.explore(settings, Path(folder) / name, drawn=name == "one") for name in ("one", "two")]
            alike = saved(runs[0]) == saved(runs[1])
            figures = len(list(runs[0].figures.glob("*.png")))
    except (UserError, RunFailed, OSError) as error:
        return "self-test", BROKEN, str(error)
    took = f"{time.perf_counter() - began:.1f} s, {time.process_time() - cpu:.1f} s of them computing"
    loop = settings.loop
    about = (f"{loop.episodes} episodes of {loop.steps} steps, {loop.episodes * loop.iterations} updates, "
             f"{figures} figures; run twice:")
    if not alike:
        return "self-test", BROKEN, f"{about} not the same bytes ({took})"
    return "self-test", OK, f"{about} the same bytes ({took})"


def saved(run: RunFolder) -> dict[str, str]:
    """Checksums of the last checkpoint, which depends on all that was recorded and learned."""
    return checkpoint.checksums(checkpoint.finished(run.checkpoints)[-1])
