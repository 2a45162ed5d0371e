#!/usr/bin/env bash
# Guess: Topic.publish without a connection raises or drops the message; with queue_size=1 at most the newest is kept.
# What happens: each message is kept for ever, whatever queue_size says, and all are sent in a burst once the server is
# back, so that a robot carries out velocity commands of long ago. roslibpy 2.1.0 (autobahn 25.12.2), 2026-11-30.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check roslibpy==2.1.0 autobahn==25.12.2

cat > server.py <<'PYTHON'
import json
import sys

from autobahn.twisted.websocket import WebSocketServerFactory, WebSocketServerProtocol
from twisted.internet import reactor


class Bridge(WebSocketServerProtocol):
    def onMessage(self, payload, binary):
        message = json.loads(payload)
        if message["op"] == "publish":
            print(message["msg"]["linear"]["x"], flush=True)


factory = WebSocketServerFactory()
factory.protocol = Bridge
reactor.listenTCP(int(sys.argv[1]), factory, interface="127.0.0.1")
reactor.run()
PYTHON

venv/bin/python - <<'PYTHON'
import socket
import subprocess
import sys
import time
from importlib.metadata import version

import roslibpy

print("roslibpy", version("roslibpy"))
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]


def server():
    started = subprocess.Popen([sys.executable, "server.py", str(port)], stdout=subprocess.PIPE, text=True)
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            return started
        except OSError:
            time.sleep(0.1)


first = server()
ros = roslibpy.Ros("127.0.0.1", port)
ros.factory.maxDelay = 1.0
ros.run(20)
topic = roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/Twist", queue_size=1)
topic.advertise()
first.kill()
first.wait()
while ros.is_connected:
    time.sleep(0.1)
for speed in range(1, 11):
    topic.publish(roslibpy.Message({"linear": {"x": 0.1 * speed}}))
print("10 commands were published without a connection, and none raised")
time.sleep(3.0)
second = server()
until = time.monotonic() + 30.0
while not ros.is_connected and time.monotonic() < until:
    time.sleep(0.1)
time.sleep(2.0)
second.kill()
arrived = [round(float(line), 1) for line in second.stdout.read().split()]
print("the new server received", arrived)
assert sorted(arrived) == [round(0.1 * speed, 1) for speed in range(1, 11)]
PYTHON
