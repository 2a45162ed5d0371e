"""Processes of the real ROS 2 peer: the robot node and a rosbridge server, both of .peers/venv (make ros-peer)."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sysconfig
import time
from contextlib import suppress
from pathlib import Path

ROOT = Path(__file__).parents[2]
VENV = ROOT / ".peers" / "venv"
READY = ROOT / ".peers" / ".ready"


def ros_environment() -> dict[str, str]:
    """The environment of both processes: the wheels' libraries, and nothing beyond this machine."""
    packages = next(VENV.glob("lib/python3*/site-packages"))
    libraries = [VENV / "lib", *packages.glob("ros_*.libs")]
    return {**os.environ, "ROS_DISTRO": "jazzy", "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "RMW_IMPLEMENTATION": "rmw_fastrtps_cpp",
            "AMENT_PREFIX_PATH": str(VENV), "LD_LIBRARY_PATH": ":".join(map(str, libraries))}


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


class Bridge:
    """A rosbridge server alone. port: of the bridge on 127.0.0.1."""

    options: tuple[str, ...] = ("--no-rosapi",)

    def __init__(self, folder: Path) -> None:
        self.folder, self.port, self.environment = folder, free_port(), ros_environment()
        self.bridge = self.start_bridge()

    def start_bridge(self) -> subprocess.Popen:
        """Start the rosbridge server on the port."""
        binary = next(VENV.glob("lib/python3*/site-packages/rosbridge_server_rs/rosbridge_server_rs_jazzy"))
        library = Path(sysconfig.get_config_var("LIBDIR")) / sysconfig.get_config_var("INSTSONAME")
        with open(self.folder / "bridge.log", "ab") as log:
            bridge = subprocess.Popen([str(binary), "--bind", f"127.0.0.1:{self.port}", *self.options], stdout=log,
                                      stderr=log, env={**self.environment, "LD_PRELOAD": str(library)})
        self.wait(self.listening, "the bridge")
        return bridge

    def start(self, script: str, log: Path) -> subprocess.Popen:
        """Start a node of this folder in the peer's environment."""
        with open(log, "wb") as out, open(log.with_suffix(".error"), "wb") as errors:
            return subprocess.Popen([str(VENV / "bin" / "python"), str(Path(__file__).parent / script)],
                                    stdin=subprocess.PIPE, stdout=out, stderr=errors, env=self.environment)

    def listening(self) -> bool:
        try:
            socket.create_connection(("127.0.0.1", self.port), 1).close()
        except OSError:
            return False
        return True

    def wait(self, ready, what: str, seconds: float = 60.0) -> None:
        until = time.monotonic() + seconds
        while not ready():
            assert time.monotonic() < until, f"{what} did not start; see {self.folder}"
            time.sleep(0.1)

    def stop(self) -> None:
        end(self.bridge)


def end(process: subprocess.Popen) -> None:
    """Kill a process, also one that was stopped."""
    if process.poll() is None:
        process.send_signal(signal.SIGCONT)
        process.kill()
    process.wait()
    if process.stdin:
        with suppress(BrokenPipeError):
            process.stdin.close()


class Peer(Bridge):
    """A robot and its bridge. moves: (time, speed, rate) of its wheels."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self.log = folder / "robot.log"
        self.robot = self.start("robot_node.py", self.log)
        self.wait(lambda: b"READY" in self.log.read_bytes(), "the robot node")

    def tell(self, line: str) -> None:
        """Change the robot by a line (robot_node.py lists them), and wait until it has heard it."""
        assert self.robot.stdin
        heard = self.said("HEARD")
        self.robot.stdin.write(f"{line}\n".encode())
        self.robot.stdin.flush()
        self.wait(lambda: self.said("HEARD") > heard, f"the robot did not hear {line}; it")

    def said(self, word: str) -> int:
        """How many lines the robot has begun with a word."""
        return sum(line.startswith(word) for line in self.log.read_text(errors="replace").splitlines())

    @property
    def moves(self) -> list[tuple[float, float, float]]:
        lines = [line.split() for line in self.log.read_text(errors="replace").splitlines() if line.startswith("MOVE ")]
        return [(float(at), float(speed), float(rate)) for _, at, speed, rate in lines]

    def stop(self) -> None:
        end(self.bridge)
        end(self.robot)
