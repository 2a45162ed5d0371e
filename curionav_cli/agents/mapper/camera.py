"""The depth camera of the robot (robot.depth_camera), under the name by which agents import it."""

from curionav_cli.robot.depth_camera import DepthCamera

__all__ = ["DepthCamera"]
