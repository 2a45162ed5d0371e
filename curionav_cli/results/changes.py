"""What a changing world does to surprise and to coverage, from stored runs: what moved, and who was near, and when.

An object's age in an episode is the number of episodes since the one before which it moved. A frame belongs to the
youngest object within NEAR of where that stands now or stood before it moved; frames near none that ever moved are
*elsewhere*. Surprise is given relative to the mean elsewhere in the same episode, which takes out that a model gets
better; means are over episodes, with 95 % t intervals. A run without changes is the control: it is asked about the
same places in the same episodes, where nothing moved.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from curionav_cli.records import Episode, Prediction, Surprise
from curionav_cli.results.prediction.novelty import SETTLED
from curionav_cli.results.runs import Run
from curionav_cli.results.statistics import Estimate, mean_interval
from curionav_cli.results.tables import Columns, Row
from curionav_cli.storage.pictures import numbers

NEAR = 1.0  # metres
OLDEST = 6  # episodes: older ones are counted together
ELSEWHERE = -1
LIKE_ELSEWHERE = 1.1  # relative surprise that counts as expected
COLUMNS: Columns = (
    ("env", "env", "{}"), ("agent", "agent", "{}"), ("seed", "seed", "{}"), ("moves", "moves", "{:,}"),
    ("coverage of the floor", "coverage", "{:.1%}"), ("area", "area", "{:.3f}"), ("steps", "steps", "{:,}"),
    ("steps near what just moved", "near", "{:.1%}"), ("what ever moved", "ever", "{:.1%}"),
    ("surprise there, of elsewhere", "fresh", "{:.2f}"), ("expected after, episodes", "expected", "{}"))
AGE_COLUMNS: Columns = (
    ("env", "env", "{}"), ("agent", "agent", "{}"), ("seed", "seed", "{}"), ("episodes since the move", "age", "{}"),
    ("episodes", "episodes", "{:,}"), ("frames", "frames", "{:,}"), ("KL, nats", "kl", "{:.3f}"),
    ("of elsewhere", "relative", "{:.2f}"))
BELOW = (
    f"near: within {NEAR:g} m of where an object stands or stood before its last move; of elsewhere: mean KL over "
    "that of frames near nothing that ever moved, in the same episode, with its 95 % t interval; expected after: the "
    f"first age from which it stays at {LIKE_ELSEWHERE:g} or below, or its interval holds 1, of ages with two "
    "episodes or more")


class Item(NamedTuple):
    """A movable object: places in metres, now and before it moved, and the episode before which it moved."""

    now: tuple[float, float]
    before: tuple[float, float]
    moved: int


class Seen(NamedTuple):
    """What a run met. age: (steps + 1,) of each episode, ELSEWHERE where nothing was near. kl: of each episode that has
    a prediction, age -> frames' KL, nats."""

    run: Run
    moves: int
    age: list[np.ndarray]
    kl: dict[int, dict[int, np.ndarray]]

    @property
    def changing(self) -> bool:
        """Whether objects moved in this run itself."""
        return bool(self.run.config["env"].get("changes", True))


def history(events: Sequence[Sequence[dict]]) -> list[dict[str, Item]]:
    """Everything that has ever moved, in each of E episodes. events: of each episode, in order."""
    known: dict[str, Item] = {}
    found = []
    for episode, here in enumerate(events):
        known = known | {event["item"]: Item(tuple(event["to"]), tuple(event["from"]), episode)
                         for event in here if event["what"] == "move"}
        found.append(known)
    return found


def ages(pose: np.ndarray, items: dict[str, Item], episode: int) -> np.ndarray:
    """The age (n,) of the youngest object near each pose (n, 3), at most OLDEST; ELSEWHERE where none is near."""
    found = np.full(len(pose), OLDEST + 1)
    for item in items.values():
        away = np.min([np.hypot(*(pose[:, :2] - place).T) for place in (item.now, item.before)], axis=0)
        found[away <= NEAR] = np.minimum(found[away <= NEAR], min(episode - item.moved, OLDEST))
    return np.where(found > OLDEST, ELSEWHERE, found)


def seen(run: Run, episodes: Sequence[Episode], items: Sequence[dict[str, Item]]) -> Seen:
    """Sort the frames of a run by the age of what is near. items: of each episode, of this run or of its partner."""
    each = [ages(one.pose, here, index) for index, (one, here) in enumerate(zip(episodes, items))]
    stored = {index: Prediction.load_surprise(path) for index, path in run.predictions.items() if index < len(each)}
    kl = {index: by_age(surprise, each[index]) for index, surprise in stored.items()}
    return Seen(run, sum(item.moved == index for index, here in enumerate(items) for item in here.values()), each, kl)


