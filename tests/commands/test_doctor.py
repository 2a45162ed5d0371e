"""curionav doctor: what it looks at, what it finds broken, and the small run by which it tests itself."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

from curionav_cli.commands import doctor
from curionav_cli.config.schema import Config
from curionav_cli.errors import RunFailed
from curionav_cli.storage import checkpoint
from curionav_cli.storage.provenance import PACKAGES
from curionav_cli.storage.run_folder import RunFolder


def test_the_self_test_acts_learns_draws_and_repeats_itself() -> None:
    what, state, details = doctor.self_test()
    assert (what, state) == ("self-test", doctor.OK), details
    assert details.startswith("2 episodes of 12 steps, 8 updates, 4 figures; run twice: the same bytes (")
    assert details.endswith(" s of them computing)")


def test_a_run_that_does_not_repeat_itself_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    def another(settings: Config, folder: Path, drawn: bool) -> RunFolder:
        run = RunFolder(folder)
        checkpoint.save(run.checkpoints, 1, {}, lambda inner: (inner / "weights").write_text(folder.name))
        return run
    monkeypatch.setattr(doctor.exploration, "explore", another)
    what, state, details = doctor.self_test()
    assert (what, state) == ("self-test", doctor.BROKEN) and "not the same bytes" in details


def test_a_run_that_fails_is_reported_in_its_own_words(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise RunFailed("The disk is full.")
    monkeypatch.setattr(doctor.exploration, "explore", full)
    assert doctor.self_test() == ("self-test", doctor.BROKEN, "The disk is full.")


def test_everything_is_listed(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "self_test", lambda: ("self-test", doctor.OK, "fine"))
    answer = cli("doctor")
    assert answer.code == 0, answer.out
    for name in (*PACKAGES, *doctor.EXTRAS.values(), "device=cpu", "agent.precision=auto", "launcher=local",
                 "launcher=cores", "launcher=slurm", "outputs", "temporary"):
        assert name in answer.out
    monkeypatch.setattr(doctor, "installed", lambda package: "")
    answer = cli("doctor")
    assert answer.code == 1 and "not installed" in answer.out and "needs the extra sweep" in answer.out


def test_a_folder_that_cannot_be_written_is_broken(monkeypatch: pytest.MonkeyPatch) -> None:
    def locked(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")
    monkeypatch.setattr(doctor.tempfile, "TemporaryFile", locked)
    findings = [(state, "Permission denied" in details) for _, state, details in doctor.folders()]
    assert findings == [(doctor.BROKEN, True)] * 2


def test_a_queue_that_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    def silent(*_: object, **__: object) -> None:
        raise doctor.subprocess.TimeoutExpired("sinfo", 5)
    monkeypatch.setattr(doctor.shutil, "which", lambda name: name)
    monkeypatch.setattr(doctor, "installed", lambda package: "1")
    monkeypatch.setattr(doctor.subprocess, "run", silent)
    assert list(doctor.launchers())[-1] == ("launcher=slurm", doctor.NOT_THERE, "sinfo does not answer")
