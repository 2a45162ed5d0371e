"""The contract of a logger: metrics in the form that another program shows, beside metrics.jsonl.

metrics.jsonl is always written. What a logger holds is derived from it, and written anew from there whenever a run
begins or is resumed.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from curionav_cli.files import read_json
from curionav_cli.safe_yaml import LOADER
from curionav_cli.storage.run_folder import RunFolder


class Local:
    """The logger that adds nothing to metrics.jsonl; the base class of others."""

    def __init__(self, run: RunFolder):
        """Begin with the rows that metrics.jsonl of `run` holds already."""

    def add(self, row: dict[str, Any]) -> None:
        """Log one more row of metrics.jsonl."""

    def add_figures(self, figures: Sequence[Path]) -> None:
        """Log the figures of a finished run, PNG files."""

    def close(self) -> None:
        """End the log, when the run ends."""


def step_of(row: dict[str, Any]) -> int:
    """The step of a row: environment steps, of offline training iterations."""
    return int(row.get("steps", row.get("iterations", 0)))


def identity(run: RunFolder) -> str:
    """A name of 16 hexadecimal digits for the run, the same whenever it is resumed, also where its sweep was moved."""
    path = run.path / "run.json"
    about = read_json(path) if path.exists() else {}
    about.pop("resumed", None)
    seen = json.dumps(about, indent=2).encode() if about else b""
    return hashlib.sha256(run.path.resolve().name.encode() + b"\0" + seen).hexdigest()[:16]


def sweep_of(run: RunFolder) -> str | None:
    """The name of the sweep that the run belongs to; None of a single run."""
    folder = run.path.resolve().parent
    return folder.name if (folder / "multirun.yaml").is_file() else None


def settings_of(run: RunFolder) -> dict[str, Any]:
    """The settings of the run as plain values; {} before it has any."""
    return yaml.load(run.config.read_text(), LOADER) if run.config.is_file() else {}
