"""run.json: the command that repeats a run, the versions and machine that it ran with, and each time it was resumed."""

from __future__ import annotations

import os
import platform
import shlex
import subprocess
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import yaml

from curionav_cli.safe_yaml import LOADER

PACKAGES = ("curionav", "numpy", "torch", "gymnasium", "hydra-core", "opencv-python-headless")


def about(folder: Path, command: str, device: str, seed: int) -> dict[str, Any]:
    """The content of run.json: command, versions, machine, commit.

    folder: where Hydra noted the overrides of this job. command: explore or train.
    """
    hydra = folder / ".hydra" / "hydra.yaml"
    noted = yaml.safe_load(hydra.read_text())["hydra"] if hydra.is_file() else {}
    own = [source["path"] for source in noted.get("runtime", {}).get("config_sources", [])
           if source["provider"] == "user"]
    words = [word for path in own for word in ("--config-dir", path)] + noted.get("overrides", {}).get("task", [])
    return {
        "command": shlex.join(["curionav", command, *words]), "config_dirs": own, "device": device, "seed": seed,
        "began": datetime.now(UTC).isoformat(timespec="seconds"),
        **versions(), "machine": platform.machine(), "cores": os.cpu_count(),
        "threads": os.environ.get("OMP_NUM_THREADS"), **commit(),
    }


def resumed(about: dict[str, Any], unit: str, done: int) -> dict[str, Any]:
    """The content of run.json once more, with a line in `resumed` about going on: after how much, when, which commit.

    Versions stand there too where they are not those of run.json. unit, done: such as episode, 255.
    """
    line = {unit: done, "at": datetime.now(UTC).isoformat(timespec="seconds"), **commit(),
            **{key: value for key, value in versions().items() if value != about.get(key)}}
    return {**about, "resumed": [*about.get("resumed", ()), line]}


def versions() -> dict[str, str]:
    """Versions of Python and of what numbers depend on."""
    return {"python": platform.python_version(), **{package: version(package) for package in PACKAGES}}


def sweep_command(folder: Path) -> str:
    """The command line of the sweep in `folder`; empty where none can be read."""
    try:
        noted = yaml.load((folder / "multirun.yaml").read_text(), LOADER)["hydra"]
        words = [*noted["overrides"]["task"], *(word for word in noted["overrides"]["hydra"]
                                                if not word.startswith(("hydra.mode", "hydra.sweep.dir='")))]
        return shlex.join(["curionav", noted["job"]["name"], "-m", *words])
    except (OSError, yaml.YAMLError, KeyError, TypeError):
        return ""


def commit() -> dict[str, Any]:
    """git_commit and git_changed of the checkout that this code runs from; None where it is no checkout."""
    def git(*words: str) -> str:
        answer = subprocess.run(["git", "-C", str(Path(__file__).parent), *words], capture_output=True, check=True)
        return answer.stdout.decode().strip()
    try:
        return {"git_commit": git("rev-parse", "HEAD"), "git_changed": bool(git("status", "--porcelain"))}
    except (OSError, subprocess.CalledProcessError):
        return {"git_commit": None, "git_changed": None}
