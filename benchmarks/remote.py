"""What the remote pipeline costs: python benchmarks/remote.py [bytes] [dock] [robots]. Prints Markdown; 80 CPU-seconds.

    bytes    episodes as they are uploaded, against their raw arrays, and compressed harder
    dock     seconds on the wall from docking to new weights but for the learning itself, at rclone's S3 server on
             loopback, plainly and with the robot behind a link of 20 Mbit/s
    robots   how many robots one server learns for: CPU-seconds of its round against the seconds of a robot's episode

LBS Dreamer as scale=cpu has it, in the small room, 500 steps; robot and server take turns in one process.
"""

from __future__ import annotations

import io
import os
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import zipfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from hydra.types import RunMode

from curionav_cli import build
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import as_settings
from curionav_cli.config.sources import MAIN, opened
from curionav_cli.loop import LocalLearner, run_episode
from curionav_cli.records import Episode
from curionav_cli.remote.inbox import Arrival, Inbox
from curionav_cli.remote.ledger import Ledger
from curionav_cli.remote.object_store import ObjectStore
from curionav_cli.remote.outbox import Outbox
from curionav_cli.remote.protocol import fingerprint
from curionav_cli.remote.robot_sync import RobotSync, Time
from curionav_cli.remote.training_server import TrainingServer
from curionav_cli.remote.weight_cache import WeightCache
from curionav_cli.remote.weight_publisher import WeightPublisher
from curionav_cli.storage import checkpoint
from curionav_cli.storage.replay import Replay

os.environ |= {"OMP_NUM_THREADS": "1", "OMP_WAIT_POLICY": "PASSIVE"}  # as the command line sets them, before torch
MARK, BUCKET, LINK = fingerprint({"benchmark": 1}), "bucket", 20e6 / 8  # bytes a second
EPISODES = 5
EPISODE_SECONDS = 300.0  # seconds of a robot's episode: the paper says approximately 5 minutes for 500 steps
NO_CALLBACKS = SimpleNamespace(acted=lambda step: None, learned=lambda i: None, predicted=lambda index, made: None)


def settings(*words: str) -> Config:
    with opened("benchmark") as hydra:
        words = ("env=small_room", "agent=lbs_dreamer", "device=cpu", *words)
        return as_settings(hydra.compose_config(MAIN, list(words), RunMode.RUN))


def record(chosen: Config, count: int) -> list[Episode]:
    """Episodes of an agent that has learned nothing yet."""
    world = build.scene(chosen)
    env, agent = build.env(chosen, world), build.agent(chosen, world)
    episodes = []
    for index in range(count):
        observation, info = env.reset(seed=0, options={"episode": index})
        episodes.append(run_episode(env, agent, observation, info, chosen.loop.steps, NO_CALLBACKS))
    return episodes


def sizes(folder: Path) -> None:
    """Bytes of an episode."""
    print("| environment | raw | as uploaded (deflate 1) | deflate 9 | uploaded / raw |\n|---|---|---|---|---|")
    for env in ("small_room", "apartment_0", "large_lab"):
        rows = []
        for index, episode in enumerate(record(settings(f"env={env}", "agent=sticky"), EPISODES)):
            path = folder / f"{index}.npz"
            episode.save(path)
            arrays = [episode.image, episode.action, episode.pose, episode.collided]
            rows.append([sum(array.nbytes for array in arrays), path.stat().st_size, packed(arrays)])
        raw, ours, hard = (statistics.median(column) for column in zip(*rows, strict=True))
        shares = [row[1] / row[0] for row in rows]
        print(f"| `{env}` | {raw / 1e6:.2f} MB | {ours / 1e6:.2f} MB | {hard / 1e6:.2f} MB "
              f"| {min(shares):.2f} to {max(shares):.2f} |")


