"""The robot's side at its dock: deliver episodes, import new weights (paper, section "Lifelong learning").

Without a connection the robot goes on with the weights it has.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from curionav_cli.errors import RunFailed, Unreachable, WeightsRefused
from curionav_cli.records import Episode
from curionav_cli.remote.object_store import ObjectStore, TooLarge
from curionav_cli.remote.outbox import Outbox
from curionav_cli.remote.protocol import LATEST, MARKED, SMALL, Marker, Pointer, Refusal, parsed, sha256, written
from curionav_cli.remote.settings import Remote
from curionav_cli.remote.weight_cache import WeightCache

QUIET = 10.0  # seconds at the dock, before a message says what the robot waits for
ATTEMPTS = 3  # to import weights that cannot be used, before the robot goes on without


@dataclass
class Time:
    """A clock in seconds, a way to sleep, and a generator of backoff times; tests replace them."""

    clock: Callable[[], float]
    sleep: Callable[[float], None]
    rng: np.random.Generator = field(default_factory=np.random.default_rng)  # for backoff only


class RobotSync:
    """Synchronises a robot with its storage.

    import_weights: raises WeightsRefused for weights that the agent cannot act with. size: bytes of the agent's
    weights. say: prints a line. episode_path: where an episode is saved. version: number of episodes that the imported
    weights were trained on; newest_trained: the number of the newest of these, -1 for none.
    """

    def __init__(self, store: ObjectStore, outbox: Outbox, cache: WeightCache,
                 import_weights: Callable[[bytes], None], size: int, remote: Remote, time: Time,
                 say: Callable[[str], None], episode_path: Callable[[int], Path]):
        self.store, self.outbox, self.cache, self.import_weights, self.size = store, outbox, cache, import_weights, size
        self.remote, self.time, self.say, self.episode_path = remote, time, say, episode_path
        self.answered: dict[str, int] = {}  # name of an episode -> refusals that were answered
        self.hinted = False
        cached = cache.newest(import_weights, say)
        self.version, self.newest_trained = (cached.version, cached.seq) if cached else (0, -1)

    def collect(self, seq: int, episode: Episode) -> None:
        """Put a saved episode, recorded with the current weights, into the outbox."""
        self.outbox.add(seq, self.episode_path(seq), episode, self.version)

    def docked(self, due: int) -> None:
        """Before episode `due`: deliver, and wait for weights trained on all episodes before it, as `Remote` allows.

        A robot that crashed after it recorded `due` repeats it with the weights it had, to the same episode.
        Raises RunFailed where the outbox is full.
        """
        began = answered = self.time.clock()
        failures = refusals = 0
        why = ""
        while True:
            now = self.time.clock()
            try:
                self.exchange(due)
                answered, failures = self.time.clock(), 0
                if self.newest_trained >= due - 1 or self.outbox.recorded(due, self.version):
                    return
                pause, why = self.remote.poll, f"no new weights after {now - began:.0f} s"
                over = now - began >= self.remote.wait
                if now - began >= QUIET and not over:
                    self.hint()
            except Unreachable as error:
                failures += 1
                pause = backoff(failures, self.time.rng)
                why, over = f"the storage is not reachable ({error})", now - answered >= self.remote.offline
            except WeightsRefused as error:
                refusals += 1
                pause, why = self.remote.poll, f"new weights cannot be used ({error})"
                over = refusals >= ATTEMPTS or now - began >= self.remote.wait
            if over:
                break
            self.time.sleep(pause)
        self.go_on(why)

    def hint(self) -> None:
        """Say once what the robot waits for, and which command makes it."""
        if not self.hinted:
            self.hinted = True
            self.say(f"at the dock: waits up to {self.remote.wait:g} s each time for new weights, which a "
                     "curionav train storage=... has to make")

    def go_on(self, why: str) -> None:
        """Go on with the current weights and say why. Raises RunFailed where the outbox is full."""
        waiting = len(self.outbox.waiting())
        self.say(f"{why}: goes on with weights {self.version}; {waiting} episode{'s' * (waiting != 1)} to be delivered")
        full = self.outbox.full()
        if full:
            raise RunFailed(f"The outbox is full: {full}, and {why}. Nothing is lost; once the storage "
                            "answers, go on with the same command.")

    def exchange(self, due: int) -> None:
        """Deliver, answer refusals and import new weights, once. Raises Unreachable or WeightsRefused."""
        for marker in self.outbox.waiting():
            self.send(marker, self.outbox.data(marker))
            self.outbox.deliver(marker)
        self.send_again()
        if not self.outbox.recorded(due, self.version):
            self.take_newest(due)

    def send(self, marker: Marker, data: Path) -> None:
        """Put an episode, then its marker, and compare their sizes. Raises Unreachable."""
        note = written(marker)
        episode, mark = (f"episodes/{marker.name}.{kind}" for kind in ("npz", "json"))
        self.store.put(episode, data)
        self.store.put(mark, note)
        arrived = self.store.size(episode), self.store.size(mark)
        if arrived != (marker.size, len(note)):
            raise Unreachable(f"of episode {marker.seq} {arrived[0]} bytes arrived, of {marker.size}")

    def send_again(self) -> None:
        """Send again the episodes that the server refused, once for each refusal."""
        for note in self.store.names("refused", MARKED):
            name, marker = note.removesuffix(".json"), self.outbox.delivered(note.removesuffix(".json"))
            if not marker:
                continue
            try:
                refusal = parsed(Refusal, self.store.get(f"refused/{note}", SMALL) or b"")
            except ValueError:
                continue
            if refusal.times > self.answered.get(name, 0):
                self.say(f"the server could not use episode {marker.seq} ({refusal.reason}): sends it again")
                self.answered[name] = refusal.times
                path = self.episode_path(marker.seq)
                if path.exists() and sha256(path.read_bytes()) == marker.sha256:
                    self.send(marker, path)
                else:
                    self.say(f"episode {marker.seq} is no longer as it was recorded: it cannot be sent again")

    def take_newest(self, due: int) -> None:
        """Import the weights that LATEST names, if they are newer. Raises WeightsRefused and keeps the current ones.

        Weights trained on episode `due` itself are left: a robot that crashed in it repeats it with those it had.
        """
        try:
            raw = self.store.get(LATEST, SMALL)
            if raw is None:
                return
            pointer = parsed(Pointer, raw)
            if pointer.version <= self.version:
                if pointer.version < self.version:
                    raise ValueError(f"version {pointer.version} is older than {self.version}")
                return
            if pointer.seq >= due:
                return
            weights = self.fetch(pointer)
        except (ValueError, TooLarge) as error:
            raise WeightsRefused(str(error)) from error
        self.import_weights(weights)
        self.cache.keep(pointer, weights)
        self.version, self.newest_trained = pointer.version, pointer.seq

    def fetch(self, pointer: Pointer) -> bytes:
        """The weights that a pointer names. Raises ValueError where they are not as announced or of another agent."""
        if pointer.settings != self.outbox.settings:
            raise ValueError("they were trained with other settings")
        if pointer.size != self.size:
            raise ValueError(f"they have {pointer.size} bytes, this agent's have {self.size}")
        raw = self.store.get(pointer.key, pointer.size)
        if raw is None or sha256(raw) != pointer.sha256:
            raise ValueError("they are not what was announced")
        return raw


def backoff(failures: int, rng: np.random.Generator) -> float:
    """Seconds until the next try: 1, doubling up to 60, times 0.5 to 1 at random, so that robots spread their tries."""
    return min(60.0, 2.0 ** min(failures - 1, 6)) * rng.uniform(0.5, 1.0)
