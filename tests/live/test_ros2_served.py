"""Our worlds over a real rosbridge server and ROS 2: driven by an rclpy client, and by robot=rosbridge itself."""

from __future__ import annotations

import json
import math
import sys
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from entry import Cli
from worlds import apart, floor_of, placed

from curionav_cli.commands import serve
from curionav_cli.live.rosbridge import Rosbridge
from curionav_cli.live.served.body import RATE, ServedBody
from curionav_cli.live.served.pace import Pace
from curionav_cli.live.served.robot import ServedRobot
from curionav_cli.live.served.settings import Serving
from curionav_cli.records import Episode, Pose
from curionav_cli.storage.run_folder import RunFolder

sys.path.insert(0, str(Path(__file__).parents[1] / "peers"))

from ros_peer import READY, Bridge, end

pytestmark = [pytest.mark.ros2, pytest.mark.timeout(600),
              pytest.mark.skipif(not READY.exists(), reason="no ROS 2 peer: make ros-peer")]
CONF = Path(__file__).parents[1] / "peers" / "conf"
WORLD = ("env=small_room", "env.radius=0.18", "robot.profile=peer", "robot.battery.capacity=9000", "seed=4")


class Served:
    """A world on a bridge. ticks: (metres, radians) of each tick that was driven."""

    def __init__(self, bridge: Bridge, speed: float, *words: str):
        self.link, self.settings = serve.settings_of([*WORLD, f"robot.port={bridge.port}", *words])
        self.serving, self.transport = Serving(speed=speed), Rosbridge("127.0.0.1", bridge.port, 2, 20.0)
        self.robot: ServedRobot = serve.served(self.settings, self.link, self.serving, [], self.transport, print)[0]
        self.ticks: list[tuple[float, float]] = []
        self._drive, self.robot.body.tick = self.robot.body.tick, self.tick
        self._over = threading.Event()
        self.thread = threading.Thread(target=self._run, args=(speed,))
        self.thread.start()

    def tick(self, distance: float, turn: float):
        self.ticks.append((distance, turn))
        return self._drive(distance, turn)

    def _run(self, speed: float) -> None:
        def watch() -> None:
            if self._over.is_set():
                raise KeyboardInterrupt
        with suppress(KeyboardInterrupt):
            Pace([self.robot], speed, print).run(watch)

    def stop(self) -> None:
        self._over.set()
        self.thread.join()
        self.transport.close()

    def again(self) -> list[tuple[Pose, Pose]]:
        """The true pose and the odometry after each tick, of the same commands in a world in this process."""
        body = ServedBody(self.robot.body.scene, self.settings.robot, self.serving, self.settings.seed, docked=True)
        found = [(body.body.pose, body.odometry)]
        for distance, turn in self.ticks:
            body.tick(distance, turn)
            found.append((body.body.pose, body.odometry))
        return found


@pytest.fixture
def bridge(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bridge]:
    monkeypatch.setenv("CURIONAV_CONFIG_PATH", str(CONF))
    made = Bridge(tmp_path)
    yield made
    made.stop()


def test_an_rclpy_client_drives_a_hundred_moves_as_the_simulation_does(bridge: Bridge, tmp_path: Path) -> None:
    served, log = Served(bridge, speed=1.0), tmp_path / "client.log"
    client = bridge.start("client_node.py", log)
    try:
        assert client.wait(550) == 0, log.with_suffix(".error").read_text()[-2000:]
    finally:
        end(client)
        served.stop()
    lines = [json.loads(line) for line in log.read_text().splitlines()]
    assert [(one["action"], one["state"]) for one in lines if "action" in one] == [
        ("undock", "succeeded"), ("undock", "aborted"), ("dock", "cancelled")]
    alone, compared = served.again(), {"/odom": 0, "/ground_truth": 0}
    for line in (line for line in lines if "topic" in line):
        seconds = line["stamp"][0] - served.robot.epoch + 1e-9 * line["stamp"][1]
        tick = round(seconds * RATE)
        true, odometry = alone[tick]
        assert apart(Pose(*line["pose"]), true if line["topic"] == "/ground_truth" else odometry) < 1e-9, tick
        compared[line["topic"]] += 1
    commands = [one for one, before in zip(served.ticks[1:], served.ticks) if one != before and any(one)]
    print(f"{len(commands)} changes of velocity, compared {compared}")
    assert len(commands) > 80 and min(compared.values()) > 500


BY_LIGHT = ("robot.profile.dock.name=''", "robot.profile.undock.name=''", "robot.profile.dock_ir.name=/dock_ir",
            "robot.profile.dock_ir.type=std_msgs/msg/UInt8MultiArray", "robot.profile.docked.name=/battery_state",
            "robot.profile.docked.type=sensor_msgs/msg/BatteryState")  # in types that PyPI has


@pytest.mark.parametrize("docking", [(), BY_LIGHT], ids=["action", "light"])
def test_the_product_explores_its_own_world_over_ros(bridge: Bridge, cli: Cli, docking: tuple[str, ...]) -> None:
    served = Served(bridge, 1.0, *docking)
    try:
        answer = cli("explore", "env=live", "robot=rosbridge", "robot/profile=peer", "env.radius=0.18",
                     "robot.host=127.0.0.1", f"robot.port={bridge.port}", "robot.stale=8", "robot.move=10",
                     "robot.connect=20", "agent=bounce", "loop.steps=20", "loop.episodes=2", "hydra.run.dir=run",
                     *docking)
        assert answer.code == 0, answer.error
    finally:
        served.stop()
    first, second = [Episode.load(path) for path in RunFolder(Path("run")).episode_paths()]
    assert len(first) == len(second) == 20 and not first.events and not second.events
    assert second.dock and second.dock["code"] == "docked", second.dock
    assert all(len(np.unique(one.image.reshape(21, -1), axis=0)) > 10 for one in (first, second))
    dock, start = served.robot.body.scene.dock, floor_of("peer").plan.start  # one place in two frames
    last = Pose(second.pose[-1][0] - start.x, second.pose[-1][1] - start.y, second.pose[-1][2] - start.yaw)
    found, true = placed(last, dock), served.robot.body.body.pose
    off, turned = math.hypot(found.x - true.x, found.y - true.y), abs(math.remainder(found.yaw - true.yaw, math.tau))
    print(f"after docking and an episode the estimate is off by {off:.3f} m and {math.degrees(turned):.1f} degrees")
    contact = served.settings.robot.docking.contact  # a docked robot stands as askew as its contacts allow
    way = float(np.hypot(*np.diff(second.pose[:, :2], axis=0).T).sum()) + 0.5  # and what it backed off before
    assert math.degrees(turned) < contact.angle + 3.0 and off < 0.3 + way * math.sin(math.radians(contact.angle))
