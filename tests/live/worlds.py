"""Our worlds served in memory, and a client that is not ours: it knows topic names and message fields only."""

from __future__ import annotations

import math
from collections import defaultdict
from functools import lru_cache
from typing import Any

from curionav_cli.commands import serve
from curionav_cli.config.compose import composed
from curionav_cli.config.schema import Config
from curionav_cli.live.env import LiveRobot
from curionav_cli.live.memory import Memory, OtherSide
from curionav_cli.live.served.robot import ServedRobot
from curionav_cli.live.served.settings import Serving
from curionav_cli.live.settings import Rosbridge
from curionav_cli.records import Pose
from curionav_cli.robot.docking.action import GoalState
from curionav_cli.world.real_floor import RealFloor

LASTING = "robot.battery.capacity=20000"  # simulated seconds; a step over topics takes longer than in simulation


@lru_cache
def settings_of(*words: str) -> tuple[Rosbridge, Config]:
    """What is served by `words`, with a lasting battery unless they say otherwise."""
    lasting = [] if any(word.startswith("robot.battery") for word in words) else [LASTING]
    return serve.settings_of([*words, *lasting])


@lru_cache
def floor_of(profile: str) -> RealFloor:
    """What robot=rosbridge knows of the floor."""
    return RealFloor.of(composed("explore", "env=live", "robot=rosbridge", f"robot/profile={profile}").env)


class World:
    """A served robot and the client's end of its transport. It is the clock: time passes in `sleep` only."""

    def __init__(self, *words: str, **serving: Any):
        self.link, self.settings = settings_of(*words)
        self.memory, self.said = Memory({}), list[str]()
        self.robot: ServedRobot = serve.served(self.settings, self.link, Serving(**{"images": 2.0, **serving}), [],
                                               OtherSide(self.memory), self.said.append, 0.0)[0]

    def now(self) -> float:
        return self.robot.time

    def sleep(self, seconds: float) -> None:
        self.robot.run(seconds)

    @property
    def pose(self) -> Pose:
        """The true pose."""
        return self.robot.body.body.pose

    def explorer(self, asked: list[str] | None = None) -> LiveRobot:
        """robot=rosbridge on this world; a person puts the robot back where that is asked for."""
        def person(what: str) -> None:
            (asked if asked is not None else []).append(what)
            self.robot.body.put_back()
            self.sleep(0.2)
        return LiveRobot(floor_of(self.link.profile.name), self.link, self.memory, self, person)


class Client:
    """A client of topics. heard: all messages of each."""

    def __init__(self, world: World, *topics: str):
        self.world, self.heard = world, defaultdict[str, list[dict[str, Any]]](list)
        for topic in topics:
            world.memory.subscribe(topic, world.memory.offered[topic], self.heard[topic].append)
        world.memory.advertise("/cmd_vel", "geometry_msgs/msg/TwistStamped")
        world.memory.advertise("/put_back", "std_msgs/msg/Empty")

    def command(self, speed: float, rate: float, seconds: float) -> None:
        """Command a velocity and let it be driven."""
        message = {"twist": {"linear": {"x": speed, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": rate}}}
        self.world.memory.publish("/cmd_vel", message)
        self.world.sleep(seconds)

    def act(self, name: str, **goal: float) -> GoalState:
        """Send a goal and wait for its end."""
        sent = self.world.memory.action(name, "", goal)
        while sent.state in (GoalState.active, GoalState.preempting):
            self.world.sleep(0.02)
        return sent.state

    def pose(self, topic: str) -> Pose:
        """The pose in the newest Odometry of a topic."""
        body = self.heard[topic][-1]["pose"]["pose"]
        turn = body["orientation"]
        return Pose(body["position"]["x"], body["position"]["y"], 2.0 * math.atan2(turn["z"], turn["w"]))


def apart(one: Pose, other: Pose) -> float:
    """Metres, and radians counted as metres, between two poses."""
    return math.hypot(one.x - other.x, one.y - other.y, math.remainder(one.yaw - other.yaw, 2.0 * math.pi))


def placed(pose: Pose, start: Pose) -> Pose:
    """A pose in the frame of `start`, in the frame in which `start` is given."""
    cosine, sine = math.cos(start.yaw), math.sin(start.yaw)
    return Pose(start.x + cosine * pose.x - sine * pose.y, start.y + sine * pose.x + cosine * pose.y,
                start.yaw + pose.yaw)
