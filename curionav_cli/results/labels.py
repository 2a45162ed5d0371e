"""Which runs are the same arm of a comparison, and what to call it.

Two runs are the same arm if all that a run may not change while it goes on (fixed.json) is the same, apart from the
seed and the world; two worlds are the same if theirs is, apart from what draws the pictures. A name is the agent's
(or the scene's), with the fewest settings that distinguish it from others of that name: `lbs_dreamer
curiosity=shuffled`. ROS maps of one name are distinguished by the shortest ending of their paths: `north/office`,
`south/office`.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

Settings = dict[str, Any]
ARM = ("agent", "robot", "loop", "trained")
TRAINING = ("training seed", "checkpoint (sha256)")  # of an evaluation: these differ within an arm
ABSENT = "?"  # written by a version that did not have this setting


def arm_settings(fixed: Settings) -> Settings:
    """Settings that make the arm, by dotted keys: agent, robot, steps, iterations; where and how long it was trained
    before an evaluation."""
    return flat({key: value for key, value in fixed.items() if key in ARM})


def world_settings(fixed: Settings) -> Settings:
    """Settings that make the world, by dotted keys; where the learner ran is not among them."""
    rest = {key: value for key, value in fixed.items() if key not in (*ARM, "seed", "learner", "episodes", *TRAINING)}
    return {key: value for key, value in flat(rest).items() if key not in ("env.engine", "env.note")}


def flat(settings: Settings, prefix: str = "") -> Settings:
    """Flatten {"agent": {"gamma": 1}} to {"agent.gamma": 1}; lists stay whole."""
    found: Settings = {}
    for key, value in settings.items():
        found |= flat(value, f"{prefix}{key}.") if isinstance(value, dict) else {prefix + key: value}
    return found


def labels(names: Sequence[str], settings: Sequence[Settings], presets: Sequence[str]) -> list[str]:
    """A label for each run: the same for the same name and settings, another for any other.

    presets: the preset that the settings of each run came from; where it changed several settings at once, its name
    stands for them.
    """
    found = list(names)
    for name in set(names):
        members = [index for index, other in enumerate(names) if other == name]
        which = {index: json.dumps(settings[index], sort_keys=True) for index in members}
        arms = {which[index]: {"scale": presets[index], **settings[index]} for index in reversed(members)}
        keys = distinguishing(list(arms.values()))
        shown = {key: short(key, {key for arm in arms.values() for key in arm}) for key in keys}
        values = {key: texts([arm.get(key, ABSENT) for arm in arms.values()]) for key in keys}
        for index in members:
            place = list(arms).index(which[index])
            found[index] = " ".join([name, *(f"{shown[key]}={values[key][place]}" for key in keys)])
    return found


def scene_name(env: Settings) -> str:
    """Name of a world: its scene's, its ROS map's file, or that file's folder where it is just map.yaml."""
    return path_names(env["map"])[0] if env.get("map") else env["name"]


def world_labels(envs: Sequence[Settings], worlds: Sequence[Settings]) -> list[str]:
    """A label for the world of each run: the same for the same name and settings.

    envs: name and map; worlds: as world_settings gives them. The same world with its map in another place keeps the
    first one's name.
    """
    worlds_named = [(scene_name(env), json.dumps(world, sort_keys=True)) for env, world in zip(envs, worlds)]
    first: dict[tuple[str, str], str] = {}
    for world, env in zip(worlds_named, envs):
        first.setdefault(world, str(Path(env["map"]).resolve()) if env.get("map") else "")
    names = []
    for world in worlds_named:
        same = [path for other, path in first.items() if other[0] == world[0] and path]
        names.append(distinct_names(same)[first[world]] if first[world] else world[0])
    return labels(names, worlds, [""] * len(names))


def path_names(path: str) -> list[str]:
    """Names for a file, from short to long: office, north/office ... For map.yaml they begin with its folder."""
    whole = Path(path).resolve()
    parts = whole.with_suffix("").parts[1:]
    parts = parts[:-1] if parts[-1] == "map" and parts[:-1] else parts
    return [*("/".join(parts[-n:]) for n in range(1, len(parts) + 1)), whole.name, str(whole)]


def distinct_names(paths: Sequence[str]) -> dict[str, str]:
    """Find for each path the shortest of its endings that no other path has."""
    names = {path: path_names(path) for path in paths}
    taken = Counter(name for ways in names.values() for name in set(ways))
    return {path: next((name for name in ways if taken[name] == 1), path) for path, ways in names.items()}


def distinguishing(arms: Sequence[Settings]) -> list[str]:
    """Find the fewest settings that distinguish all arms; of those that differ together the first, or their preset."""
    splits: dict[tuple[int, ...], list[str]] = {}
    for key in dict.fromkeys(key for arm in arms for key in arm):
        values = tuple(text(arm.get(key, ABSENT)) for arm in arms)
        first = tuple(values.index(value) for value in values)  # which arms are alike in it
        splits.setdefault(first, []).append(key)
    stands = {split: together[0] if together[0] != "scale" or len(together) > 2 else together[-1]
              for split, together in splits.items() if together != ["scale"]}
    ways = (chosen for size in range(len(stands) + 1) for chosen in combinations(stands, size)
            if len(set(zip(*chosen))) == len(arms) or len(arms) == 1)
    return [stands[split] for split in next(ways, tuple(stands))]


def short(key: str, keys: Iterable[str]) -> str:
    """The last word of a dotted key, where no other ends in it."""
    last = key.rpartition(".")[2]
    return last if sum(other.rpartition(".")[2] == last for other in keys) == 1 else key


def text(value: Any) -> str:
    """A value in a label; a long one by the beginning of its checksum."""
    plain = value if isinstance(value, str) else json.dumps(value, separators=(",", ":"))
    return plain if len(plain) <= 24 else f"#{hashlib.sha256(plain.encode()).hexdigest()[:6]}"


def texts(values: Sequence[Any]) -> list[str]:
    """Values of one setting in labels; paths by their shortest distinct endings."""
    if all(isinstance(value, str) and os.sep in value for value in values):
        return list(map(distinct_names(values).__getitem__, values))
    return list(map(text, values))


def differences(arms: dict[str, Settings]) -> dict[str, dict[str, str]]:
    """All settings in which any of these arms differ: for each of them {label: value}, as text."""
    keys = dict.fromkeys(key for settings in arms.values() for key in settings)
    table = {key: {label: text(settings.get(key, ABSENT)) for label, settings in arms.items()} for key in keys}
    return {key: values for key, values in table.items() if len(set(values.values())) > 1}
