"""Messages as rosbridge writes them: what they say, and one line for those that cannot be used."""

from __future__ import annotations

import base64
import math

import cv2
import numpy as np
import pytest

from curionav_cli.live import contacts, images, messages
from curionav_cli.live.safety import MessageFault
from curionav_cli.live.travel import Travel


def image_message(pixels: np.ndarray, encoding: str, padding: int = 0, **changes) -> dict:
    height, width = pixels.shape[:2]
    rows = pixels.reshape(height, -1).view(np.uint8)
    padded = np.pad(rows, ((0, 0), (0, padding)))
    return {"encoding": encoding, "height": height, "width": width, "step": padded.shape[1], "is_bigendian": 0,
            "data": base64.b64encode(padded.tobytes()).decode(), **changes}


COLOUR = np.full((40, 60, 3), (200, 100, 50), np.uint8)


@pytest.mark.parametrize(("pixels", "encoding"), [
    (COLOUR, "rgb8"), (COLOUR[:, :, ::-1].copy(), "bgr8"),
    (cv2.cvtColor(COLOUR, cv2.COLOR_RGB2RGBA), "rgba8"), (cv2.cvtColor(COLOUR, cv2.COLOR_RGB2BGRA), "bgra8"),
])
def test_every_encoding_gives_the_same_picture(pixels: np.ndarray, encoding: str) -> None:
    found = images.picture(image_message(pixels, encoding, padding=4), "sensor_msgs/msg/Image", 1.0)
    assert found.shape == (64, 64, 3) and found.dtype == np.uint8 and (found == (200, 100, 50)).all()


def test_grey_images_have_three_equal_channels() -> None:
    found = images.picture(image_message(np.full((10, 10), 77, np.uint8), "mono8"), "sensor_msgs/Image", 1.0)
    assert (found == 77).all() and found.shape == (64, 64, 3)


def test_compressed_images_are_rgb_whatever_their_size() -> None:
    for shape in ((40, 60, 3), (240, 320, 3)):
        pixels = np.full(shape, (200, 100, 50), np.uint8)
        raw = cv2.imencode(".jpg", pixels[:, :, ::-1])[1].tobytes()
        message = {"format": "rgb8; jpeg compressed bgr8", "data": base64.b64encode(raw).decode()}
        found = images.picture(message, "sensor_msgs/msg/CompressedImage", 1.0)
        assert np.abs(found.astype(int) - (200, 100, 50)).max() < 6


def test_the_crop_is_the_square_in_the_middle() -> None:
    pixels = np.zeros((40, 80, 3), np.uint8)
    pixels[10:30, 30:50] = 255
    assert images.picture(image_message(pixels, "rgb8"), "sensor_msgs/Image", 0.5).min() == 255
    assert images.picture(image_message(pixels, "rgb8"), "sensor_msgs/Image", 1.0).min() == 0


def test_depth_in_millimetres_and_in_metres_is_the_same() -> None:
    metres = np.linspace(0.5, 5.0, 64 * 64, dtype=np.float32).reshape(64, 64)
    short = np.round(1000 * metres).astype(np.uint16)
    one = images.depth(image_message(metres, "32FC1"), "sensor_msgs/Image", 1.0)
    two = images.depth(image_message(short, "16UC1"), "sensor_msgs/Image", 1.0)
    big = images.depth(image_message(short.astype(">u2"), "16UC1", is_bigendian=1), "sensor_msgs/Image", 1.0)
    assert one.dtype == np.float32
    np.testing.assert_allclose(one, metres)
    np.testing.assert_allclose(two, metres, atol=6e-4)
    np.testing.assert_array_equal(two, big)


def test_depth_that_was_not_measured_is_far() -> None:
    metres = np.full((64, 64), 2.0, np.float32)
    metres[0, :4] = np.nan, np.inf, 0.0, 50.0
    found = images.depth(image_message(metres, "32FC1"), "sensor_msgs/Image", 1.0)
    assert found[0, :4].tolist() == [10.0] * 4 and (found[1:] == 2.0).all()


@pytest.mark.parametrize(("message", "words"), [
    (image_message(COLOUR, "yuv422"), "encoding 'yuv422'"),
    (image_message(COLOUR, "rgb8", height=4000), "bytes"),
    (image_message(COLOUR, "rgb8", height=-1), "-1 pixels"),
    (image_message(COLOUR, "rgb8", data="%%%"), "no sensor_msgs/msg/Image"),
    ({"data": "AAAA", "format": "jpeg"}, "no sensor_msgs/msg/Image (KeyError"),
])
def test_an_image_that_cannot_be_used_is_answered_in_a_line(message: dict, words: str) -> None:
    with pytest.raises(MessageFault) as caught:
        images.picture(message, "sensor_msgs/msg/Image", 1.0)
    assert words in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("data", ["", base64.b64encode(b"no picture").decode()])
def test_a_broken_compressed_image_is_answered_in_a_line(data: str) -> None:
    with pytest.raises(MessageFault):
        images.picture({"format": "jpeg", "data": data}, "sensor_msgs/msg/CompressedImage", 1.0)


def test_depth_of_a_colour_image_is_refused() -> None:
    with pytest.raises(MessageFault, match="depth with encoding 'rgb8'"):
        images.depth(image_message(COLOUR, "rgb8"), "sensor_msgs/Image", 1.0)