def by_age(surprise: Surprise, age: np.ndarray) -> dict[int, np.ndarray]:
    """KL of an episode's frames by the age of what is near them; frames that a window begins with are left out."""
    position = np.broadcast_to(np.arange(surprise.frame.shape[1]), surprise.frame.shape)
    settled = (position >= SETTLED) | (surprise.frame[:, :1] == 0)
    frames, kl = surprise.frame[settled], surprise.kl[settled]
    return {int(one): kl[age[frames] == one] for one in np.unique(age[frames])}


def pairs(runs: Sequence[Run]) -> tuple[list[Seen], list[str]]:
    """Read runs with changes, and those without beside one with them; a line about each that is left out.

    Sorted by world, agent, with changes first, and seed. What moves when follows from the world and the seed alone, so
    that the longest run tells it to one without changes.
    """
    read = {id(run): [numbers(path) for path in run.episodes] for run in runs}
    items = {id(run): history([one.events for one in read[id(run)]]) for run in runs}
    changing = {(run.config["env"]["name"], run.seed): run for run in sorted(runs, key=lambda run: len(read[id(run)]))
                if any(items[id(run)][-1:])}
    found, lost = [], []
    for run in runs:
        partner = run if any(items[id(run)][-1:]) else changing.get((run.config["env"]["name"], run.seed))
        if partner is None:
            lost.append(f"LEFT OUT: {run.folder.path}: nothing moved, and no run of its world and seed {run.seed} in "
                        "which something did was given beside it.")
            continue
        found.append(seen(run, read[id(run)], items[id(partner)]))
    return sorted(found, key=order), lost


def order(one: Seen) -> tuple[str, str, bool, bool, int | str]:
    """Where a run stands among others."""
    seed = one.run.seed
    return one.run.config["env"]["name"], one.run.agent, not one.changing, isinstance(seed, str), seed


def relative(kl: Iterable[dict[int, np.ndarray]]) -> dict[int, list[float]]:
    """Mean KL of each age over that elsewhere in the same episode, for the episodes that have both."""
    found: dict[int, list[float]] = defaultdict(list)
    for here in kl:
        base = float(here[ELSEWHERE].mean()) if len(here.get(ELSEWHERE, ())) else 0.0
        for age, values in here.items() if base > 0 else ():
            found[age].append(float(values.mean()) / base)
    return found


def age_rows(one: Seen) -> list[Row]:
    """A row for each age: frames, mean KL, and surprise relative to elsewhere."""
    kl: dict[int, list[np.ndarray]] = defaultdict(list)
    for here in one.kl.values():
        for age, values in here.items():
            kl[age].append(values)
    ratios = relative(one.kl.values())
    return [{**named(one.run), "age": written(age), "number": age, "episodes": len(kl[age]),
             "frames": sum(map(len, kl[age])), "kl": float(np.concatenate(kl[age]).mean()),
             "relative": mean_interval(np.array(ratios[age])) if ratios[age] else None}
            for age in sorted(kl, key=lambda age: (age == ELSEWHERE, age))]


def summary(one: Seen) -> Row:
    """A run's coverage, how often it was near what moved, and how soon its model expects that."""
    age = np.concatenate([each[1:] for each in one.age])
    rows = {row["number"]: row["relative"] for row in age_rows(one)}
    return {**named(one.run), "moves": one.moves if one.changing else 0,
            "coverage": one.run.coverage.share, "area": one.run.curve.area(), "steps": len(age),
            "near": float((age == 0).mean()), "ever": float((age != ELSEWHERE).mean()), "fresh": rows.get(0),
            "expected": expected({number: estimate for number, estimate in rows.items() if number != ELSEWHERE})}


def expected(relative: dict[int, Estimate | None]) -> str | None:
    """The first age from which the relative surprise stays low, or cannot be told from 1; None without surprise.

    An age with one episode has no interval and decides nothing.
    """
    known = {age: estimate for age, estimate in sorted(relative.items())
             if estimate is not None and not np.isnan(estimate.low)}
    if not known:
        return None
    high = [age for age, (value, low, _) in known.items() if value > LIKE_ELSEWHERE and not low <= 1]
    if not high:
        return "0"
    later = [age for age in known if age > high[-1]]
    return str(later[0]) if later else f"not within {written(high[-1])}"


def named(run: Run) -> Row:
    return {"env": run.env, "agent": run.agent, "seed": run.seed}


def written(age: int) -> str:
    return "elsewhere" if age == ELSEWHERE else f"{age} or more" if age == OLDEST else str(age)


def shares(runs: Sequence[Seen], width: int) -> tuple[np.ndarray, np.ndarray]:
    """The share of steps of some runs together near what just moved, in each stretch of `width` episodes, and the steps
    of the longest run at its end."""
    longest = max(runs, key=lambda one: len(one.age))
    stretches = [slice(start, start + width) for start in range(0, len(longest.age), width)]
    near = [np.concatenate([each[1:] == 0 for one in runs for each in one.age[here]]).mean() for here in stretches]
    steps = np.cumsum([len(each) - 1 for each in longest.age])
    return np.array([steps[here][-1] for here in stretches]), np.array(near)
