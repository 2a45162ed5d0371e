"""A scene that cannot be is answered with the file that a person can open, whatever name stands in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

from curionav_cli.config.sources import conf_dir


@pytest.mark.parametrize(("old", "new", "said"), [
    ("\nvisitable: 449", "\nvisitable: 450", "promises visitable: 450 cells and has 449"),
    ("material: ", "materiel: ", "has no key materiel. Did you mean material?"),
    ("\ncell:", "\ncel: 1\ncell:", "no key env.cel. Did you mean env.cell?"),
    ("\nstart: [0.55", "\nstart: [1.95", "is inside a wall or furniture"),
])
def test_the_file_is_named(cli: Cli, tmp_path: Path, old: str, new: str, said: str) -> None:
    text = (conf_dir() / "env" / "small_room.yaml").read_text()
    assert old in text
    (tmp_path / "mine" / "env").mkdir(parents=True)
    (tmp_path / "mine" / "env" / "cellar.yaml").write_text(text.replace(old, new))
    answer = cli("explore", "--config-dir", "mine", "env=cellar", "agent=random", "hydra.run.dir=run")
    assert answer.code == 2 and said in answer.error
    assert answer.error.startswith(str(tmp_path / "mine" / "env" / "cellar.yaml"))
    assert len(answer.error.strip().splitlines()) == 1 and not (tmp_path / "run").exists()


@pytest.mark.parametrize(("typed", "said"), [
    ("env.start=[99,99,0]", "env.start=[99,99,0]: the start (99, 99) is inside a wall"),
    ("env.visitable=7", "env.visitable=7: promises visitable: 7 cells and has 449"),
    ("env.camera=7", "env.camera (7 m) must be below the ceiling, env.height (2.4 m)"),
])
def test_what_was_typed_is_blamed_and_not_our_file(cli: Cli, typed: str, said: str) -> None:
    answer = cli("explore", "agent=random", "env.fov=80", typed)
    assert answer.code == 2 and answer.error.startswith(said) and len(answer.error.splitlines()) == 1
