"""A client that is not ours: an rclpy node that drives whatever robot is there, run by .peers/venv.

It undocks and docks by the actions /undock and /dock (test_msgs/action/Fibonacci): to their end, cancelled after a
second, and from where no dock is seen; then it drives a hundred moves by velocity commands. It prints a line of JSON
for each action, {"action", "state"}, and for each message of /odom and /ground_truth, {"topic", "stamp", "pose"}.
"""

from __future__ import annotations

import json
import math
import random
import time

import rclpy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.node import Node
from test_msgs.action import Fibonacci

MOVES, LASTING, PERIOD = 100, 0.3, 0.05  # seconds of a move, and between two commands
STATES = {4: "succeeded", 5: "cancelled", 6: "aborted"}


class Client(Node):
    def __init__(self) -> None:
        super().__init__("some_client")
        self.out = self.create_publisher(TwistStamped, "/cmd_vel", 10)
        self.printing, self.heard = False, 0
        for topic in ("/odom", "/ground_truth"):
            self.create_subscription(Odometry, topic, lambda message, topic=topic: self.hear(topic, message), 50)
        self.actions = {name: ActionClient(self, Fibonacci, f"/{name}") for name in ("dock", "undock")}

    def hear(self, topic: str, message: Odometry) -> None:
        self.heard += 1
        place, turn, stamp = message.pose.pose.position, message.pose.pose.orientation, message.header.stamp
        yaw = 2.0 * math.atan2(turn.z, turn.w)
        print(json.dumps({"topic": topic, "stamp": [stamp.sec, stamp.nanosec], "pose": [place.x, place.y, yaw]}))

    def spin(self, seconds: float) -> None:
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            rclpy.spin_once(self, timeout_sec=0.01)

    def act(self, name: str, cancel_after: float = math.inf) -> None:
        """Send a goal, wait for its end and print how it ended."""
        client, cancelled = self.actions[name], None
        assert client.wait_for_server(90.0), name
        sent = client.send_goal_async(Fibonacci.Goal())
        rclpy.spin_until_future_complete(self, sent, timeout_sec=90.0)
        result, began = sent.result().get_result_async(), time.monotonic()
        while not result.done() and time.monotonic() < began + 240.0:
            if time.monotonic() > began + cancel_after:
                cancel_after = math.inf
                cancelled = sent.result().cancel_goal_async()
            rclpy.spin_once(self, timeout_sec=0.05)
        state = STATES.get(result.result().status, "?") if result.done() else "no result"
        print(json.dumps({"action": name, "state": state, "cancelled": bool(cancelled and cancelled.done())}))

    def move(self, speed: float, rate: float, seconds: float) -> None:
        message = TwistStamped()
        message.twist.linear.x, message.twist.angular.z = speed, rate
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            message.header.stamp = self.get_clock().now().to_msg()
            self.out.publish(message)
            self.spin(PERIOD)


def main() -> None:
    rclpy.init()
    client, draws = Client(), random.Random(0)
    until = time.monotonic() + 90.0
    while not client.heard and time.monotonic() < until:
        client.spin(0.2)
    client.act("undock")
    client.act("undock")  # it is not docked
    client.move(0.2, 0.0, 1.0)
    client.move(0.0, 0.8, math.pi / 0.8 / 2.0)
    client.act("dock", cancel_after=1.0)
    for _ in range(MOVES):
        straight = draws.random() < 0.6
        client.move(*((draws.uniform(0.1, 0.3), 0.0) if straight else (0.0, draws.choice([-0.8, 0.8]))), LASTING)
    client.spin(1.0)
    rclpy.shutdown()
    print(json.dumps({"ended": True}), flush=True)


main()
