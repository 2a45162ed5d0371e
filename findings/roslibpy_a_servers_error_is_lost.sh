#!/usr/bin/env bash
# Guess: a rosbridge server's {"op": "status", "level": "error"} can be had by a callback, or is at least in the log.
# What happens: the message is skipped with the log line 'No handler registered for operation "status"', its text is
# nowhere, and register_message_handlers("status", ...) is refused as a second one. roslibpy 2.1.0, 2026-11-30.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check roslibpy==2.1.0 autobahn==25.12.2

venv/bin/python - <<'PYTHON'
import json
import logging
from importlib.metadata import version

from roslibpy.comm import RosBridgeException
from roslibpy.comm.comm_autobahn import AutobahnRosBridgeProtocol

print("roslibpy", version("roslibpy"))
lines = []
handler = logging.Handler()
handler.emit = lambda record: lines.append(logging.Formatter().format(record))
logging.getLogger("roslibpy").addHandler(handler)
logging.getLogger("roslibpy").setLevel(logging.DEBUG)

protocol = AutobahnRosBridgeProtocol()
error = {"op": "status", "level": "error", "id": "subscribe:/odom:6",
         "msg": "/odom has another type: nav_msgs/msg/Odometry"}
protocol.onMessage(json.dumps(error).encode(), False)
print("the log's last line:", lines[-1].splitlines()[-1])
assert 'No handler registered for operation "status"' in lines[-1]
assert not any("another type" in line for line in lines)
try:
    protocol.register_message_handlers("status", print)
    raise SystemExit("a handler can be registered now")
except RosBridgeException as refusal:
    print("register_message_handlers:", refusal.args[0])
PYTHON
