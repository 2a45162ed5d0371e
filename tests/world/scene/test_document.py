"""docs/scenes.md: what it shows loads and can be walked in, what exists is explained."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml

from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.materials.materials import COLOURS, PATTERNS
from curionav_cli.world.scene import scene_format
from curionav_cli.world.scene.furniture import KINDS
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import env_dir, plain
from curionav_cli.world.settings import Env

DOCS = Path(__file__).resolve().parents[3] / "docs"
TEXT = (DOCS / "scenes.md").read_text(encoding="utf-8")
CABIN, LOOKS = (block for block in re.findall(r"```yaml\n(.*?)```", TEXT, re.DOTALL))
RECORDS = {"rooms": scene_format.Room, "walls": scene_format.Wall, "posters": scene_format.Poster,
           "furniture": scene_format.Furniture, "repeat": scene_format.Repeat, "solids": scene_format.Solid,
           "light": scene_format.Light, "moves": scene_format.Move, "tune": scene_format.Tune}


def test_the_cabin_is_a_home_to_walk_in() -> None:
    assert len(CABIN.splitlines()) <= 40
    scene = Scene.from_dict(yaml.safe_load(CABIN), "cabin.yaml")
    bedroom = scene.plan.visitable[:, 75:]
    assert bedroom.sum() > 500, "one can walk through the door"
    env = NavigationEnv(scene)
    rng = np.random.default_rng(0)
    seen: set[tuple[int, int]] = set()
    for episode in range(3):
        env.reset(seed=0, options={"episode": episode})
        turns = 0
        for _ in range(500):
            observation, *_, info = env.step(1 if turns else 0)
            turns = int(rng.integers(3, 20)) if info["collided"] else max(turns - 1, 0)
            row, column = scene.plan.cells(*info["pose"][:2])
            assert env.now.plan.visitable[row, column]
            seen.add((int(row), int(column)))
        assert observation["image"].std() > 10
    assert len(seen) > 100 and max(column for _, column in seen) > 75
    assert [event["item"] for event in scene.at(2, 0)[1]] == ["chair_1"]


def test_the_cabin_explores_from_a_directory_of_ones_own(tmp_path: Path, monkeypatch, capsys) -> None:
    from curionav_cli.app import main

    (tmp_path / "mine" / "env").mkdir(parents=True)
    (tmp_path / "mine" / "env" / "cabin.yaml").write_text(CABIN)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["sheet", "env=cabin", "--config-dir", "mine", "hydra.run.dir=out"])
    assert stop.value.code in (0, None)
    assert "visitable cells of 5 cm" in capsys.readouterr().out and (tmp_path / "out" / "sheet.png").is_file()


def test_the_overlay_dresses_a_map(tmp_path: Path) -> None:
    image = np.full((30, 60), 254, np.uint8)
    image[[0, -1]] = image[:, [0, -1]] = 0
    image[10:16, 20:28] = 0
    cv2.imwrite(str(tmp_path / "office.png"), image[::-1])
    (tmp_path / "office.yaml").write_text("image: office.png\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
                                          "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    (tmp_path / "looks.yaml").write_text(LOOKS)
    paths = {"map": str(tmp_path / "office.yaml"), "overlay": str(tmp_path / "looks.yaml")}
    scene = Scene.from_dict(*plain("map", **paths))
    assert scene.plan.start[:2] == (0.6, 0.6) and scene.changing
    assert 0.72 in scene.boxes.high[:, 2]
    own = {**plain("map")[0], **yaml.safe_load(LOOKS), "map": paths["map"]}
    assert np.array_equal(Scene.from_dict(own).boxes.high, scene.boxes.high), "the same lists in a file of its own"


def row_of(name: str) -> str:
    rows = (line for line in TEXT.splitlines() if line.startswith("| `"))
    return next(row for row in rows if f"`{name}`" in row.split("|")[1])


@pytest.mark.parametrize("path", sorted(env_dir().glob("*.yaml")), ids=lambda path: path.stem)
def test_every_environment_is_listed_with_its_numbers(path: Path) -> None:
    raw = yaml.safe_load(path.read_text())
    row = row_of(path.stem)
    if raw.get("size"):
        width, depth = raw["size"]
        assert f"{raw['visitable']} " in row
        assert f"{width:g} x {depth:g} m" in row.replace(".0 ", " ")
        picture = DOCS / "pictures" / f"{path.stem}.jpg"
        assert f"pictures/{path.stem}.jpg" in TEXT and picture.stat().st_size < 300_000


def test_every_key_kind_material_and_colour_is_explained() -> None:
    def unexplained(names: Any) -> list[str]:
        return [name for name in names if f"`{name}`" not in TEXT]
    assert not unexplained(field.name for field in fields(Env))
    assert not unexplained(KINDS) and not unexplained(PATTERNS) and not unexplained(filter(None, COLOURS))
    for name, record in RECORDS.items():
        row = row_of(name)
        assert not [field.name for field in fields(record) if field.name not in row], name


def test_the_plans_are_there() -> None:
    assert cv2.imread(str(DOCS / "pictures" / "apartments.jpg")).shape[1] > 1000
    assert sum(path.stat().st_size for path in (DOCS / "pictures").iterdir()) < 3_000_000
