"""The server's loop: take an episode, learn, save, publish the weights (paper, section "Lifelong learning").

Killed anywhere, it goes on from its newest checkpoint and repeats the rest, to the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable

from curionav_cli.errors import RunFailed, Unreachable
from curionav_cli.remote.inbox import Arrival, Inbox
from curionav_cli.remote.robot_sync import Time, backoff
from curionav_cli.remote.settings import Remote
from curionav_cli.remote.weight_publisher import WeightPublisher


class TrainingServer:
    """Learns from the episodes of an inbox and publishes the weights.

    learn: learns from the arrival at a position and saves a checkpoint. export_weights: the weights after that.
    done: number of episodes that were learned from. say: prints a line.
    """

    def __init__(self, inbox: Inbox, publisher: WeightPublisher, learn: Callable[[int, Arrival], None],
                 export_weights: Callable[[], bytes], done: int, remote: Remote, time: Time,
                 say: Callable[[str], None]):
        self.inbox, self.publisher, self.learn, self.export_weights = inbox, publisher, learn, export_weights
        self.done, self.remote, self.time, self.say = done, remote, time, say
        self.unpublished = done > 0  # after a restart too: the last weights may not have been published

    def turn(self) -> bool:
        """Publish, then learn from one episode; False where there is none now. Raises Unreachable."""
        self.publish()
        arrival = self.inbox.next()
        if arrival is None:
            return False
        self.learn(self.inbox.ledger.take(arrival.marker), arrival)
        self.done, self.unpublished = self.done + 1, True
        self.publish()
        return True

    def publish(self) -> None:
        """Publish the weights, if they are not yet. Raises Unreachable."""
        if self.unpublished:
            self.publisher.publish(self.done, self.export_weights())
            self.unpublished = False

    def serve(self) -> None:
        """Learn from all episodes in the storage; with remote.follow, go on with all that arrive.

        Raises RunFailed where the storage is not reachable, without remote.follow.
        """
        failures, idle = 0, False
        while True:
            try:
                self.publisher.announce()
                while self.turn():
                    pass
                if not self.remote.follow:
                    return
                if failures:
                    self.say("the storage answers again")
                if not idle:
                    self.say("waits for episodes; Ctrl-C ends it")
                failures, idle, pause = 0, True, self.remote.poll
            except Unreachable as error:
                failures += 1
                pause = backoff(failures, self.time.rng)
                if not self.remote.follow:
                    raise RunFailed(f"The storage is not reachable ({error}). What was learned is saved; go on with "
                                    "the same command, or with --follow to wait for the storage.") from None
                if failures == 1:
                    self.say(f"the storage is not reachable ({error}): tries again")
            self.time.sleep(pause)
