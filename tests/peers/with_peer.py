"""Start the robot that is not ours and its rosbridge server, run a command with them, and end both.

    .venv/bin/python tests/peers/with_peer.py [--log DIR] COMMAND...

COMMAND gets robot.host and robot.port as its last words. Without one the robot stays until Ctrl-C.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from tempfile import mkdtemp

from ros_peer import READY, Peer


def main() -> int:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--log", type=Path, help="a folder for what the robot and the server print")
    asked.add_argument("command", nargs=argparse.REMAINDER)
    words = asked.parse_args()
    if not READY.exists():
        print("There is no ROS 2 peer. Install it: make ros-peer", file=sys.stderr)
        return 2
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(128 + number))
    folder = words.log or Path(mkdtemp(prefix="curionav_peer_"))
    folder.mkdir(parents=True, exist_ok=True)
    peer = Peer(folder)
    try:
        return run(words.command, ["robot.host=127.0.0.1", f"robot.port={peer.port}"])
    finally:
        peer.stop()


def run(command: list[str], where: list[str]) -> int:
    """Run a command to its end, which Ctrl-C asks of it, not of us; returns its exit code."""
    print("The peer is at", *where, flush=True)
    if not command:
        with suppress(KeyboardInterrupt):
            signal.pause()
        return 0
    child = subprocess.Popen([*command, *where])
    try:
        while True:
            with suppress(KeyboardInterrupt):
                return child.wait()
    finally:
        child.terminate()  # after a SIGTERM; a child that has ended stays as it is
        child.wait()


if __name__ == "__main__":
    sys.exit(main())
