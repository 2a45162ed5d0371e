"""What a run noted of its world model on the building's probe, over its steps, or the updates of offline training."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_json
from curionav_cli.results.comparison.run_summaries import folders
from curionav_cli.results.labels import Settings, arm_settings, flat, labels, world_labels, world_settings
from curionav_cli.storage.run_folder import RunFolder

STEPS, UPDATES = "steps", "updates"
MEASURES = ("error", "surprise", "repeat")  # probe.Probed says what they are


@dataclass(frozen=True, eq=False)
class ProbeCurve:
    """K measurements of one run.

    name: of its agent, or of learner and explorer, 'lbs_dreamer on bounce'; explorer: who collected the episodes;
    seeds: of the run and of the runs that its data came from. at (K,) int64: steps or updates, as `axis` says; values:
    (K,) of each of MEASURES. probes: checksums of the probes that it was measured on.
    """

    folder: Path
    env: Settings
    name: str
    explorer: str
    seeds: tuple[int, ...]
    preset: str
    arm: Settings
    world: Settings
    axis: str
    at: np.ndarray
    values: dict[str, np.ndarray]
    probes: frozenset[str]

    def value(self, measure: str, at: int) -> float:
        """The newest measurement after at most `at` steps or updates."""
        return float(self.values[measure][np.searchsorted(self.at, at, side="right") - 1])


@dataclass(frozen=True)
class ProbeField:
    """The curves in one environment over one axis.

    at: steps or updates that all of them have; arms: label -> curves, in the order of seeds.
    """

    env: str
    axis: str
    at: int
    arms: dict[str, list[ProbeCurve]]

    def values(self, arm: str, measure: str) -> dict[tuple[int, ...], float]:
        """A measure of every run of an arm at the end, by its seeds."""
        return {curve.seeds: curve.value(measure, self.at) for curve in self.arms[arm]}

    def difference(self, ours: str, theirs: str, measure: str) -> np.ndarray:
        """Differences of a measure at the end (n,), ours - theirs, of the seeds that both arms have."""
        mine, other = self.values(ours, measure), self.values(theirs, measure)
        return np.array([mine[seeds] - other[seeds] for seeds in mine if seeds in other])

    def looks(self) -> dict[str, str]:
        """The explorer of each arm, by which it is drawn."""
        return {arm: curves[0].explorer for arm, curves in self.arms.items()}


def read(folder: Path) -> ProbeCurve | None:
    """The curve of the run in `folder`; None where nothing was measured. Raises RunFolderError where it is broken."""
    run = RunFolder(folder)
    rows = [row for row in run.metrics() if "probe_error" in row]
    if not rows:
        return None
    config, fixed, about = run.settings, read_json(folder / "fixed.json"), read_json(folder / "run.json")
    axis = UPDATES if "iterations" in rows[0] else STEPS
    name, agent, arm = config["agent"]["name"], config["agent"]["name"], arm_settings(fixed)
    if axis is UPDATES:
        explorer, own = collected(about.get("data") or [], fixed)
        agent, name, arm = explorer, f"{name} on {explorer}", arm | own
    seeds = (config["seed"], *(one["seed"] for one in about.get("data") or ()))
    return ProbeCurve(folder, config["env"], name, agent, seeds, config["scale"], arm, world_settings(fixed), axis,
                      np.array([row["iterations" if axis is UPDATES else "steps"] for row in rows]),
                      {key: np.array([row[f"probe_{key}"] for row in rows]) for key in MEASURES},
                      frozenset(row["probe"] for row in rows))


def collected(data: Sequence[dict[str, Any]], fixed: Settings) -> tuple[str, Settings]:
    """Who collected the episodes of a training, and its settings; of a plain folder of episodes their checksum."""
    agents: list[Settings] = []
    for one in data:
        agents += [one["agent"]] * (one["agent"] not in agents)
    if not agents:
        return "episodes", {"data": f"{zlib.crc32(str(sorted(fixed['episodes'].values())).encode()):08x}"}
    own = flat({f"data{number or ''}": agent for number, agent in enumerate(agents)})
    return "+".join(agent["name"] for agent in agents), own


def read_all(paths: Sequence[Path]) -> list[ProbeCurve]:
    """The curve of every run in these folders of runs and sweeps, once each; none of what cannot be read."""
    found: dict[Path, ProbeCurve] = {}
    for path in paths:
        try:
            jobs = folders(path)
        except RunFolderError:  # a comparison of coverage says so
            continue
        for job in jobs:
            curve = read_or_none(job)
            if curve:
                found.setdefault(job.resolve(), curve)
    return list(found.values())


def read_or_none(folder: Path) -> ProbeCurve | None:
    """The curve of the run in `folder`; None where it is broken or never began."""
    try:
        return read(folder) if (folder / "config.yaml").is_file() else None
    except (RunFolderError, LookupError, TypeError):
        return None


def sort_into_fields(curves: Sequence[ProbeCurve], names: dict[Path, tuple[str, str]]
                     ) -> tuple[list[ProbeField], list[str]]:
    """Sort curves into environments, axes and arms; also a line for each that is left out.

    names: environment and arm of runs that are named already, by their folders.
    """
    envs = world_labels([curve.env for curve in curves], [curve.world for curve in curves])
    arms = labels([curve.name for curve in curves], [curve.arm for curve in curves], [c.preset for c in curves])
    named = {curve: names.get(curve.folder, own) for curve, own in zip(curves, zip(envs, arms))}
    groups: dict[tuple[str, str], list[ProbeCurve]] = {}
    for curve in sorted(curves, key=lambda curve: curve.seeds):
        groups.setdefault((named[curve][0], curve.axis), []).append(curve)
    order = list(dict.fromkeys(arm for _, arm in named.values()))
    fields, left_out = [], []
    for (env, axis), group in groups.items():
        field, out = field_of(env, axis, {curve: named[curve][1] for curve in group}, order)
        fields.append(field)
        left_out += out
    return fields, left_out


def field_of(env: str, axis: str, arms: dict[ProbeCurve, str], order: Sequence[str]) -> tuple[ProbeField, list[str]]:
    """The field of these curves, with arms in this order, up to the last measurement that all have; who is left out."""
    longest: dict[tuple[str, tuple[int, ...]], ProbeCurve] = {}
    for curve in sorted(arms, key=lambda curve: -curve.at[-1]):
        longest.setdefault((arms[curve], curve.seeds), curve)
    kept = set(longest.values())
    at = int(min(curve.at[-1] for curve in kept))
    late = {curve for curve in kept if curve.at[0] > at}
    lines = [f"LEFT OUT of the probes: the same arm and seeds as {longest[arms[curve], curve.seeds].folder}. "
             f"{curve.folder}" for curve in arms if curve not in kept]
    lines += [f"LEFT OUT of the probes: not measured within {at:,} {axis}. {curve.folder}" for curve in arms
              if curve in late]
    shown = {arm: [curve for curve in arms if arms[curve] == arm and curve in kept - late] for arm in order}
    return ProbeField(env, axis, at, {arm: curves for arm, curves in shown.items() if curves}), lines
