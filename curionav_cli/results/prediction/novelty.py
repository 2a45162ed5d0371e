"""Whether surprise separates new views from known ones: by action and by position, from stored predictions.

A view is new where the agent, which sees the frames that it acts on, had none in an earlier episode from within NEW
metres that looks the same way, and known where it had one from within KNOWN metres. The ratio is that of the mean
signal over new views to that over known ones; AUC is the probability that a new view has the higher signal (Mann and
Whitney's U over the number of pairs).
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from curionav_cli.files import read_arrays
from curionav_cli.options import chosen
from curionav_cli.records import Surprise
from curionav_cli.results.prediction.stored_predictions import newest
from curionav_cli.results.runs import Run

NEWEST = 20  # episodes that are judged
NEW, KNOWN = 0.25, 0.1  # metres: a step of the robot, and what hardly changes a picture
SAME_WAY = np.radians(25)
SETTLED = 5  # views after which a window that starts in mid-episode is past its zero state
KINDS = ("all", "forward", "turn", "cancelled")
SIGNALS = ("kl", "reward")


class Views(NamedTuple):
    """N frames that were judged.

    distance: (N,) metres from earlier views; kind: (N,) of the action that led to it; position: (N,) in its window;
    settled: (N,) whether that is past the zero state; signal: (2, N).
    """

    distance: np.ndarray
    kind: np.ndarray
    position: np.ndarray
    settled: np.ndarray
    signal: np.ndarray


def views(run: Run) -> Views | None:
    """Judge the newest episodes, each against all before it; None without predictions, or with one episode only."""
    found = list(each(run, {index: one.surprise for index, one in newest(run, NEWEST).items()}).values())
    return Views(*(np.concatenate(parts, -1) for parts in zip(*found))) if found else None


def each(run: Run, surprise: Mapping[int, Surprise]) -> dict[int, Views]:
    """Judge the views of these episodes but the first of the run, each against all episodes before it."""
    every, found = chosen(run.config["agent"]), {}
    seen: list[np.ndarray] = []
    for index, (path, pose) in enumerate(zip(run.episodes[:max(surprise, default=-1) + 1], run.poses())):
        arrays = read_arrays(path, ("action", "collided"))
        frame = every.decisions(arrays["action"], arrays["collided"], path).frame
        if index in surprise and index:
            seen = [np.unique(np.concatenate(seen), axis=0)]  # near the start most poses were there before
            away = distance(pose[frame], seen[0])
            found[index] = judged(surprise[index], frame, away, kinds(arrays["action"], arrays["collided"], frame))
        seen.append(pose[frame])
    return found


def judged(surprise: Surprise, frames: np.ndarray, away: np.ndarray, kind: np.ndarray) -> Views:
    """Judge the views of an episode's windows.

    frames, away, kind: (n+1,) the frames at which the agent chose, their distance in metres and their kind.
    """
    frame = np.searchsorted(frames, surprise.frame)
    position = np.broadcast_to(np.arange(frame.shape[1]), frame.shape)
    settled = (position >= SETTLED) | (frame[:, :1] == 0)
    return Views(away[frame].ravel(), kind[frame].ravel(), position.ravel(), settled.ravel(),
                 np.stack([surprise.kl.ravel(), surprise.reward.ravel()]))


def kinds(action: np.ndarray, collided: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """Index into KINDS of the choice that led to each of `frames` (n+1,); 0 for the first.

    action, collided: (T,) each. A choice is of the kind of its first step, and cancelled if all its steps are.
    """
    cancelled = np.array([collided[first:end].all() for first, end in pairwise(frames)], bool)
    return np.concatenate([[0], np.where(cancelled, 3, np.where(action[frames[:-1]] == 0, 1, 2))])


def distance(pose: np.ndarray, earlier: np.ndarray) -> np.ndarray:
    """Metres (N,) from each pose (N, 3) to the nearest earlier one (M, 3) of the same heading; inf without one."""
    far = 2 * NEW  # headings as a place on a circle, so that a chord of SAME_WAY is as long as `far`
    circle = far / (2 * np.sin(SAME_WAY / 2))
    def place(poses: np.ndarray) -> np.ndarray:
        return np.column_stack([poses[:, :2], circle * np.cos(poses[:, 2]), circle * np.sin(poses[:, 2])])
    from scipy.spatial import cKDTree  # late: few commands need it

    tree, found = cKDTree(place(earlier)), np.full(len(pose), np.inf)
    for n, near in enumerate(tree.query_ball_point(place(pose), np.hypot(far, far))):
        turned = np.abs((earlier[near, 2] - pose[n, 2] + np.pi) % (2 * np.pi) - np.pi)
        same = np.asarray(near, np.int64)[turned <= SAME_WAY]
        if len(same):
            found[n] = np.hypot(*(earlier[same, :2] - pose[n, :2]).T).min()
    return found


def table(found: Views) -> list[dict[str, Any]]:
    """Make a row for each kind of action: numbers of views; of each signal both means, their ratio and the AUC."""
    rows = []
    for kind, name in enumerate(KINDS):
        of_kind = found.settled & ((found.kind == kind) if kind else (found.kind > 0))
        new, known = of_kind & (found.distance > NEW), of_kind & (found.distance < KNOWN)
        row: dict[str, Any] = {"views": name, "new": int(new.sum()), "known": int(known.sum())}
        for name, signal in zip(SIGNALS, found.signal, strict=True):
            row |= {f"{name} {key}": value for key, value in compared(signal[new], signal[known]).items()}
        rows.append(row)
    return rows


def compared(new: np.ndarray, known: np.ndarray) -> dict[str, float | None]:
    """Means, ratio and AUC of a signal over new and known views; None each where there are none."""
    if not len(new) or not len(known):
        return dict.fromkeys(("new", "known", "ratio", "auc"))
    means = float(new.mean()), float(known.mean())
    from scipy.stats import mannwhitneyu

    auc = float(mannwhitneyu(new, known).statistic) / (len(new) * len(known))
    return {"new": means[0], "known": means[1], "ratio": means[0] / means[1] if means[1] > 0 else None, "auc": auc}


def by_position(found: Views) -> dict[int, float]:
    """Mean KL in nats by the position in a window: what starting from a zero state adds."""
    return {int(n): float(found.signal[0][found.position == n].mean())
            for n in (0, 1, 2, 5, 10, 20, found.position.max()) if (found.position == n).any()}
