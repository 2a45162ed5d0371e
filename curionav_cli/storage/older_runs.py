"""Settings that runs of older versions were begun without, with the value that held then, or had by another name.

A setting that is new gets a line here, so that older runs can be read (config/settings.py) and resumed (checkpoint.py).
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

HELD = {"agent.action_repeat": 1, "env.scale_occupied": 100, "agent.options": "none", "agent.behaviour": "actor",
        "agent.plan_depth": 2, "agent.plan_samples": 8, "agent.plan_temperature": 0.03,
        "loop.keep": "all", "loop.replay_episodes": None}

RENAMED = {"weights": "init"}  # of whole settings, as evaluations had them


def held(group: str, names: Collection[str]) -> dict[str, Any]:
    """The values of those of a group's settings `names` that older runs may lack."""
    found = {key.removeprefix(f"{group}."): value for key, value in HELD.items() if key.startswith(f"{group}.")}
    return {name: value for name, value in found.items() if name in names}


def named_anew(word: str) -> str:
    """A word of an older command, KEY=VALUE, with the key that it has now."""
    key, equals, value = word.partition("=")
    return f"{RENAMED.get(key, key)}{equals}{value}"
