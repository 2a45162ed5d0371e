"""The server's round: an episode is taken, learned from, saved, its weights are published; then the next (paper,
section "Lifelong learning"). Killed anywhere, it goes on from its newest checkpoint and does the rest again, to the
same bytes."""

from __future__ import annotations

from collections.abc import Callable

from curionav_cli.errors import RunFailed, Unreachable
from curionav_cli.remote.inbox import Arrival, Inbox
from curionav_cli.remote.robot_sync import Time, backoff
from curionav_cli.remote.settings import Remote
from curionav_cli.remote.weight_publisher import WeightPublisher


class TrainingServer:
    """learn: from an arrival at a position, checkpoint included. share: the weights as they are then.

    done: how many episodes were learned from.
    """

    def __init__(self, inbox: Inbox, publisher: WeightPublisher, learn: Callable[[int, Arrival], None],
                 share: Callable[[], bytes], done: int, remote: Remote, time: Time, say: Callable[[str], None]):
        self.inbox, self.publisher, self.learn, self.share = inbox, publisher, learn, share
        self.done, self.remote, self.time, self.say = done, remote, time, say
        self.owed = done > 0  # weights that may not be known yet: also those of before a restart

    def turn(self) -> bool:
        """Publish what is owed, then one episode; False: there is none now. Raises Unreachable."""
        self.publish()
        arrival = self.inbox.next()
        if arrival is None:
            return False
        self.learn(self.inbox.ledger.take(arrival.marker), arrival)
        self.done, self.owed = self.done + 1, True
        self.publish()
        return True

    def publish(self) -> None:
        """Weights, then the pointer to them."""
        if self.owed:
            self.publisher.publish(self.done, self.share())
            self.owed = False

    def serve(self) -> None:
        """All that is there; with remote.follow, all that will come.

        Raises RunFailed where the storage gives no answer and nobody said that it should be waited for.
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
