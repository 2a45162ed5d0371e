"""curionav list: groups, options, and every environment with its size."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

from curionav_cli.config.sources import conf_dir

SHED = """# A shed.
defaults:
  - /schema/env
name: shed
note: a shed of mine
size: [2.0, 3.0]
cell: 0.1
radius: 0.2
camera: 0.5
"""


def row(out: str, name: str) -> str:
    """The row that begins with `name`, with what broke over the next lines."""
    lines = out.splitlines()
    begins = next(at for at, line in enumerate(lines) if line.strip().startswith(name + " "))
    ends = next((at for at, line in enumerate(lines[begins + 1:], begins + 1) if not line.startswith("  ")), len(lines))
    return " ".join(" ".join(lines[begins:ends]).split())


def test_groups_and_their_options(cli: Cli) -> None:
    answer = cli("list")
    assert answer.code == 0
    for path in conf_dir().glob("*/*.yaml"):
        assert path.stem in row(answer.out, path.parent.name)


def test_every_environment_with_its_size(cli: Cli) -> None:
    out = cli("list", "env").out
    for name, cells, area in (("apartment_0", "23476", "58.69"), ("apartment_1", "21328", "53.32"),
                              ("apartment_2", "18123", "45.31")):
        assert row(out, name).split()[2:5] == [area, cells, "5"]
    assert row(out, "large_lab").split()[1:5] == ["230.00", "155.43", "15543", "10"]
    assert row(out, "small_room").split()[1:5] == ["8.00", "4.49", "449", "10"]
    assert "look-alike aisles" in row(out, "large_lab")
    assert "any ROS map" in row(out, "map") and "does not load" not in out


def test_agents_with_a_line_each(cli: Cli) -> None:
    out = cli("list", "agent").out
    assert "Latent Bayesian Surprise as intrinsic reward" in row(out, "lbs_dreamer")
    assert "Each action, or each option, with the same probability" in row(out, "random")
    assert "Minutes on two cores" in cli("list", "scale").out


def test_environments_of_ones_own(cli: Cli, unsized: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine" / "env").mkdir(parents=True)
    (tmp_path / "mine" / "env" / "shed.yaml").write_text(SHED)
    (tmp_path / "mine" / "env" / "ruin.yaml").write_text(SHED.replace("0.2", "1.9").replace("shed", "ruin"))
    out = cli("list", "env", "-cd", "mine").out
    assert row(out, "shed").split()[1:5] == ["6.00", "4.16", "416", "10"] and "a shed of mine" in out
    assert "does not load: env/ruin.yaml: a robot of radius 1.9 m fits nowhere" in row(out, "ruin")
    assert "shed" not in cli("list", "env").out
    monkeypatch.setenv("CURIONAV_CONFIG_PATH", str(tmp_path / "mine"))
    assert "shed" in cli("list", "env").out


def test_a_group_that_does_not_exist(cli: Cli) -> None:
    answer = cli("list", "agnet")
    assert answer.code == 2 and answer.out == ""
    assert answer.error.startswith("There is no group agnet. Did you mean agent? The groups are: agent, env")
