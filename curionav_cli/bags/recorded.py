"""The episode of a bag that curionav wrote, as it was: equal arrays."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from curionav_cli.bags import ours
from curionav_cli.bags.reader import DEPTHS, IMAGES, Bag
from curionav_cli.constants import ACTIONS
from curionav_cli.errors import BagError
from curionav_cli.live.images import depth as metres
from curionav_cli.live.images import picture
from curionav_cli.records import Episode


def is_ours(bag: Bag) -> bool:
    """Whether curionav wrote the bag."""
    return {ours.EPISODE: ours.TEXT, ours.ACTION: ours.NUMBERS, ours.STATE: ours.NUMBERS}.items() <= bag.topics.items()


def episode(bag: Bag) -> Episode:
    """The episode of a bag. Raises BagError where its parts do not fit together, MessageFault for a broken image."""
    about = told(bag)
    state, estimate = rows(bag, ours.STATE, 4), rows(bag, ours.ESTIMATE, 3) if ours.ESTIMATE in bag.topics else None
    action = rows(bag, ours.ACTION, 1)[:, 0]
    image = [picture(one.message, one.kind, 1.0) for one in bag.messages(about["image"])]
    depth = [metres(one.message, one.kind, 1.0) for one in bag.messages(about["depth"])] if "depth" in about else None
    counts = [len(image), len(state), *(len(found) for found in (estimate, depth) if found is not None)]
    if counts != [len(action) + 1] * len(counts) or not len(action):
        raise BagError(f"{bag.path}: {len(action)} actions do not fit to {len(image)} images and {len(state)} states.")
    if not np.isin(action, ACTIONS).all() or not np.isin(state[:, 3], (0.0, 1.0)).all():
        raise BagError(f"{bag.path}: an action that is none of 0, 1, 2, or a collision that is none of 0, 1.")
    return Episode(np.stack(image), action.astype(np.int64), state[:, :3].copy(), state[1:, 3] == 1.0,
                   tuple(about.get("events", ())), estimate, about.get("dock"),
                   depth=np.stack(depth) if depth else None)


def told(bag: Bag) -> dict[str, Any]:
    """What the bag says about its episode. Raises BagError where it says nothing that can be used."""
    words = next((one.message["data"] for one in bag.messages(ours.EPISODE)), "")
    try:
        about = json.loads(words)
        known = about[ours.MARK] == ours.LAYOUT and bag.topics.get(about["image"]) in IMAGES
        fits = isinstance(about.get("events", []), list) and isinstance(about.get("dock"), dict | None) and (
            "depth" not in about or bag.topics.get(about["depth"]) == DEPTHS)
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        known = fits = False
    if not (known and fits):
        raise BagError(f"{bag.path}: what {ours.EPISODE} says of the episode is not understood.")
    return about


def rows(bag: Bag, topic: str, width: int) -> np.ndarray:
    """The numbers (n, width) of a topic, float64. Raises BagError for others, and for those that are not finite."""
    found = [np.asarray(one.message["data"], np.float64) for one in bag.messages(topic)]
    if any(row.shape != (width,) or not np.isfinite(row).all() for row in found):
        raise BagError(f"{bag.path}: {topic} holds other than {width} finite numbers.")
    return np.stack(found) if found else np.empty((0, width))
