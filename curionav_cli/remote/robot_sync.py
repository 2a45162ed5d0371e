"""What a robot does when it has docked: deliver what it lived, take over what was learned from it (paper, section
"Lifelong learning"). Offline it goes on with what it has."""

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

QUIET = 10.0  # seconds at the dock, before a person is told what the robot waits for
ATTEMPTS = 3  # looks at weights that cannot be used, before the robot goes on without


@dataclass
class Time:
    """A clock and a way to let it pass; tests have their own."""

    clock: Callable[[], float]
    sleep: Callable[[float], None]
    rng: np.random.Generator = field(default_factory=np.random.default_rng)  # only when to ask again depends on it


class RobotSync:
    """Between a robot and its storage. adopt: takes over weights, or raises WeightsRefused. size: bytes of them.

    version: how many episodes the weights were trained on that act now. knows: the newest of them, -1 for none.
    """

    def __init__(self, store: ObjectStore, outbox: Outbox, shelf: WeightCache, adopt: Callable[[bytes], None],
                 size: int,
                 remote: Remote, time: Time, say: Callable[[str], None], episode_path: Callable[[int], Path]):
        self.store, self.outbox, self.shelf, self.import_weights, self.size = store, outbox, shelf, adopt, size
        self.remote, self.time, self.say, self.episode_path = remote, time, say, episode_path
        self.answered: dict[str, int] = {}  # which refusals were answered
        self.hinted = False
        kept = shelf.newest(adopt, say)
        self.version, self.knows = (kept.version, kept.seq) if kept else (0, -1)

    def collect(self, seq: int, episode: Episode) -> None:
        """An episode that was lived with the weights of now, and saved."""
        self.outbox.add(seq, self.episode_path(seq), episode, self.version)

    def docked(self, due: int) -> None:
        """Before episode `due`: deliver, and wait for weights that know all before it; then it goes on as it is.

        A robot that fell when it had lived `due` lives it again with the weights that it had, to the same episode.

        Raises RunFailed where the outbox is full.
        """
        began = answered = self.time.clock()
        failures = refusals = 0
        told = ""
        while True:
            now = self.time.clock()
            try:
                self.exchange(due)
                answered, failures = self.time.clock(), 0
                if self.knows >= due - 1 or self.outbox.recorded(due, self.version):
                    return
                pause, told = self.remote.poll, f"no new weights after {now - began:.0f} s"
                over = now - began >= self.remote.wait
                if now - began >= QUIET and not over:
                    self.hint()
            except Unreachable as error:
                failures += 1
                pause = backoff(failures, self.time.rng)
                told, over = f"the storage is not reachable ({error})", now - answered >= self.remote.offline
            except WeightsRefused as error:
                refusals += 1
                pause, told = self.remote.poll, f"new weights cannot be used ({error})"
                over = refusals >= ATTEMPTS or now - began >= self.remote.wait
            if over:
                break
            self.time.sleep(pause)
        self.go_on(told)

    def hint(self) -> None:
        """Once: what it waits for, and who should make them."""
        if not self.hinted:
            self.hinted = True
            self.say(f"at the dock: waits up to {self.remote.wait:g} s each time for new weights, which a "
                     "curionav train storage=... has to make")

    def go_on(self, why: str) -> None:
        """With what there is; the person at the screen reads why. Raises RunFailed where the outbox is full."""
        waiting = len(self.outbox.waiting())
        self.say(f"{why}: goes on with weights {self.version}; {waiting} episode{'s' * (waiting != 1)} to be delivered")
        full = self.outbox.full()
        if full:
            raise RunFailed(f"The outbox is full: {full}, and {why}. Nothing is lost; once the storage "
                            "answers, go on with the same command.")

    def exchange(self, due: int) -> None:
        """Once: deliver, answer refusals, look for weights. Raises Unreachable or WeightsRefused."""
        for marker in self.outbox.waiting():
            self.send(marker, self.outbox.data(marker))
            self.outbox.deliver(marker)
        self.send_again()
        if not self.outbox.recorded(due, self.version):
            self.take_newest(due)

    def send(self, marker: Marker, data: Path) -> None:
        """The episode, then its marker; then ask for both. Raises Unreachable."""
        note = written(marker)
        episode, mark = (f"episodes/{marker.name}.{kind}" for kind in ("npz", "json"))
        self.store.put(episode, data)
        self.store.put(mark, note)
        there = self.store.size(episode), self.store.size(mark)
        if there != (marker.size, len(note)):
            raise Unreachable(f"of episode {marker.seq} {there[0]} bytes arrived, of {marker.size}")

    def send_again(self) -> None:
        """What the server could not use."""
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
                    self.say(f"episode {marker.seq} is no longer as it was lived then: it cannot be sent again")

    def take_newest(self, due: int) -> None:
        """The weights that LATEST names, if they are newer. Raises WeightsRefused and keeps what it has.

        Those that know episode `due` already are left: a robot that fell while it lived it lives it again, as it was.
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
        self.shelf.keep(pointer, weights)
        self.version, self.knows = pointer.version, pointer.seq

    def fetch(self, pointer: Pointer) -> bytes:
        """Raises ValueError for what is not what was announced, or not of this robot's agent."""
        if pointer.settings != self.outbox.settings:
            raise ValueError("they were learned with other settings")
        if pointer.size != self.size:
            raise ValueError(f"they have {pointer.size} bytes, this agent's have {self.size}")
        raw = self.store.get(pointer.key, pointer.size)
        if raw is None or sha256(raw) != pointer.sha256:
            raise ValueError("they are not what was announced")
        return raw


def backoff(failures: int, rng: np.random.Generator) -> float:
    """1 s, doubling up to 60 s, of which a random half: robots that lost one server do not come back at once."""
    return min(60.0, 2.0 ** min(failures - 1, 6)) * rng.uniform(0.5, 1.0)
