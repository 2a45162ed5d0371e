"""curionav resume DIR: an interrupted run goes on from its last finished episode."""

from __future__ import annotations
