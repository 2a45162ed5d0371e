"""A robot and a server at one storage, in one thread: time passes only while one of them sleeps and the other works.

Their weights are a chain of hashes, so that those after n episodes can be computed without a learner.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from curionav_cli.errors import Unreachable, WeightsRefused
from curionav_cli.records import Episode
from curionav_cli.remote.inbox import Arrival, Inbox
from curionav_cli.remote.ledger import Ledger
from curionav_cli.remote.object_store import ObjectStore
from curionav_cli.remote.outbox import Outbox
from curionav_cli.remote.protocol import MARKED, fingerprint
from curionav_cli.remote.robot_sync import RobotSync, Time
from curionav_cli.remote.settings import Remote
from curionav_cli.remote.training_server import TrainingServer
from curionav_cli.remote.weight_cache import WeightCache
from curionav_cli.remote.weight_publisher import WeightPublisher
from curionav_cli.storage import checkpoint

SETTINGS = {"agent": {"name": "chain"}, "seed": 0}
STEPS = 5


def chain(episodes: list[Episode]) -> bytes:
    """The weights that those episodes, in this order, lead to."""
    weights = b"\0" * 32
    for episode in episodes:
        weights = link(weights, episode)
    return weights


def link(weights: bytes, episode: Episode) -> bytes:
    return hashlib.sha256(weights + episode.image.tobytes() + episode.action.tobytes()).digest()


class Pair:
    """robot: a RobotSync; server: a TrainingServer; said: the lines that each of them printed."""

    def __init__(self, url: str, folder: Path, an_episode: Callable[..., Episode], settings: dict = SETTINGS):
        self.url, self.folder, self.an_episode = url, folder, an_episode
        self.remote = Remote(wait=50, offline=20, poll=1, timeout=5, gap=30, outbox=6, disk=1, follow=True)
        self.mark, self.now = fingerprint(settings), 0.0
        self.said: dict[str, list[str]] = {"robot": [], "server": []}
        self.acting, self.learned = b"\0" * 32, b"\0" * 32
        self.server_works, self.recorded = True, 0
        self.pass_by: Callable[[], None] = lambda: None  # called while time passes
        self.store().create()
        self.boot_robot()
        self.boot_server()

    def store(self) -> ObjectStore:
        return ObjectStore.at(self.url, self.remote.timeout)

    @contextmanager
    def at_work(self) -> Iterator[Pair]:
        yield self
        self.ledger.close()

    def timing(self) -> Time:
        return Time(lambda: self.now, self.sleep, np.random.default_rng(0))

    def sleep(self, seconds: float) -> None:
        self.now += seconds
        self.pass_by()
        if self.server_works:
            self.serve()

    # -- the robot --------------------------------------------------------------------------------

    def boot_robot(self) -> None:
        """Also after a power cut: from what is on its disk."""
        run = self.folder / "robot"
        (run / "episodes").mkdir(parents=True, exist_ok=True)
        self.acting = b"\0" * 32
        self.outbox = Outbox(run / "outbox", self.mark, self.remote.outbox, self.remote.disk)
        self.robot = RobotSync(self.store(), self.outbox, WeightCache(run / "weights"), self.import_weights, 32,
                               self.remote, self.timing(), self.said["robot"].append, self.path)

    def path(self, seq: int) -> Path:
        return self.folder / "robot" / "episodes" / f"{seq:06d}.npz"

    def import_weights(self, raw: bytes) -> None:
        if len(raw) != 32 or raw.startswith(b"nan"):
            raise WeightsRefused("they are no links of the chain")
        self.acting = raw

    def episode(self, seq: int) -> Episode:
        return self.an_episode(steps=STEPS, seed=seq)

    def dock(self) -> None:
        """As the loop calls it, before the episode after the last one."""
        self.robot.docked(self.recorded)

    def record(self, seq: int, episode: Episode | None = None) -> None:
        """Record an episode, without delivering it."""
        self.recorded = max(self.recorded, seq + 1)
        episode = episode or self.episode(seq)
        episode.save(self.path(seq))
        self.robot.collect(seq, episode)

    # -- the server -------------------------------------------------------------------------------

    def boot_server(self) -> None:
        """Also after a kill: from its newest checkpoint."""
        run, say = self.folder / "server", self.said["server"].append
        run.mkdir(parents=True, exist_ok=True)
        found = checkpoint.newest(run / "checkpoint", {})
        done, self.learned = (found[0], (found[1] / "chain").read_bytes()) if found else (0, b"\0" * 32)
        self.ledger = Ledger(run / "ledger.sqlite")
        inbox = Inbox(self.store(), self.ledger, run / "quarantine", settings=self.mark, steps=STEPS,
                      gap=self.remote.gap, clock=lambda: self.now, say=say)
        inbox.first = self.ledger.rewind(done)
        publisher = WeightPublisher(self.store(), self.ledger, self.mark, say)
        self.server = TrainingServer(inbox, publisher, lambda *words: self.learn(*words), lambda: self.learned, done,
                                     self.remote, self.timing(), say)

    def learn(self, position: int, arrival: Arrival) -> None:
        self.learned = link(self.learned, arrival.episode)
        checkpoint.save(self.folder / "server" / "checkpoint", position + 1, {},
                        lambda folder: (folder / "chain").write_bytes(self.learned))

    def serve(self) -> None:
        """As TrainingServer.serve does, as long as there are episodes."""
        try:
            self.server.publisher.announce()
            while self.server.turn():
                pass
        except Unreachable as error:
            self.said["server"].append(str(error))

    def expected(self, *order: int) -> bytes:
        return chain([self.episode(seq) for seq in order])

    def undisturbed(self, episodes: int) -> None:
        """All arrived, each was learned from once, in order; nothing waits, nothing is refused."""
        assert self.learned == self.expected(*range(episodes)) and self.server.done == episodes
        assert self.acting == self.learned and self.robot.version == episodes
        assert not self.outbox.waiting() and self.ledger.refused() == {} and len(self.ledger.names()) == episodes
        assert not list((self.folder / "server" / "quarantine").glob("*"))
        assert self.store().names("refused", MARKED) == []
