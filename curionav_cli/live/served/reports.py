"""What a served robot sends: its state as ROS messages in JSON, by the last part of their type; the inverse of what
messages.py, images.py and contacts.py read."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np

from curionav_cli.errors import ConfigError
from curionav_cli.live.contacts import (
    CREATE_HAZARDS,
    KOBUKI_CHARGING,
    KOBUKI_EMPTY,
    KOBUKI_FULL,
    SIDES,
    SUPPLY_CHARGING,
    SUPPLY_DISCHARGING,
)
from curionav_cli.live.messages import stamp
from curionav_cli.live.served.body import TICK, ServedBody
from curionav_cli.live.transport import Message
from curionav_cli.records import Pose

BASE, ODOM, SCANNER, CAMERA, MAP = "base_link", "odom", "scanner", "camera", "map"  # frames
FULL_VOLTS, NO_COVARIANCE = 16.0, -1.0  # sensor_msgs: -1 says that a quantity is not measured


class Moment(NamedTuple):
    """A served robot at a time. seconds: of the stamps; ros: 1 or 2; views: image and depth of the camera, which is
    rendered when one of them is asked for; turned: radians to the left by which the scanner looks away from ahead;
    side: of the bumper, that of an event."""

    body: ServedBody
    seconds: float
    ros: int
    views: Callable[[], tuple[np.ndarray, np.ndarray]]
    turned: float
    side: str = "centre"

    def header(self, frame: str) -> Message:
        return {"header": {**stamp(self.seconds, self.ros), "frame_id": frame}}


def odometry(now: Moment) -> Message:
    """nav_msgs/Odometry by wheels and gyro."""
    reading = now.body.reading
    return moving(now, ODOM, now.body.odometry, reading.wheel / TICK, reading.gyro / TICK)


def ground_truth(now: Moment) -> Message:
    """nav_msgs/Odometry of the true pose, in the frame of the scene or map."""
    return moving(now, MAP, now.body.body.pose, *now.body.velocity)


def moving(now: Moment, frame: str, pose: Pose, speed: float, rate: float) -> Message:
    twist = {"linear": vector(speed), "angular": vector(0.0, 0.0, rate)}
    placed = {"position": vector(pose.x, pose.y), "orientation": quaternion(pose.yaw)}
    return {**now.header(frame), "child_frame_id": BASE, "pose": {"pose": placed}, "twist": {"twist": twist}}


def vector(x: float, y: float = 0.0, z: float = 0.0) -> Message:
    return {"x": x, "y": y, "z": z}


def quaternion(yaw: float) -> Message:
    return {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * yaw), "w": math.cos(0.5 * yaw)}


def gyro(now: Moment) -> Message:
    """sensor_msgs/Imu of a gyro alone."""
    unknown = [NO_COVARIANCE] + [0.0] * 8
    return {**now.header(BASE), "angular_velocity": vector(0.0, 0.0, now.body.rate()),
            "orientation": quaternion(0.0), "orientation_covariance": unknown,
            "linear_acceleration_covariance": unknown}


def compressed(now: Moment) -> Message:
    """sensor_msgs/CompressedImage, PNG, which loses nothing."""
    raw = cv2.imencode(".png", cv2.cvtColor(now.views()[0], cv2.COLOR_RGB2BGR))[1].tobytes()
    return {**now.header(CAMERA), "format": "png", "data": base64.b64encode(raw).decode()}


def colour(now: Moment) -> Message:
    """sensor_msgs/Image, rgb8."""
    return picture(now, now.views()[0], "rgb8")


def depth(now: Moment) -> Message:
    """sensor_msgs/Image, 32FC1: metres along the optical axis."""
    return picture(now, now.views()[1].astype("<f4"), "32FC1")


def picture(now: Moment, pixels: np.ndarray, encoding: str) -> Message:
    height, width = pixels.shape[:2]
    data = base64.b64encode(np.ascontiguousarray(pixels).tobytes()).decode()
    return {**now.header(CAMERA), "height": height, "width": width, "encoding": encoding, "is_bigendian": 0,
            "step": pixels.nbytes // height, "data": data}


def laser(now: Moment) -> Message:
    """sensor_msgs/LaserScan. No return is a range beyond the largest: JSON has no inf."""
    scan, rays = now.body.scan(), now.body.profile.lidar
    least, step = float(scan.bearing[0]) - now.turned, float(scan.bearing[1] - scan.bearing[0])
    found = np.where(np.isfinite(scan.range), scan.range, rays.far + 1.0)
    return {**now.header(SCANNER), "angle_min": least, "angle_max": least + step * (len(found) - 1),
            "angle_increment": step, "range_min": rays.blind, "range_max": rays.far, "ranges": found.tolist()}


def battery(now: Moment) -> Message:
    """sensor_msgs/BatteryState."""
    status = SUPPLY_CHARGING if now.body.charging else SUPPLY_DISCHARGING
    return {**now.header(BASE), "percentage": share(now), "voltage": FULL_VOLTS, "present": True,
            "power_supply_status": status}


def share(now: Moment) -> float:
    return now.body.battery.left / now.body.battery.capacity


def kobuki_state(now: Moment) -> Message:
    """kobuki_msgs/SensorState: the battery's voltage in tenths, and whether it charges."""
    volts = KOBUKI_EMPTY + (KOBUKI_FULL - KOBUKI_EMPTY) * share(now)
    return {**now.header(BASE), "battery": round(10.0 * volts), "charger": KOBUKI_CHARGING[1] * now.body.charging}


