"""Figures without their rendering, for tests that look at none: it takes longer than the short runs that end in it."""

from __future__ import annotations

from base64 import b64decode
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import IO, Any

import pytest

from curionav_cli.files import write_whole

BLANK = {"pdf": b"%PDF", "png": b64decode(  # one white pixel
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAsTj2FAAAAABJRU5ErkJggg==")}


def blank(figure: Any, file: IO[bytes], *, format: str, **_: Any) -> None:
    """Stand in for Figure.savefig."""
    file.write(BLANK[format])


def saved(figure: Any, path: Path) -> None:
    """Stand in for plots.save, without laying out what is not painted."""
    path.parent.mkdir(parents=True, exist_ok=True)
    for kind in BLANK:
        write_whole(path.with_suffix(f".{kind}"), partial(blank, figure, format=kind))


@contextmanager
def unpainted() -> Iterator[None]:
    """Let figures be composed and their files written as ever, but empty."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("matplotlib.figure.Figure.savefig", blank)
        patch.setattr("curionav_cli.results.plots.save", saved)
        yield
