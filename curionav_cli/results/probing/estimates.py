"""Rows of tables of probes: what each arm's world model knows at the end, and by how much arms differ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from curionav_cli.results import statistics
from curionav_cli.results.comparison.estimates import ENOUGH, pairs
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.probing.curves import MEASURES, ProbeCurve, ProbeField
from curionav_cli.results.statistics import mean_interval
from curionav_cli.results.tables import Row

ARMS = (("env", "env", "{}"), ("arm", "arm", "{}"), ("n", "n", "{:,}"), ("at", "at", "{:,}"), ("of", "axis", "{}"),
        ("error", "probe_error", "{:.4f}"), ("of the repeated frame", "probe_repeat", "{:.4f}"),
        ("surprise, nats", "probe_surprise", "{:.2f}"))
PAIRS = (("env", "env", "{}"), ("arm", "arm", "{}"), ("minus", "minus", "{}"), ("pairs", "n", "{:,}"),
         ("at", "at", "{:,}"), ("of", "axis", "{}"), ("difference of the error", "probe_error", "{:+.4f}"),
         ("p", "p", "{:.2g}"), ("difference of the surprise", "probe_surprise", "{:+.2f}"))


def arm_rows(fields: Sequence[ProbeField]) -> Iterator[Row]:
    """Make a row for each arm in each environment, with means and intervals over its runs."""
    for field in fields:
        for arm, curves in field.arms.items():
            measured = {key: np.array(list(field.values(arm, key).values())) for key in MEASURES}
            yield {"env": field.env, "arm": arm, "n": len(curves), "at": field.at, "axis": field.axis,
                   "probe_error": mean_interval(measured["error"]), "probe_repeat": float(measured["repeat"].mean()),
                   "probe_surprise": mean_interval(measured["surprise"])}


def pair_rows(fields: Sequence[ProbeField], baseline: str | None, rng: np.random.Generator) -> Iterator[Row]:
    """Make a row for every two arms that share seeds, or for all others minus the baseline."""
    for field in fields:
        for ours, theirs in pairs(list(field.arms), baseline):
            error, surprise = (field.difference(ours, theirs, key) for key in ("error", "surprise"))
            if len(error):
                yield {"env": field.env, "arm": ours, "minus": theirs, "n": len(error), "at": field.at,
                       "axis": field.axis, "probe_error": mean_interval(error),
                       "p": statistics.sign_flip_test(error, rng), "probe_surprise": mean_interval(surprise)}


def point_rows(fields: Sequence[ProbeField]) -> Iterator[Row]:
    """Make a row for each measurement of each run."""
    for field in fields:
        for arm, curves in field.arms.items():
            for curve in curves:
                for place, at in enumerate(curve.at.tolist()):
                    yield {"env": field.env, "arm": arm, "seed": curve.seeds[0], "axis": field.axis, "at": at,
                           **{f"probe_{key}": float(curve.values[key][place]) for key in MEASURES},
                           "folder": str(curve.folder)}


def tables(fields: Sequence[ProbeField], baseline: str | None, rng: np.random.Generator) -> list[Table]:
    """The tables of arms and pairs."""
    return [Table("probes", "World models on the fixed probe of the building, mean and 95 % t interval over seeds: "
                  "squared error of open-loop prediction ([0, 1], mean over pixels and frames), beside that of the "
                  "last seen frame repeated; surprise, KL of posterior and prior.", ARMS, list(arm_rows(fields))),
            Table("probe_pairs", "Differences between runs of the same seeds: mean, 95 % t interval, two-sided p of "
                  "the sign-flip test. Less error is better.", PAIRS, list(pair_rows(fields, baseline, rng)))]


def notes(fields: Sequence[ProbeField]) -> Iterator[str]:
    """Caveats for a reader of the numbers, a line each."""
    for field in fields:
        curves: list[ProbeCurve] = [curve for arm in field.arms.values() for curve in arm]
        probes = {one for curve in curves for one in curve.probes}
        if len(probes) > 1:
            yield (f"WARNING: {field.env}: measured on {len(probes)} different probes (another agent.action_repeat, or "
                   "another version of curionav), so that errors are not comparable between all runs.")
        few = [f"{arm} ({len(runs)})" for arm, runs in field.arms.items() if len(runs) < ENOUGH]
        if few:
            yield f"WARNING: {field.env}: fewer than {ENOUGH} seeds measured on the probe: {', '.join(few)}."
        longest = max(curve.at[-1] for curve in curves)
        if longest > field.at:
            yield (f"{field.env}: probes are compared after {field.at:,} {field.axis}, which every run has; the "
                   f"longest has {longest:,}.")
