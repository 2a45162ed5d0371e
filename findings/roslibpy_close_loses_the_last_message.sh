#!/usr/bin/env bash
# Guess: Ros.close() waits until the connection is closed, and what was published before it has arrived by then.
# What happens: it returns while the messages and the closing are still queued for the network thread; a program that
# ends there loses its last message, such as "stop". roslibpy 2.1.0 (autobahn 25.12.2), 2026-11-30.
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
            print(message["msg"]["data"][:4], flush=True)


factory = WebSocketServerFactory()
factory.protocol = Bridge
reactor.listenTCP(int(sys.argv[1]), factory, interface="127.0.0.1")
reactor.run()
PYTHON

cat > client.py <<'PYTHON'
import os
import sys
import time

import roslibpy

ros = roslibpy.Ros("127.0.0.1", int(sys.argv[1]))
ros.run(20)
topic = roslibpy.Topic(ros, "/said", "std_msgs/String")
topic.advertise()
topic.publish(roslibpy.Message({"data": "go"}))
time.sleep(1.0)
topic.publish(roslibpy.Message({"data": "x" * 1_000_000}))  # an image, which takes the network thread a moment
topic.publish(roslibpy.Message({"data": "stop"}))
ros.close()
print("after close() is_connected is", ros.is_connected, flush=True)
if sys.argv[2] == "wait":
    time.sleep(3.0)
os._exit(0)  # what SIGKILL or the end of a program with a daemon thread does
PYTHON

venv/bin/python - <<'PYTHON'
import socket
import subprocess
import sys
import time
from importlib.metadata import version

print("roslibpy", version("roslibpy"))


def arrived(how):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    server = subprocess.Popen([sys.executable, "server.py", str(port)], stdout=subprocess.PIPE, text=True)
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            break
        except OSError:
            time.sleep(0.1)
    subprocess.run([sys.executable, "client.py", str(port), how], check=True, timeout=60)
    time.sleep(1.0)
    server.kill()
    return server.stdout.read().split()


at_once, waited = arrived("at once"), arrived("wait")
print("ended at once:", at_once)
print("three seconds later:", waited)
assert waited == ["go", "xxxx", "stop"] and "stop" not in at_once and "go" in at_once
PYTHON
