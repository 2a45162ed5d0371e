"""Bumpers, cliffs, wheel drops, docks and batteries: each maker's messages, by the last part of their type."""

from __future__ import annotations

from collections.abc import Callable

from curionav_cli.live.messages import expected, raw_bytes
from curionav_cli.live.safety import MessageFault
from curionav_cli.live.transport import Message
from curionav_cli.robot.measurements import Signals

KOBUKI_EMPTY, KOBUKI_FULL = 13.2, 16.5  # volts
KOBUKI_CHARGING = (2, 6)  # SensorState.charger on the dock: charged, charging
SUPPLY_CHARGING, SUPPLY_DISCHARGING, SUPPLY_FULL = 1, 2, 4  # BatteryState.power_supply_status
CREATE_HAZARDS = {1: "bumper", 2: "cliff", 3: "stall", 4: "wheel_drop"}  # HazardDetection.type
SIDES = ("left", "centre", "right")  # of the bumper, in the order of kobuki_msgs/BumperEvent

Touches = Callable[[Message], dict[str, bool]]


def kobuki_bumper(message: Message) -> dict[str, bool]:
    """kobuki_msgs/BumperEvent: one of three bumpers is pressed or let go."""
    return {f"bumper_{SIDES[int(message['bumper'])]}": int(message["state"]) == 1}


def kobuki_cliff(message: Message) -> dict[str, bool]:
    """kobuki_msgs/CliffEvent: one of three sensors sees no floor, or sees it again."""
    return {f"cliff_{int(message['sensor'])}": int(message["state"]) == 1}


def kobuki_wheel(message: Message) -> dict[str, bool]:
    """kobuki_msgs/WheelDropEvent: a wheel hangs, or stands again."""
    return {f"wheel_drop_{int(message['wheel'])}": int(message["state"]) == 1}


def create_hazards(message: Message) -> dict[str, bool]:
    """irobot_create_msgs/HazardDetectionVector: everything that is wrong now."""
    now = {create_hazard(one) for one in message["detections"]}
    others = [name for name in CREATE_HAZARDS.values() if name != "bumper"]
    return {name: name in now for name in (*map("bumper_{}".format, SIDES), *others)}


def create_hazard(one: Message) -> str:
    """The name of an irobot_create_msgs/HazardDetection, a bumper's with its side, which its frame tells (such as
    bump_front_left); empty for one that stops no move."""
    name, frame = CREATE_HAZARDS.get(int(one["type"]), ""), str(one.get("header", {}).get("frame_id", ""))
    return name if name != "bumper" else f"bumper_{next((side for side in SIDES if frame.endswith(side)), 'centre')}"


def side_of(touched: set[str]) -> str | None:
    """Where something was touched, as Reading.bump has it: the middle where that is not told; None for nothing."""
    return next((side for side in SIDES if f"bumper_{side}" in touched), "centre") if touched else None


def turtlebot3_state(message: Message) -> dict[str, bool]:
    """turtlebot3_msgs/SensorState; a robot without these sensors sends zeros."""
    return {"bumper": int(message["bumper"]) != 0}


CONTACTS: dict[str, Touches] = {
    "BumperEvent": kobuki_bumper, "CliffEvent": kobuki_cliff, "WheelDropEvent": kobuki_wheel,
    "HazardDetectionVector": create_hazards, "SensorState": turtlebot3_state,
}


def touches(message: Message, kind: str) -> dict[str, bool]:
    """What is touched or missing under the wheels, by name. Raises MessageFault for a type that is not known."""
    name = kind.rpartition("/")[2]
    if name not in CONTACTS:
        raise MessageFault(f"contacts of type {kind}; known are {', '.join(CONTACTS)}")
    with expected(kind):
        return CONTACTS[name](message)


def charge(message: Message, kind: str) -> float | None:
    """The share of its charge that a battery has, or None where it does not say."""
    with expected(kind):
        if kind.endswith("/SensorState"):
            volts = 0.1 * float(message["battery"])
            share = (volts - KOBUKI_EMPTY) / (KOBUKI_FULL - KOBUKI_EMPTY)
        else:
            if message["percentage"] is None:
                return None
            share = float(message["percentage"])
            share = share / 100.0 if share > 1.0 else share  # some drivers count to 100
    return min(1.0, max(0.0, share)) if share == share else None


def dock_light(message: Message, kind: str) -> Signals:
    """What the infrared receivers see: bits of the right, the centre and the left one.

    kobuki_msgs/DockInfraRed, or std_msgs/UInt8MultiArray with the same three bytes.
    """
    with expected(kind):
        right, centre, left = raw_bytes(message["data"])
    return right, centre, left


def docked(message: Message, kind: str) -> bool:
    """Whether the robot stands on its dock."""
    with expected(kind):
        if kind.endswith("/SensorState"):
            return int(message["charger"]) in KOBUKI_CHARGING
        if kind.endswith("/BatteryState"):
            return int(message["power_supply_status"]) in (SUPPLY_CHARGING, SUPPLY_FULL)
        return bool(message["is_docked"])
