"""Docking by the dock's infrared light over topics, of a served Kobuki; and its bumper."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from worlds import World, settings_of

from curionav_cli.config.compose import composed
from curionav_cli.config.settings import read_settings, settings_yaml
from curionav_cli.live.check import contents, in_bits
from curionav_cli.live.contacts import touches
from curionav_cli.live.served.body import RATE
from curionav_cli.robot.measurements import Reading

KOBUKI = ("robot.profile=turtlebot2i", "robot.profile.dock.name=''", "env=small_room")
BUMPER, LIGHT = "/mobile_base/events/bumper", "/mobile_base/sensors/dock_ir"


def test_it_docks_by_light_and_a_silent_receiver_asks_for_a_person() -> None:
    world, asked = World(*KOBUKI, exact=True), list[str]()
    world.link = replace(world.link, docking=replace(world.link.docking, staging=0.5, charge=1.0))
    env = world.explorer(asked)
    assert env.reset(seed=0)[1]["dock"] is None and not asked
    assert {finding.what: finding.about for finding in contents(env.base)}["content dock_ir"] == "no light of a dock"
    body, docked = world.robot.body, list[bool]()
    report_tick = body.after

    def after() -> None:
        docked.append(body.charging)
        report_tick()

    body.after = after
    report = env.reset()[1]["dock"]
    assert (report["code"], report["attempts"], report["human"]) == ("docked", 1, False) and not asked
    assert sum(docked) > RATE * world.link.docking.charge and not docked[-1]  # then it has left its dock
    world.memory.subscribers.pop(LIGHT)
    report = env.reset()[1]["dock"]
    assert report["code"] == "sensor_silent" and report["human"] and len(asked) == 1 and not env.step(0)[3]


@pytest.mark.slow
@pytest.mark.parametrize("words", [(), ("robot.profile.dock_ir.name=''",)], ids=["dock", "start"])
def test_it_comes_home_from_where_it_has_driven_into_things(words: tuple[str, ...]) -> None:
    """With drift, through the camera alone: five episodes with collisions, and no person is called."""
    world, asked = World(*KOBUKI, *words, "seed=1", images=5.0), list[str]()
    env, collided = world.explorer(asked), 0
    env.reset(seed=0)
    for episode in range(5):
        for step in range(30):
            ahead = (step + episode) % 6
            *_, closed, info = env.step(0 if ahead else 1 + episode % 2)
            collided += bool(info["collided"])
            assert not closed, env.events
        assert env.reset()[1]["dock"]["code"] == "docked"
    assert collided > 10 and not asked


def test_a_bumper_that_was_pressed_is_let_go() -> None:
    """The events of kobuki_msgs tell one third of the bumper each: what is let go is what was pressed."""
    world, touching, found = World(*KOBUKI), dict[str, bool](), list[list[str]]()
    kind = settings_of(*KOBUKI)[0].profile.contacts[BUMPER]
    world.memory.subscribe(BUMPER, kind, lambda message: touching.update(touches(message, kind)))
    for side in (None, "left", "left", "right", None, "centre", None):
        world.robot.body.reading = Reading(0.0, 0.0, 0.02, 0.0, side)
        world.robot.body.after()
        found.append(sorted(name for name, pressed in touching.items() if pressed))
    sides = [[], ["left"], ["left"], ["right"], [], ["centre"], []]
    assert found == [[f"bumper_{side}" for side in pressed] for pressed in sides]


def test_the_light_is_told_in_the_bits_of_the_kobuki() -> None:
    assert in_bits((0, 10, 16)) == "right 0, centre 10, left 16"


def test_a_run_from_before_there_was_docking_by_light_is_read(tmp_path: Path) -> None:
    now = composed("explore", "env=live", "robot=rosbridge")
    older = yaml.safe_load(settings_yaml(now))
    del older["robot"]["docking"], older["robot"]["profile"]["dock_ir"]
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(older))
    found = read_settings(tmp_path / "config.yaml").robot
    assert found.docking == now.robot.docking and not found.profile.dock_ir.name
