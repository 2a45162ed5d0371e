"""The wheel, installed in a fresh environment, finds its settings from anywhere."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
import venv
from pathlib import Path
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).resolve().parents[2]


def run(*words: str | Path, cwd: Path | str) -> str:
    done = subprocess.run([str(word) for word in words], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", folder, ROOT, cwd=folder)
    return next(folder.glob("curionav-*.whl"))


@pytest.mark.wheel
def test_the_wheel_holds_the_settings(wheel: Path) -> None:
    names = set(ZipFile(wheel).namelist())
    for path in (ROOT / "conf").rglob("*.yaml"):
        assert f"curionav_cli/{path.relative_to(ROOT)}" in names
    assert not [name for name in names if name.startswith(("tests", "outputs", "documentation"))]
    described = {name.partition(".dist-info/")[2] for name in names if ".dist-info/" in name}
    assert described >= {"licenses/LICENSE", "licenses/NOTICE", "extra_metadata/CITATION.cff",
                         "extra_metadata/CHANGELOG.md", "extra_metadata/CONTRIBUTING.md"}


@pytest.mark.wheel
def test_a_fresh_installation_composes_from_the_root(wheel: Path, tmp_path: Path) -> None:
    """The dependencies are lent by this environment, through a path file: they are not what is tested."""
    venv.create(tmp_path / "env", with_pip=False)
    python = tmp_path / "env" / "bin" / "python"
    site = Path(run(python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd="/").strip())
    run(sys.executable, "-m", "pip", "--python", python, "install", "--quiet", "--no-deps", "--no-index",
        "--disable-pip-version-check", wheel, cwd="/")
    (site / "lent.pth").write_text(sysconfig.get_path("purelib"))
    command = tmp_path / "env" / "bin" / "curionav"
    where = run(python, "-c", "import curionav_cli; print(curionav_cli.__file__)", cwd="/").strip()
    assert where.startswith(str(site))
    shown = run(command, "explore", "--cfg", "job", cwd="/")
    assert "name: small_room" in shown and "name: lbs_dreamer" in shown
    assert str(site / "curionav_cli" / "conf") in run(command, "explore", "--info", "searchpath", cwd="/")