def odometry_message(yaw: float, **stamp: int) -> dict:
    return {"header": {"stamp": stamp}, "twist": {"twist": {"linear": {"x": 0.1}, "angular": {"z": -0.2}}},
            "pose": {"pose": {"position": {"x": 1.0, "y": -2.0},
                              "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}}}}


@pytest.mark.parametrize("stamp", [{"sec": 5, "nanosec": 250_000_000}, {"secs": 5, "nsecs": 250_000_000}])
def test_odometry_of_both_generations(stamp: dict) -> None:
    found = messages.odometry(odometry_message(2.5, **stamp))
    assert found == pytest.approx((1.0, -2.0, 2.5, 0.1, -0.2, 5.25))


def test_odometry_that_is_not_finite_or_no_odometry_is_refused() -> None:
    broken = odometry_message(0.0, sec=1, nanosec=0)
    broken["pose"]["pose"]["position"]["x"] = math.nan
    for message in (broken, {"header": {"stamp": {"sec": 1, "nanosec": 0}}}, {"pose": None}):
        with pytest.raises(MessageFault):
            messages.odometry(message)


def test_a_scan_turned_on_its_robot_and_its_gaps() -> None:
    scan = messages.laser({
        "header": {"stamp": {"sec": 1, "nanosec": 0}}, "angle_min": -math.pi / 2, "angle_increment": math.pi / 2,
        "range_min": 0.2, "range_max": 8.0, "ranges": [1.0, None, 0.1, 9.0]}, math.pi / 2)
    np.testing.assert_allclose(np.abs(scan.bearing), [0.0, math.pi / 2, math.pi, math.pi / 2], atol=1e-9)
    assert scan.range[0] == 1.0 and np.isnan(scan.range[1:]).all()


def test_velocity_commands_with_and_without_a_header() -> None:
    plain = messages.twist(0.1, -0.2, False, 7.5, 2)
    assert plain["linear"]["x"] == 0.1 and plain["angular"]["z"] == -0.2 and "header" not in plain
    assert messages.twist(0.1, -0.2, True, 7.5, 2)["twist"] == plain
    assert messages.twist(0.1, 0.0, True, 7.5, 2)["header"]["stamp"] == {"sec": 7, "nanosec": 500_000_000}
    assert messages.twist(0.1, 0.0, True, 7.5, 1)["header"]["stamp"] == {"secs": 7, "nsecs": 500_000_000}


@pytest.mark.parametrize(("kind", "message", "found"), [
    ("kobuki_msgs/BumperEvent", {"bumper": 1, "state": 1}, {"bumper_centre": True}),
    ("kobuki_msgs/CliffEvent", {"sensor": 2, "state": 0, "bottom": 5}, {"cliff_2": False}),
    ("kobuki_msgs/WheelDropEvent", {"wheel": 0, "state": 1}, {"wheel_drop_0": True}),
    ("irobot_create_msgs/msg/HazardDetectionVector",
     {"detections": [{"type": 2}, {"type": 0}, {"type": 1, "header": {"frame_id": "bump_front_left"}}]},
     {"bumper_left": True, "bumper_centre": False, "bumper_right": False, "cliff": True, "stall": False,
      "wheel_drop": False}),
    ("turtlebot3_msgs/msg/SensorState", {"bumper": 0}, {"bumper": False}),
])
def test_contacts_of_every_maker(kind: str, message: dict, found: dict) -> None:
    assert contacts.touches(message, kind) == found


def test_contacts_of_an_unknown_type_are_answered_with_those_that_are_known() -> None:
    with pytest.raises(MessageFault, match=r"std_msgs/msg/Bool; known are BumperEvent"):
        contacts.touches({"data": True}, "std_msgs/msg/Bool")


@pytest.mark.parametrize(("kind", "message", "share"), [
    ("sensor_msgs/msg/BatteryState", {"percentage": 0.42}, 0.42),
    ("sensor_msgs/msg/BatteryState", {"percentage": 42.0}, 0.42),
    ("sensor_msgs/msg/BatteryState", {"percentage": None}, None), ("kobuki_msgs/SensorState", {"battery": 165}, 1.0),
    ("kobuki_msgs/SensorState", {"battery": 120}, 0.0),
])
def test_the_battery(kind: str, message: dict, share: float | None) -> None:
    assert contacts.charge(message, kind) == (None if share is None else pytest.approx(share))


def test_a_gyro_whose_messages_come_irregularly_turns_as_far_as_the_robot() -> None:
    """Bursts after a pause, as of a busy machine: the mean rate of each interval, some of them late or twice."""
    travel, before = Travel(gyro=True), (10.0, 0.0)
    for at, yaw in ((10.05, 0.0), (10.3, 0.5), (10.305, 0.52), (10.31, 0.9), (10.6, 1.0), (10.6, 7.0), (10.5, 7.0)):
        rate = (yaw - before[1]) / max(at - before[0], 1e-3)
        travel.add_gyro({"header": messages.stamp(at, 2), "angular_velocity": {"z": rate}})
        before = max(before, (at, yaw)) if at > before[0] else before
    assert travel.by_gyro == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("data", ["CAIQ", [8, 2, 16]])
def test_the_light_of_the_dock_is_that_of_the_right_the_centre_and_the_left_receiver(data) -> None:
    assert contacts.dock_light({"data": data}, "kobuki_msgs/DockInfraRed") == (8, 2, 16)
    with pytest.raises(MessageFault, match="no kobuki_msgs/DockInfraRed"):
        contacts.dock_light({"data": data[:2]}, "kobuki_msgs/DockInfraRed")


def test_docks() -> None:
    assert contacts.docked({"is_docked": True, "dock_visible": True}, "irobot_create_msgs/msg/DockStatus")
    assert contacts.docked({"charger": 6}, "kobuki_msgs/SensorState")
    assert not contacts.docked({"charger": 0}, "kobuki_msgs/SensorState")
    supply = [contacts.docked({"power_supply_status": status}, "sensor_msgs/msg/BatteryState") for status in range(5)]
    assert supply == [False, True, False, False, True]
