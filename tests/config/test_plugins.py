"""A Hydra plugin that cannot be imported is named in one line, and ends no command."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from curionav_cli.commands import doctor


def test_a_broken_plugin_is_named_and_left_out(tmp_path: Path) -> None:
    for name, line in (("raises", "raise ValueError('mutable default')"), ("misses", "import a_package_that_is_not")):
        (tmp_path / "hydra_plugins" / name).mkdir(parents=True)
        (tmp_path / "hydra_plugins" / name / "__init__.py").write_text(f"{line}\n")
    answer = subprocess.run([sys.executable, "-m", "curionav_cli", "list", "agent"], capture_output=True, text=True,
                            env={**os.environ, "PYTHONPATH": str(tmp_path)}, check=False)
    assert answer.returncode == 0 and "lbs_dreamer" in answer.stdout
    assert sorted(answer.stderr.splitlines()) == [
        "warning: The Hydra plugin hydra_plugins.misses cannot be imported (ModuleNotFoundError: No module named "
        "'a_package_that_is_not'). It is left out.",
        "warning: The Hydra plugin hydra_plugins.raises cannot be imported (ValueError: mutable default). "
        "It is left out."]


def test_the_doctor_reports_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "broken", lambda: {"hydra-ax-sweeper 1.2.0": "ValueError: mutable default"})
    assert list(doctor.plugins()) == [("hydra-ax-sweeper 1.2.0", doctor.LEFT_OUT,
                                       "a Hydra plugin that cannot be imported: ValueError: mutable default")]
