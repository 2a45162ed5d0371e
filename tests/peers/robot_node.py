"""A robot that is not ours: a Husky in PyBullet behind ROS 2 nodes of rclpy, run by .peers/venv (make ros-peer).

Sends /image (Image rgb8), /depth (Image 32FC1), /odom, /imu, /battery_state and listens to /cmd_vel (TwistStamped) and
/cmd_vel_plain (Twist). /dock and /undock are actions of type test_msgs/action/Fibonacci, an action type that PyPI has.
Lines on standard input change it: silent TOPIC, speak TOPIC, dock succeed|abort|hang, encoding NAME, jump METRES, side
PIXELS, metres 32FC1|16UC1 (of depth), late SECONDS (after each image comes a black one, which is so much older).
It prints READY, HEARD for each such line, GOAL NAME as it takes a goal, and MOVE time speed rate where its velocity
changes.
"""

from __future__ import annotations

import math
import sys
import threading
import time

import numpy as np
import pybullet
import pybullet_data
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, Image, Imu
from test_msgs.action import Fibonacci

RATE, SEEN_EVERY, TIMEOUT = 20.0, 4, 0.5  # Hz of odometry; ticks between images; s without a command until it stops
BOXES = (((3, 3.1), (4.2, 0.1)), ((3, -3.1), (4.2, 0.1)), ((-1.2, 0), (0.1, 3.2)), ((7.2, 0), (0.1, 3.2)),
         ((4, 1.6), (0.4, 0.3)), ((5.5, -1), (0.3, 0.5)), ((2.5, -2.2), (0.3, 0.3)))  # centre and half sizes, m
FOV, NEAR, FAR, SIDE = 60.0, 0.05, 12.0, 64


