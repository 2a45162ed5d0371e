"""curionav explore env=live: the one loop on a robot in memory, its results without a denominator, and its refusals."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from body import Body
from entry import Cli
from tiny import LEARNER

from curionav_cli.execution import exploration
from curionav_cli.live import connect
from curionav_cli.live.env import LiveRobot
from curionav_cli.records import Episode
from curionav_cli.storage.run_folder import RunFolder

LIVE = ("env=live", "robot=rosbridge", "robot.profile=turtlebot4", "loop.steps=12")
DRAW = exploration.draw  # which takes seconds
SMALL = [word for word in LEARNER if not word.startswith(("env=", "loop.episodes"))]


class Robots(list[Body]):
    """The robots that were connected to, one for each process that a person starts. before: changes one before it is
    used."""

    asked: list[str]

    def __init__(self) -> None:
        super().__init__()
        self.asked, self.before = [], lambda body: None

    def live_robot(self, settings, floor, say) -> LiveRobot:
        self.append(Body(settings))
        self.before(self[-1])
        return LiveRobot(floor, settings, self[-1].link, self[-1], self.asked.append)


@pytest.fixture
def robots(monkeypatch: pytest.MonkeyPatch) -> Robots:
    """The robots of this test, in place of those on the network."""
    made = Robots()
    monkeypatch.setattr(connect, "live_robot", made.live_robot)
    monkeypatch.setattr(connect, "refuse_unreachable", lambda settings: None)
    monkeypatch.setattr(exploration, "draw", lambda run: None)
    return made


def test_the_agent_learns_on_a_real_floor(cli: Cli, robots: Robots) -> None:
    answer = cli("explore", *SMALL, *LIVE, "loop.episodes=3", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    run = RunFolder(Path("run"))
    episodes = [Episode.load(path) for path in run.episode_paths()]
    assert [len(episode) for episode in episodes] == [12, 12, 12]
    assert episodes[0].dock is None and [one.dock["code"] for one in episodes[1:]] == ["docked", "docked"]
    assert all(len(np.unique(one.image.reshape(13, -1), axis=0)) > 1 for one in episodes)
    rows = run.metrics()
    assert all(row["coverage"] is None and row["visitable"] is None and row["visited"] > 0 for row in rows)
    assert all("model_loss" in row or "updates" in row for row in rows)
    assert "by the estimated pose, out of an unknown number of cells" in answer.out
    assert robots[0].link.closed and robots[0].speed == 0.0 and not robots.asked


@pytest.mark.slow
def test_results_say_that_there_is_no_denominator(cli: Cli, robots: Robots) -> None:
    assert cli("explore", *LIVE, "agent=bounce", "loop.episodes=1", "hydra.run.dir=run").code == 0
    DRAW(RunFolder(Path("run")))
    assert {path.name for path in Path("run/figures").glob("*.png")} >= {"heatmap.png", "coverage.png"}
    table = Path("run/table.md").read_text()
    assert "| - |" in table and "by the estimated pose" in table
    assert cli("coverage", "run", "out=drawn").code == 0
    assert cli("runs", ".").code == 0
    compared = cli("compare", "run", "out=compared")
    assert compared.code != 0 and "a real floor without a map" in compared.out + compared.error


def test_a_map_of_the_floor_gives_a_denominator(cli: Cli, robots: Robots) -> None:

    floor = Path("floor.yaml")
    picture = np.full((100, 140), 254, np.uint8)
    picture[[0, -1]] = picture[:, [0, -1]] = 0
    import cv2

    cv2.imwrite("floor.pgm", picture)
    floor.write_text("image: floor.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
                     "occupied_thresh: 0.65\nfree_thresh: 0.25\n")
    answer = cli("explore", *LIVE, "agent=bounce", "loop.episodes=1", "hydra.run.dir=run", "env.floor=floor.yaml",
                 "env.start=[1.5,2.5,0]")
    assert answer.code == 0, answer.error
    status = RunFolder(Path("run")).status
    assert status["visitable"] > 1000 and 0.0 < status["coverage"] < 0.1
    missing = cli("explore", *LIVE, "agent=bounce", "env.floor=floor.yaml")
    assert missing.code == 2 and "env.start" in missing.error


def test_a_fault_closes_an_episode_and_the_run_goes_on(cli: Cli, robots: Robots) -> None:
    def falling_silent(body: Body) -> None:
        body.watch.append(lambda: 8.3 < body.time < 13.0 and body.silent.add("image"))
        body.watch.append(lambda: body.time > 13.0 and body.silent.discard("image"))

    robots.before = falling_silent
    answer = cli("explore", *SMALL, *LIVE, "loop.episodes=2", "hydra.run.dir=run")
    assert answer.code == 0
    first, second = [Episode.load(path) for path in RunFolder(Path("run")).episode_paths()]
    assert len(first) < 12 and len(second) == 12
    assert first.events[-1]["what"] == "closed" and "image" in first.events[-1]["why"]
    assert f"episode 0 was closed after {len(first)} steps: {first.events[-1]['why']}\n" in answer.out
    assert f"episode 2/2, {len(first) + 12} steps, " in answer.out


def test_a_robot_that_stays_away_fails_the_run_which_can_be_resumed(cli: Cli, robots: Robots) -> None:
    robots.before = lambda body: body.watch.append(lambda: body.time > 12.0 and body.silent.add("odom"))
    answer = cli("explore", *LIVE, "agent=bounce", "loop.episodes=2", "robot.patience=2", "hydra.run.dir=run")
    run = RunFolder(Path("run"))
    assert answer.code == 1 and "/odom has been silent" in answer.error and run.state == "failed"
    assert len(run.episode_paths()) == 1 and robots[0].speed == 0.0
    robots.before = lambda body: None
    again = cli("resume", "run", "robot.host=192.168.1.77", "robot.patience=30")
    assert again.code == 0, again.error
    second = Episode.load(run.episode_path(1))
    assert len(second) == 12 and second.dock["human"] and run.settings["robot"]["host"] == "192.168.1.77"


def test_an_interrupted_run_stops_the_robot_and_is_resumed(cli: Cli, robots: Robots) -> None:
    def interrupting(body: Body) -> None:
        def strike() -> None:
            if len(RunFolder(Path("run")).episode_paths()) and body.time > 60.0:
                body.watch.clear()
                raise KeyboardInterrupt
        body.watch.append(strike)

    robots.before = interrupting
    answer = cli("explore", *LIVE, "agent=bounce", "loop.episodes=9", "hydra.run.dir=run")
    assert answer.code == 130 and robots[0].speed == 0.0 and robots[0].link.closed
    robots.before = lambda body: None
    done = len(RunFolder(Path("run")).episode_paths())
    assert cli("resume", "run", f"loop.episodes={done + 1}").code == 0
    assert len(RunFolder(Path("run")).episode_paths()) == done + 1


@pytest.mark.parametrize(("words", "line"), [
    (("env=live",), "robot=ideal is simulated. Choose robot=rosbridge."),
    (("robot=rosbridge",), "env=small_room is simulated. Choose env=live."),
    ((*LIVE, "agent=frontier"), "agent=frontier is an oracle"),
    ((*LIVE, "agent=cbet", "loop.steps=100"), "Set agent.view=ego"),
    ((*LIVE, "robot.profile=turtlbot4"), "Did you mean turtlebot4"),
    ((*LIVE, "robot.geofence=-1"), "robot.geofence: -1.0 is not between"),
    ((*LIVE, "robot.profile.scan.name=''", "robot.profile.depth.name=''"), "would drive blind"),
    ((*LIVE, "robot.profile.image.type=''"), "has no type"),
    ((*LIVE, "env.size=[2,2]"), "a real floor has no scene"),
])
def test_what_does_not_go_together_is_answered_in_a_line(cli: Cli, robots: Robots, words, line: str) -> None:
    answer = cli("explore", *words)
    assert answer.code == 2 and line in answer.error and "Traceback" not in answer.error
    assert not Path("outputs").exists() and not robots


@pytest.mark.parametrize(("words", "line"), [
    (("sheet", "env=live"), "a real floor, of which there is no scene"),
    (("dock", "env=live", "robot=rosbridge"), "A real robot docks between its episodes"),
    (("explore", *LIVE, "agent=bounce", "robot.port=1", "robot.connect=0.5"), "No rosbridge server answers at ws://localhost:1"),
    (("robot", "check", "turtlebot4", "robot.port=1", "robot.connect=0.5"), "No rosbridge server answers"),
    (("robot", "check", "turtlebot5"), "Did you mean"),
])
def test_commands_that_do_not_fit_are_answered_in_a_line(cli: Cli, words, line: str) -> None:
    answer = cli(*words)
    assert answer.code == 2 and line in answer.error and not Path("outputs").exists()


def test_robot_check_prints_what_to_mend(cli: Cli, robots: Robots) -> None:
    answer = cli("robot", "check", "turtlebot4")
    assert answer.code == 0 and "Nothing to mend" in answer.out and "/drive_distance" in answer.out
    assert robots[0].link.closed
    robots.before = lambda body: body.link.offered.pop("/odom")
    answer = cli("robot", "check", "turtlebot4")
    assert answer.code == 1 and "to mend" in answer.out and "MISSING" in answer.out


@pytest.mark.slow
def test_an_episode_of_500_steps_and_the_profile_recorded_whole(cli: Cli, robots: Robots) -> None:
    words = [word for word in LIVE if not word.startswith("loop.")]
    assert cli("explore", *words, "agent=bounce", "loop.episodes=1", "hydra.run.dir=run").code == 0
    episode = Episode.load(RunFolder(Path("run")).episode_path(0))
    assert len(episode) == 500 and episode.events == () and 0 < episode.collided.sum() < 250
    robot = RunFolder(Path("run")).settings["robot"]
    assert robot["profile"]["drive"]["name"] == "/drive_distance"
    fixed = json.loads(Path("run/fixed.json").read_text())["robot"]
    assert "profile" in fixed and "host" not in fixed
