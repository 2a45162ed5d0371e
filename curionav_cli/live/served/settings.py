"""How a simulated robot is served."""

from __future__ import annotations

from dataclasses import dataclass, replace

from curionav_cli.bounds import bounded
from curionav_cli.robot.settings import Drive, Gyro, Odometry, Turtlebot

PERFECT = Drive(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Odometry(0.0, 0.0), Gyro(0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Serving:
    """speed: simulated seconds a second. images: images and depth images a simulated second. recharge: seconds on the
    dock that fill the battery. exact: motion and sensors without errors."""

    speed: float = 1.0
    images: float = 10.0
    recharge: float = 60.0
    exact: bool = False

    def __post_init__(self) -> None:
        bounded("serve", self, {"speed": (0.01, 100), "images": (0.1, 50), "recharge": (1, 10**6)})


def without_errors(profile: Turtlebot) -> Turtlebot:
    """The same robot with perfect motion and sensors."""
    drive, odometry, gyro = PERFECT
    return replace(profile, drive=drive, odometry=odometry, gyro=gyro, lidar=replace(profile.lidar, noise=0.0),
                   depth=replace(profile.depth, noise=0.0))