class Robot(Node):
    """The Husky in a walled room of 8 x 6 m with three boxes, its dock at the origin, facing along x."""

    def __init__(self) -> None:
        super().__init__("peer_robot")
        self.world = pybullet.connect(pybullet.DIRECT)
        pybullet.setAdditionalSearchPath(pybullet_data.getDataPath())
        pybullet.setTimeStep(1.0 / (4 * RATE))
        pybullet.loadURDF("plane.urdf")
        self.husky = pybullet.loadURDF("husky/husky.urdf", [0, 0, 0.14], [0, 0, 1, 0])
        for at, half in BOXES:
            self.box(at, half)
        self.command, self.commanded, self.silent, self.docking = (0.0, 0.0), 0.0, set(), "succeed"
        self.encoding, self.offset, self.ticks, self.last, self.side = "rgb8", 0.0, 0, (0.0, 0.0), SIDE
        self.metres, self.late, self.sent = "32FC1", 0, (*self.pose(), 0.0)
        group = ReentrantCallbackGroup()
        self.out = {"image": self.create_publisher(Image, "/image", 5),
                    "depth": self.create_publisher(Image, "/depth", 5),
                    "odom": self.create_publisher(Odometry, "/odom", 10), "imu": self.create_publisher(Imu, "/imu", 10),
                    "battery": self.create_publisher(BatteryState, "/battery_state", 5)}
        self.create_subscription(TwistStamped, "/cmd_vel", lambda message: self.drive(message.twist), 10)
        self.create_subscription(Twist, "/cmd_vel_plain", self.drive, 10)
        for name in ("dock", "undock"):
            ActionServer(self, Fibonacci, f"/{name}", lambda goal, name=name: self.act(goal, name),
                         cancel_callback=lambda goal: CancelResponse.ACCEPT, callback_group=group)

    def box(self, at, half) -> None:
        size = [*half, 0.5]
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=size)
        colour = [0.3 + 0.1 * (abs(at[0]) % 6), 0.3 + 0.1 * (abs(at[1]) % 6), 0.5, 1]
        look = pybullet.createVisualShape(pybullet.GEOM_BOX, halfExtents=size, rgbaColor=colour)
        pybullet.createMultiBody(0, shape, look, [*at, 0.5])

    def drive(self, message: Twist) -> None:
        self.command = message.linear.x, message.angular.z
        self.commanded = time.monotonic()

    def act(self, goal, name: str):
        """Dock or undock: a second of work, then the outcome that was set."""
        print(f"GOAL {name}", flush=True)
        began = time.monotonic()
        while time.monotonic() < began + 1.0 or self.docking == "hang":
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result()
            time.sleep(0.05)
        if self.docking == "abort" and name == "dock":
            goal.abort()
        else:
            if name == "dock":
                self.go(0.0, 0.0)
                self.turn(math.pi)
            else:
                self.go(0.6, 0.0, ahead=-1)
                self.turn(0.0)
            goal.succeed()
        return Fibonacci.Result()

    def go(self, x: float, y: float, ahead: int = 1) -> None:
        """Turn to a place and drive there, or back there (ahead -1), so that odometry and gyro follow."""
        here_x, here_y, yaw = self.pose()
        away = math.hypot(x - here_x, y - here_y)
        if away > 0.01:
            yaw = math.atan2(ahead * (y - here_y), ahead * (x - here_x))
            self.turn(yaw)
        for share in np.linspace(0, 1, 2 + math.ceil(away / 0.03)):
            self.put(here_x + share * (x - here_x), here_y + share * (y - here_y), yaw)

    def turn(self, yaw: float) -> None:
        """Turn on the spot, at 0.5 rad/s: faster, and a gyro's message that is lost on a busy machine costs degrees."""
        x, y, begin = self.pose()
        swing = math.remainder(yaw - begin, 2 * math.pi)
        for share in np.linspace(0, 1, 2 + math.ceil(abs(swing) / 0.025)):
            self.put(x, y, begin + share * swing)

    def put(self, x: float, y: float, yaw: float) -> None:
        turn = pybullet.getQuaternionFromEuler([0, 0, yaw])
        pybullet.resetBasePositionAndOrientation(self.husky, [x, y, 0.14], turn)
        time.sleep(1.0 / RATE)

    def pose(self) -> tuple[float, float, float]:
        place, turn = pybullet.getBasePositionAndOrientation(self.husky)
        return place[0], place[1], pybullet.getEulerFromQuaternion(turn)[2]

    def tick(self) -> None:
        """A twentieth of a second: move, and send what there is to send."""
        if time.monotonic() > self.commanded + TIMEOUT:
            self.command = (0.0, 0.0)
        if self.command != self.last:
            self.last = self.command
            print(f"MOVE {time.monotonic():.3f} {self.command[0]:.3f} {self.command[1]:.3f}", flush=True)
        speed, rate = self.command
        for _ in range(4):
            yaw = self.pose()[2]
            down = pybullet.getBaseVelocity(self.husky)[0][2]
            pybullet.resetBaseVelocity(self.husky, [speed * math.cos(yaw), speed * math.sin(yaw), min(0.0, down)],
                                       [0, 0, rate])
            pybullet.stepSimulation()
        self.ticks += 1
        self.send()

    def send(self) -> None:
        (x, y, yaw), now = self.pose(), self.get_clock().now()
        before, seconds = self.sent[:3], max(1e-3, 1e-9 * now.nanoseconds - self.sent[3])
        self.sent = (x, y, yaw, 1e-9 * now.nanoseconds)
        turned = math.remainder(yaw - before[2], 2 * math.pi) / seconds
        stamp = now.to_msg()
        odom, imu = Odometry(), Imu()
        odom.header.stamp = imu.header.stamp = stamp
        odom.pose.pose.position.x, odom.pose.pose.position.y = x + self.offset, y
        odom.pose.pose.orientation.z, odom.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        odom.twist.twist.linear.x = math.hypot(x - before[0], y - before[1]) / seconds
        odom.twist.twist.angular.z = imu.angular_velocity.z = turned
        self.publish("odom", odom)
        self.publish("imu", imu)
        if self.ticks % SEEN_EVERY == 0:
            self.look(x, y, yaw, stamp)
            self.publish("battery", BatteryState(percentage=0.8))

    def look(self, x: float, y: float, yaw: float, stamp) -> None:
        side = self.side
        eye = [x + 0.5 * math.cos(yaw), y + 0.5 * math.sin(yaw), 0.45]
        ahead = [eye[0] + math.cos(yaw), eye[1] + math.sin(yaw), 0.45]
        _, _, colour, depth, _ = pybullet.getCameraImage(
            side, side, pybullet.computeViewMatrix(eye, ahead, [0, 0, 1]),
            pybullet.computeProjectionMatrixFOV(FOV, 1.0, NEAR, FAR), renderer=pybullet.ER_TINY_RENDERER)
        rgb = np.reshape(colour, (side, side, 4))[:, :, :3].astype(np.uint8)
        metres = FAR * NEAR / (FAR - (FAR - NEAR) * np.reshape(depth, (side, side)))
        rgb = rgb[:, :, ::-1] if self.encoding == "bgr8" else rgb
        self.publish("image", self.picture(rgb, self.encoding, 3 * side, stamp))
        if self.late:
            older = Time(sec=stamp.sec - self.late, nanosec=stamp.nanosec)
            self.publish("image", self.picture(np.zeros_like(rgb), self.encoding, 3 * side, older))
        depth = metres.astype(np.float32) if self.metres == "32FC1" else np.round(1000.0 * metres).astype(np.uint16)
        self.publish("depth", self.picture(depth, self.metres, depth.itemsize * side, stamp))

    @staticmethod
    def picture(pixels, encoding: str, step: int, stamp) -> Image:
        message = Image(encoding=encoding, height=len(pixels), width=len(pixels), step=step)
        message.header.stamp = stamp
        message.data = np.ascontiguousarray(pixels).tobytes()
        return message

    def publish(self, name: str, message) -> None:
        if name not in self.silent:
            self.out[name].publish(message)

    def obey(self, line: str) -> None:
        """A line of standard input."""
        verb, _, value = line.strip().partition(" ")
        if verb == "silent":
            self.silent.add(value)
        elif verb == "speak":
            self.silent.discard(value)
        elif verb == "dock":
            self.docking = value
        elif verb == "encoding":
            self.encoding = value
        elif verb == "side":
            self.side = int(value)
        elif verb == "metres":
            self.metres = value
        elif verb == "late":
            self.late = int(value)
        elif verb == "jump":
            self.offset += float(value)
        print(f"HEARD {verb}", flush=True)


def main() -> None:
    rclpy.init()
    robot = Robot()
    executor = MultiThreadedExecutor(4)
    executor.add_node(robot)
    threading.Thread(target=executor.spin, daemon=True).start()
    threading.Thread(target=lambda: [robot.obey(line) for line in sys.stdin], daemon=True).start()
    print("READY", flush=True)
    due = time.monotonic()
    while True:
        robot.tick()
        due = max(due + 1.0 / RATE, time.monotonic() - 0.2)
        time.sleep(max(0.0, due - time.monotonic()))


main()
