"""Overlays: the file beside a ROS map for what the map does not hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from office import write_two_rooms

from curionav_cli.errors import SceneError
from curionav_cli.records import Pose
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.registration import make
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

TABLE = [2.0, 1.0, 2.8, 1.6]  # occupied on the map
OVERLAY: dict[str, Any] = {
    "note": "the office of two rooms",
    "start": [0.6, 0.6, 0], "dock": [0.6, 0.6, 180],
    "rooms": [{"rect": [0, 0, 3.1, 3], "floor": "carpet_red", "wall": "brick"},
              {"rect": [3.1, 0, 6, 3], "floor": "parquet", "wall": "stripe_green"}],
    "solids": [{"rect": TABLE, "height": 0.72, "material": "wood_oak"}],
    "posters": [{"at": [1.5, 2.9], "face": "south", "art": "painting_1"}],
    "furniture": [{"kind": "chair", "x": 4.5, "y": 2.2, "name": "chair"}],
    "moves": [{"item": "chair", "every": 1, "to": [[4.5, 0.8]]}],
    "light": {"drift": 0.3},
}


@pytest.fixture
def office(tmp_path: Path) -> Path:
    """A map of 6 x 3 m, 10 cm cells: two rooms, a door, and something occupied at TABLE."""
    return write_two_rooms(tmp_path)


def overlay(office: Path, **changes: Any) -> Path:
    path = office.with_name("looks.yaml")
    path.write_text(yaml.safe_dump({**OVERLAY, **changes}))
    return path


def scene(office: Path, path: Path | None, **settings: Any) -> Scene:
    return Scene.from_dict(*plain("map", map=str(office), overlay=path and str(path), **settings))


def test_it_changes_how_a_map_looks_and_not_where_one_can_go(office: Path) -> None:
    bare, dressed = scene(office, None, start=[0.6, 0.6, 0]), scene(office, overlay(office, furniture=[], moves=[]))
    assert np.array_equal(bare.plan.visitable, dressed.plan.visitable)
    assert np.array_equal(bare.plan.floor, dressed.plan.floor)
    assert dressed.plan.start == bare.plan.start and dressed.dock == Pose(0.6, 0.6, np.pi)
    assert dressed.note == "the office of two rooms"


def test_rooms_give_walls_and_floor(office: Path) -> None:
    dressed = scene(office, overlay(office))
    ground, boxes = dressed.ground, dressed.boxes
    assert ground.materials[ground.index[15, 5]] == "carpet_red"
    assert ground.materials[ground.index[15, 50]] == "parquet"
    walls = np.flatnonzero(~boxes.decal & (boxes.high[:, 2] == dressed.height))
    assert (boxes.high[walls, 0] < 0.2).any() and (boxes.low[walls, 0] > 5.8).any()
    for box in walls:
        x0, x1 = boxes.low[box, 0], boxes.high[box, 0]
        if x1 < 0.2:
            assert boxes.materials[boxes.sides[box, 1]] == "brick"
        if x0 > 5.8:
            assert boxes.materials[boxes.sides[box, 0]] == "stripe_green"
        assert not (x0 < 3.0 and x1 > 3.2), "cut where the rooms meet"


def test_solids_have_their_height(office: Path) -> None:
    dressed = scene(office, overlay(office))
    table = [box for box in range(len(dressed.boxes)) if dressed.boxes.high[box, 2] == 0.72]
    area = sum(np.prod((dressed.boxes.high[box] - dressed.boxes.low[box])[:2]) for box in table)
    assert area == pytest.approx(0.8 * 0.6)
    across = Renderer(dressed).render(1.0, 1.3, 0)[1][0]
    assert across[20, 32] > 1.5 > 1.05 > across[40, 32], "one sees over the table, not through it"


def test_posters_replace_the_guessed_ones(office: Path) -> None:
    assert scene(office, None).boxes.decal.sum() > 1
    assert scene(office, overlay(office)).boxes.decal.sum() == 1


def test_things_move_and_the_light_drifts(office: Path) -> None:
    env = NavigationEnv(scene(office, overlay(office)))
    env.reset(seed=0)
    env.reset()
    assert [event["what"] for event in env.events] == ["move", "light"]
    assert not scene(office, overlay(office), changes=False).changing


def test_what_is_set_elsewhere_stands(office: Path) -> None:
    assert scene(office, overlay(office), start=[4.0, 1.0, 90]).plan.start[:2] == (4.0, 1.0)


def test_gymnasium_takes_it_too(office: Path) -> None:
    assert make("map", map=str(office), overlay=str(overlay(office))).scene.note == "the office of two rooms"


@pytest.mark.parametrize(("change", "said"), [
    ({"poster": []}, "looks.yaml: an overlay has no key poster. Did you mean posters?"),
    ({"radius": 0.2}, "looks.yaml: an overlay has no key radius. It has: note, start"),
    ({"solids": [{"rect": TABLE}]}, "looks.yaml: solids[0] lacks the key height"),
    ({"solids": [{"rect": TABLE, "height": 9.0}]}, "looks.yaml: solids[0].height must be a number from 0.01 to 2.5"),
    ({"solids": [{"rect": TABLE, "height": 1.0, "material": "gold"}]}, "looks.yaml: there is no material gold"),
    ({"solids": [{"rect": TABLE, "height": 1.0, "fit": "yes"}]}, "solids[0].fit must be true or false"),
    ({"furniture": [{"kind": "chiar", "x": 1, "y": 1}]}, "looks.yaml: furniture[0].kind: there is no furniture chiar"),
    ({"moves": [{"item": "sofa", "every": 1, "to": [[1, 1]]}]}, "looks.yaml: moves[0].item: no piece"),
    ({"dock": [1.0]}, "looks.yaml: dock must be [x, y, degrees]"),
    ({"start": 5}, "looks.yaml: start must be a list of numbers, not 5"),
    ({"start": ["a", "b", 0]}, "looks.yaml: start must be a list of numbers, not ['a', 'b', 0]"),
])
def test_mistakes_name_the_overlay_and_the_key(office: Path, change: dict[str, Any], said: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene(office, overlay(office, **change))
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_no_overlay_there_and_no_map_for_it(office: Path) -> None:
    with pytest.raises(SceneError, match=r"There is no overlay .*none\.yaml"):
        scene(office, office.with_name("none.yaml"))
    with pytest.raises(SceneError, match="overlay adds to a ROS map"):
        Scene.from_dict(*plain("small_room", overlay=str(overlay(office))))
    with pytest.raises(SceneError, match=r"solids describes what a ROS map shows .* this scene opens no map"):
        Scene.from_dict(*plain("small_room", solids=[{"rect": TABLE, "height": 1}]))
    broken = office.with_name("broken.yaml")
    for text, said in (("posters: [\n", "broken.yaml is not YAML in line"), ("- 1\n", "must hold keys")):
        broken.write_text(text)
        with pytest.raises(SceneError, match=said):
            scene(office, broken)
