"""Where files are: what a user names, and the conf/ of this package. Apart from files.py, which loads numpy."""

from __future__ import annotations

import os
from pathlib import Path


def place(text: str | Path) -> Path:
    """A path as a person types it, ~ expanded: the shell leaves that of out=~/figures to us."""
    try:
        return Path(text).expanduser()
    except RuntimeError:  # ~name of no user is a name like any other
        return Path(text)


def cache_dir(kind: str) -> Path:
    """This user's cache folder for one kind of files, by the XDG rules."""
    return place(os.environ.get("XDG_CACHE_HOME") or "~/.cache") / "curionav" / kind


def conf_dir() -> Path:
    """conf/ inside the package (installed from a wheel), or beside it (a checkout)."""
    package = Path(__file__).resolve().parent
    inside = package / "conf"
    return inside if inside.is_dir() else package.parent / "conf"