def packed(arrays: list[np.ndarray]) -> int:
    """Bytes by deflate at its hardest."""
    raw = io.BytesIO()
    with zipfile.ZipFile(raw, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for index, array in enumerate(arrays):
            archive.writestr(str(index), array.tobytes())
    return raw.tell()


@contextmanager
def rclone(folder: Path) -> Iterator[int]:
    """The port of a real S3 server."""
    (folder / BUCKET).mkdir(parents=True)
    with closing(socket.socket()) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    program = Path(sys.executable).with_name("rclone")
    keys = os.environ["AWS_ACCESS_KEY_ID"], os.environ["AWS_SECRET_ACCESS_KEY"]
    words = [program, "serve", "s3", folder, "--addr", f"127.0.0.1:{port}", "--auth-key", ",".join(keys)]
    with subprocess.Popen(words, stderr=subprocess.DEVNULL) as running:
        while not listens(port):
            time.sleep(0.1)
        try:
            yield port
        finally:
            running.kill()


def listens(port: int) -> bool:
    with closing(socket.socket()) as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def link(port: int) -> int:
    """The port of a link of 20 Mbit/s in each direction to `port`; it stays as long as this process runs."""
    listener = socket.create_server(("127.0.0.1", 0))

    def pump(source: socket.socket, to: socket.socket) -> None:
        due = time.monotonic()
        while part := source.recv(16384):
            due = max(due, time.monotonic()) + len(part) / LINK
            time.sleep(max(0.0, due - time.monotonic()))
            to.sendall(part)
        to.shutdown(socket.SHUT_WR)

    def accept() -> None:
        while True:
            near, _ = listener.accept()
            far = socket.create_connection(("127.0.0.1", port))
            for pair in ((near, far), (far, near)):
                threading.Thread(target=quietly, args=(pump, *pair), daemon=True).start()

    threading.Thread(target=accept, daemon=True).start()
    return listener.getsockname()[1]


def quietly(pump, source: socket.socket, to: socket.socket) -> None:
    """Clients close connections when they like."""
    try:
        pump(source, to)
    except OSError:
        to.close()


def store(port: int, prefix: str) -> ObjectStore:
    os.environ["AWS_ENDPOINT_URL"] = f"http://127.0.0.1:{port}"
    return ObjectStore.at(f"s3://{BUCKET}/{prefix}", 60)


class Ends:
    """A robot and a server of the same settings."""

    def __init__(self, chosen: Config, folder: Path, near: ObjectStore, far: ObjectStore):
        self.learning: list[float] = []  # wall seconds of each episode
        self.rounds: list[float] = []  # CPU-seconds of each round of the server
        world = build.scene(chosen)
        robot, server = build.agent(chosen, world), build.agent(chosen, world)
        (folder / "episodes").mkdir(parents=True)
        outbox = Outbox(folder / "outbox", MARK, 200, 1.0)
        timing = Time(time.monotonic, self.sleep)
        self.sync = RobotSync(near, outbox, WeightCache(folder / "weights"), robot.import_weights,
                              len(robot.export_weights()), chosen.remote, timing, print,
                              lambda seq: folder / "episodes" / f"{seq:06d}.npz")
        ledger = Ledger(folder / "ledger.sqlite")
        inbox = Inbox(far, ledger, folder / "quarantine", settings=MARK, steps=chosen.loop.steps, gap=0,
                      clock=time.monotonic, say=print)
        learn = LocalLearner(server, Replay(every=server.every), chosen.loop.iterations, NO_CALLBACKS,
                             lambda index, episode: episode.save(folder / f"{index}.npz"))

        def learned(position: int, arrival: Arrival) -> None:
            began = time.perf_counter()
            learn(position, arrival.episode)
            self.learning.append(time.perf_counter() - began)
            checkpoint.save(folder / "checkpoint", position + 1, {}, server.save)

        self.server = TrainingServer(inbox, WeightPublisher(far, ledger, MARK, print), learned, server.export_weights,
                                     0, chosen.remote, timing, print)

    def sleep(self, seconds: float) -> None:
        """The robot waits, and the server works."""
        began = time.process_time()
        while self.server.turn():
            self.rounds.append(time.process_time() - began)
            began = time.process_time()

    def docked(self, seq: int, episode: Episode) -> float:
        """Seconds from docking to weights that know the episode."""
        episode.save(self.sync.episode_path(seq))
        self.sync.collect(seq, episode)
        began = time.perf_counter()
        self.sync.docked(seq + 1)
        assert self.sync.newest_trained == seq
        return time.perf_counter() - began


def docking(folder: Path) -> None:
    """What lies between docking and new weights, beside the learning."""
    chosen = settings("loop.iterations=1")
    episodes = record(chosen, EPISODES)
    print("| link | docking to new weights, without learning | an episode | weights |\n|---|---|---|---|")
    with rclone(folder / "s3") as port:
        for name, near in (("loopback", port), ("20 Mbit/s", link(port))):
            place = folder / name.split()[0]
            ends = Ends(chosen, place, store(near, place.name), store(port, place.name))
            whole = [ends.docked(seq, episode) for seq, episode in enumerate(episodes)]
            rest = [seconds - learning for seconds, learning in zip(whole, ends.learning, strict=True)]
            uploaded = statistics.median(path.stat().st_size for path in (place / "episodes").iterdir())
            print(f"| {name} | {spread(rest)} s | {uploaded / 1e6:.2f} MB | {ends.sync.size / 1e6:.2f} MB |")


def robots(folder: Path) -> None:
    """A server's round: fetch, verify, K iterations, save, publish."""
    chosen = settings()
    with rclone(folder / "s3") as port:
        ends = Ends(chosen, folder / "ends", store(port, "robots"), store(port, "robots"))
        for seq, episode in enumerate(record(chosen, 3)):
            ends.docked(seq, episode)
    print(f"A server's round of one episode, K = {chosen.loop.iterations}: {spread(ends.rounds)} CPU-seconds. Of a "
          f"robot's {EPISODE_SECONDS:.0f} s an episode, one core serves "
          f"{int(EPISODE_SECONDS // statistics.median(ends.rounds))} robots.")


def spread(seconds: list[float]) -> str:
    return f"{statistics.median(seconds):.2f} ({min(seconds):.2f} to {max(seconds):.2f}, n = {len(seconds)})"


def main() -> None:
    os.environ.setdefault("AWS_ACCESS_KEY_ID", "benchmark")
    os.environ.setdefault("AWS_SECRET_ACCESS_KEY", "benchmark")
    known = {"bytes": sizes, "dock": docking, "robots": robots}
    for name in sys.argv[1:] or known:
        with tempfile.TemporaryDirectory() as folder:
            known[name](Path(folder))


if __name__ == "__main__":
    main()
