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
