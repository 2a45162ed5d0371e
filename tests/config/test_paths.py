"""Paths with signs that a shell or Hydra's grammar keeps for itself: opened, or answered with what is to be typed."""

from __future__ import annotations

import re
import subprocess
from itertools import product
from pathlib import Path

import pytest
from entry import Cli
from hydra.core.override_parser.overrides_parser import OverridesParser

from curionav_cli.commands.arguments import sorted_out
from curionav_cli.config.compose import Plan, plan
from curionav_cli.config.paths import SETTINGS, as_text, as_typed, quoted
from curionav_cli.config.schema import Config
from curionav_cli.config.sources import opened
from curionav_cli.errors import ConfigError
from curionav_cli.files import folder_for
from curionav_cli.places import place

NAMES = ["my map", "a=b", "a#1", "o'brien", "büro", "日本", "[draft] (2)", "{x}", "1e3", "true", "a,b", "a&b;c!", "x\\",
         "q\"u'o\\'te", "$home", "`ls`"]


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """~, which is where the command is typed too."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def planned(*words: str, command: str = "sheet", multirun: bool = False) -> tuple[Plan, list[Config]]:
    seen: list[Config] = []
    with opened(command) as hydra:
        return plan(hydra, list(words), multirun, seen.append), seen


def test_a_path_is_taken_as_it_is_typed(home: Path) -> None:
    with opened("sheet") as hydra:
        parser = OverridesParser.create(config_loader=hydra.config_loader)
        for key, start, name in product(SETTINGS, ("", "~/", "no/"), NAMES):
            (home / name).write_text("")
            if start == "no/" and name == "a,b" and not key.startswith("hydra."):
                continue  # nothing of that name is there: it is a sweep
            override, = parser.parse_overrides([as_typed(hydra, f"{key}={start}{name}")])
            assert override.value() == start + name
    name = "~/a#1"
    todo, (settings,) = planned("env=map", f"env.map={name}", f"env.overlay={name}", f"data={name}",
                                "hydra.run.dir=~/runs/ü =")
    assert settings.env.map == settings.env.overlay == settings.data == str(home / "a#1")
    assert todo.folder == home / "runs" / "ü ="


def test_lists_formulas_and_quotes_stay_what_they_are(home: Path) -> None:
    (home / "x").write_text("")
    _, seen = planned("env=map", "env.map=a.yaml,b.yaml,'c d.yaml'", multirun=True)
    assert [Path(str(one.env.map)).name for one in seen] == ["a.yaml", "b.yaml", "c d.yaml"]
    assert planned("env=map", "env.map=null")[1][0].env.map is None
    assert planned("hydra.run.dir=runs/${seed}")[0].folder == Path("runs/0")
    assert planned("env=map", "env.map='~/a b'")[1][0].env.map == str(home / "a b")
    assert planned("env=map", "env.map=~nobody_of_that_name/x")[1][0].env.map == str(home / "~nobody_of_that_name/x")


@pytest.mark.parametrize("text", [*NAMES, "why (not), really?", "'"])
def test_what_is_to_be_typed_reaches_us_through_bash(text: str) -> None:
    line = as_text(f"question={text}")
    typed = subprocess.run(["bash", "-c", f"printf %s {line}"], capture_output=True, text=True, check=True).stdout
    override, = OverridesParser.create().parse_overrides([typed])
    assert typed == f"question={quoted(text)}" and override.value() == text


def test_the_answer_is_the_line_that_works(cli: Cli) -> None:
    for text in ("why (not)", "this, or that"):
        answer = cli("explore", f"question={text}", "--cfg", "job", "-p", "question")
        assert answer.code == 2 and f"\"question='{text}'\"" in answer.error
        assert cli("explore", f"question='{text}'", "--cfg", "job", "-p", "question").out.strip() == text
    assert "-m 'question=a, b'" in cli("explore", "question=a, b").error


def test_an_option_with_an_umlaut_is_an_option(cli: Cli, home: Path) -> None:
    (home / "my conf" / "env").mkdir(parents=True)
    (home / "my conf" / "env" / "büro.yaml").write_text("defaults:\n  - small_room\n")
    for folder in ("my conf", "~/my conf"):
        assert cli("explore", f"--config-dir={folder}", "env=büro", "--cfg", "job").code == 0


def test_folders_of_the_other_commands(home: Path) -> None:
    (home / "a=b c").mkdir()
    assert sorted_out("compare", ["~/a=b c", "~/x", "out=~/é f"], {"out": ()}) == (
        [home / "a=b c", home / "x"], {"out": "~/é f"})
    assert folder_for("~/é f") == home / "é f" and place("~nobody_of_that_name") == Path("~nobody_of_that_name")
    with pytest.raises(ConfigError, match="out= is empty"):
        sorted_out("compare", ["out="], {"out": ()})


def test_a_relative_map_is_found_whatever_hydra_changes_into(cli: Cli, home: Path) -> None:
    pixels = bytes([0] * 40 + ([0] + [254] * 38 + [0]) * 38 + [0] * 40)
    (home / "room.pgm").write_bytes(b"P5\n40 40\n255\n" + pixels)
    (home / "room.yaml").write_text("image: room.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
                                    "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    answer = cli("sheet", "env=map", "env.map=room.yaml", "hydra.job.chdir=true", "hydra.run.dir=seen")
    assert answer.code == 0 and re.search(r"visitable cells of 5 cm", answer.out), answer.error
    assert (home / "seen" / "sheet.png").is_file()
