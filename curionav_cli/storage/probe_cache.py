"""Probes on disk: one file a world, in the folder `probes` beside the runs, made anew where it is missing or broken."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from curionav_cli.errors import RunFolderError
from curionav_cli.probe import Probe


def kept(path: Path, make: Callable[[], Probe]) -> Probe:
    """The probe at `path`; where there is none, or a broken one, that of `make()`, which is then written there.

    Processes that make it at the same time write the same bytes, each beside, and the last one to rename stays.
    """
    try:
        return Probe.load(path)
    except RunFolderError:
        path.parent.mkdir(parents=True, exist_ok=True)
        probe, own = make(), path.with_name(f".{os.getpid()}_{path.name}")
        probe.save(own)
        own.replace(path)
        return probe
