"""Settings of robot and server that meet at a storage."""

from __future__ import annotations

from dataclasses import dataclass

from curionav_cli.bounds import bounded


@dataclass(frozen=True)
class Remote:
    """How long robot and server wait for each other, and what a robot keeps undelivered; values in conf/.

    wait, offline, poll, timeout, gap: seconds. outbox: episodes. disk: share of it that may be filled. Raises
    ValueError where one is out of range.
    """

    wait: float
    offline: float
    poll: float
    timeout: float
    gap: float
    outbox: int
    disk: float
    follow: bool

    def __post_init__(self) -> None:
        bounded("remote", self, {
            "wait offline gap": (0, 10**9), "poll": (0.01, 86400), "timeout": (0.1, 86400), "outbox": (1, 10**6),
            "disk": (0, 1)})
