"""The real entry point, called in this process, in a folder of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

import pytest
from entry import Answer, Cli
from paint import unpainted

from curionav_cli.app import main
from curionav_cli.places import conf_dir


@pytest.fixture
def cli(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str]) -> Iterator[Cli]:
    """cli("explore", "seed=1") -> exit code, stdout, stderr; relative paths lead into tmp_path.

    Figures are files without a picture, unless the test uses `painted`.
    """
    monkeypatch.chdir(tmp_path)

    def call(*words: str) -> Answer:
        capsys.readouterr()
        with pytest.raises(SystemExit) as stop:
            main(list(words))
        seen = capsys.readouterr()
        return Answer(int(stop.value.code or 0), seen.out, seen.err)

    with nullcontext() if "painted" in request.fixturenames else unpainted():
        yield call


@pytest.fixture
def unsized(monkeypatch: pytest.MonkeyPatch) -> None:
    """`curionav list env` names the environments of conf/ without building them, which takes four CPU-seconds."""
    from curionav_cli.commands import listing

    row = listing.environment
    monkeypatch.setattr(listing, "environment", lambda hydra, name: (
        ("",) * 5 if (conf_dir() / "env" / f"{name}.yaml").is_file() else row(hydra, name)))


@pytest.fixture
def painted() -> None:
    """For tests that look at the figures of `cli`."""


@pytest.fixture
def blank_figures() -> Iterator[None]:
    """For tests that look at no figure."""
    with unpainted():
        yield