def turtlebot3_state(now: Moment) -> Message:
    """turtlebot3_msgs/SensorState: 1 where the bumper's front is pressed."""
    return {**now.header(BASE), "bumper": int(now.body.reading.bump is not None)}


def dock_status(now: Moment) -> Message:
    """irobot_create_msgs/DockStatus."""
    return {**now.header(BASE), "is_docked": now.body.charging, "dock_visible": now.body.sees_dock}


def kobuki_bumper(now: Moment) -> Message:
    """kobuki_msgs/BumperEvent: a third of the bumper is pressed now, or let go."""
    return {"bumper": SIDES.index(now.side), "state": int(now.body.reading.bump == now.side)}


def kobuki_quiet(now: Moment) -> Message:
    """kobuki_msgs/CliffEvent and WheelDropEvent: a simulated floor has no cliff."""
    return {"sensor": 0, "wheel": 0, "state": 0}


def light(now: Moment) -> Message:
    """std_msgs/UInt8MultiArray: a frame of the right, the centre and the left receiver."""
    return {"data": base64.b64encode(bytes(now.body.infrared.frame(now.body.body.pose))).decode()}


def kobuki_light(now: Moment) -> Message:
    """kobuki_msgs/DockInfraRed: the same."""
    return {**now.header(BASE), **light(now)}


def hazards(now: Moment) -> Message:
    """irobot_create_msgs/HazardDetectionVector."""
    kind = next(number for number, name in CREATE_HAZARDS.items() if name == "bumper")
    bump = now.body.reading.bump
    found = [{**now.header(f"bump_front_{bump}".replace("centre", "center")), "type": kind}] if bump else []
    return {**now.header(BASE), "detections": found}


def frames(now: Moment) -> Message:
    """tf2_msgs/TFMessage: odometry to base, base to scanner and camera."""
    here = now.body.odometry
    camera = now.body.scene.camera
    placed = ((ODOM, BASE, vector(here.x, here.y), here.yaw), (BASE, SCANNER, vector(0.0), now.turned),
              (BASE, CAMERA, vector(0.0, 0.0, camera), 0.0))
    return {"transforms": [{**now.header(parent), "child_frame_id": child,
                            "transform": {"translation": at, "rotation": quaternion(yaw)}}
                           for parent, child, at, yaw in placed]}


def clock(now: Moment) -> Message:
    """rosgraph_msgs/Clock, for nodes with use_sim_time."""
    return {"clock": stamp(now.seconds, now.ros)["stamp"]}


Writer = Callable[[Moment], Message]
POWER: dict[str, Writer] = {"BatteryState": battery, "SensorState": kobuki_state}
TOUCH: dict[str, Writer] = {"BumperEvent": kobuki_bumper, "CliffEvent": kobuki_quiet, "WheelDropEvent": kobuki_quiet,
                            "HazardDetectionVector": hazards, "SensorState": turtlebot3_state}
WRITERS: dict[str, dict[str, Writer]] = {
    "image": {"CompressedImage": compressed, "Image": colour}, "depth": {"Image": depth}, "scan": {"LaserScan": laser},
    "odom": {"Odometry": odometry}, "imu": {"Imu": gyro}, "battery": POWER,
    "docked": {"DockStatus": dock_status, "SensorState": kobuki_state, "BatteryState": battery}, "contact": TOUCH,
    "dock_ir": {"DockInfraRed": kobuki_light, "UInt8MultiArray": light},
    "truth": {"Odometry": ground_truth}, "frames": {"TFMessage": frames}, "clock": {"Clock": clock}}


def writer(key: str, kind: str) -> Writer:
    """What writes the messages of a topic of the profile. Raises ConfigError for a type that is not known."""
    known = WRITERS[key.partition(" ")[0]]
    name = kind.rpartition("/")[2]
    if name not in known:
        raise ConfigError(f"robot.profile: {key} of type {kind} cannot be served; known are {', '.join(known)}.")
    return known[name]
