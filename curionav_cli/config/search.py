"""Sweepers that draw their own values: what they search, which settings they allow, and how a search is resumed.

Optuna's is supported in full (the extra hpo: hydra-optuna-sweeper 1.3.0 on optuna 2.10). Its trials are in a file of
the sweep's folder, and the number of a run is that of its trial.
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from hydra._internal.callbacks import Callbacks
from hydra._internal.hydra import Hydra
from hydra.core.config_store import ConfigStore
from hydra.core.override_parser.types import IntervalSweep, Override, QuotedString, RangeSweep
from hydra.core.plugins import Plugins
from hydra.types import HydraContext, RunMode
from omegaconf import DictConfig, OmegaConf

from curionav_cli.config.suggestions import NAMES, closest, did_you_mean, in_words, type_of
from curionav_cli.errors import ConfigError

GRIDS = ("BasicSweeper", "ListSweeper")  # whose jobs are known before the first one runs
OPTUNA = "hydra_optuna_sweeper"
MINIMISES = ("hydra_orion_sweeper",)  # only; these get the negative of the objective
DIRECTIONS = {"maximize": "the largest ", "minimize": "the smallest "}
NOTE = "multirun.yaml"  # the overrides as typed, written by Hydra's own sweeper too; resume reads it
STORED = "sqlite:///${hydra.sweep.dir}/search.sqlite"


@dataclass(frozen=True)
class Engine:
    """A sweeper other than Hydra's own. package: its plugin's. space: what it draws from, as typed.

    searches: whether it uses the objective of each run. direction, trials: of its settings; "" and None without one.
    resumable: whether the sweep's folder holds what it needs to continue.
    """

    package: str
    searches: bool
    space: list[str]
    direction: str = ""
    trials: int | None = None
    resumable: bool = False

    def about(self, objective: str) -> str:
        """The objective, direction and space of the search, as printed before the first trial."""
        name = self.package.removeprefix("hydra_").removesuffix("_sweeper")
        aim, asked = "", "the direction is its own"
        if self.direction:
            aim, asked = DIRECTIONS[self.direction], f"hydra.sweeper.direction={self.direction}"
        elif self.package in MINIMISES:
            aim, asked = DIRECTIONS["maximize"], "it minimises the negative"
        trials = f", {self.trials} trials" if self.trials else ""
        lines = [f"{name} searches for {aim}{objective} ({asked}){trials}:", *(f"  {line}" for line in self.space)]
        return "\n".join(lines)


def defaults() -> None:
    """Register our defaults of Optuna's sweeper: maximise, keep a file to resume from, go on after a failed trial."""
    store = ConfigStore.instance()
    if "optuna.yaml" in store.repo.get("hydra", {}).get("sweeper", {}):
        from hydra_plugins.hydra_optuna_sweeper.config import OptunaSweeperConf

        store.store(group="hydra/sweeper", name="optuna", node=OptunaSweeperConf(
            direction="maximize", storage=STORED, study_name="search", max_failure_rate=1.0))


def engine(config: DictConfig, swept: Sequence[Override]) -> Engine | None:
    """The sweeper of a composed configuration; None for Hydra's own. Raises ConfigError for settings it cannot have."""
    sweeper = config.hydra.sweeper
    _, package, *_, name = sweeper._target_.split(".")
    if name == "BasicSweeper":
        return None
    space = [str(override.input_line) for override in swept if override.is_sweep_override() or foreign(override)]
    if package != OPTUNA:
        return Engine(package, name not in GRIDS, space, resumable=name in GRIDS)
    for key, least, most in (("n_trials", 1, float("inf")), ("n_jobs", 1, float("inf")), ("max_failure_rate", 0, 1)):
        if not least <= sweeper[key] <= most:
            raise ConfigError(f"hydra.sweeper.{key}={sweeper[key]} is " + (
                f"less than {least}." if sweeper[key] < least else f"more than {most}."))
    if sweeper.sampler._target_.endswith("GridSampler"):  # it does not store the point of an interrupted trial
        raise ConfigError("hydra/sweeper/sampler=grid: a grid is what a plain sweep runs, and that can be resumed. "
                          "Leave out hydra/sweeper.")
    space += [f"{key}={value}" for key, value in (sweeper.search_space or {}).items()]
    if not space:
        raise ConfigError("Nothing is searched. Give a setting values to draw from, such as "
                          "'agent.gamma=interval(0.9,0.99)'.")
    return Engine(package, True, space, direction(sweeper.direction), sweeper.n_trials,
                  bool(sweeper.storage and sweeper.study_name))


def direction(setting: Any) -> str:
    """The direction of a search, maximize or minimize. Raises ConfigError for another, or for several."""
    words = [getattr(each, "name", str(each)) for each in (setting if OmegaConf.is_list(setting) else [setting])]
    if len(words) != 1:
        raise ConfigError(f"hydra.sweeper.direction={setting}: a run has one objective. Give one direction.")
    if words[0] not in DIRECTIONS:
        raise ConfigError(f"hydra.sweeper.direction: {words[0]!r} is not one of {', '.join(DIRECTIONS)}."
                          + did_you_mean(closest(words[0], DIRECTIONS)))
    return words[0]


def foreign(override: Override) -> bool:
    """Whether the value is a distribution in another sweeper's grammar: "uniform(20,60)", quoted."""
    value = override._value  # value() would drop the quotes
    return isinstance(value, QuotedString) and value.text.endswith(")") and value.text.split("(")[0].isidentifier()


def ends(override: Override, engine: Engine) -> list[str]:
    """The 'key=value' words of an override: each choice, or both ends of a range."""
    value, key = override.value(), override.get_key_element()
    if isinstance(value, IntervalSweep):
        return [f"{key}={value.start}", f"{key}={value.end}"]
    if isinstance(value, RangeSweep) and engine.package == OPTUNA:  # which draws the end of a range too
        assert value.start is not None and value.stop is not None
        return [f"{key}={value.start}", f"{key}={value.start + (value.stop - value.start) // value.step * value.step}"]
    if override.is_sweep_override():
        return [f"{key}={each}" for each in override.sweep_string_iterator()]
    return [] if foreign(override) and engine.package != OPTUNA else [str(override.input_line)]


def corners(axes: Sequence[list[str]]) -> list[list[str]]:
    """Jobs that use each value once: the first values of all axes, then each other value with the first of the rest."""
    first = [axis[0] for axis in axes]
    return [first] + [[*first[:place], value, *first[place + 1:]]
                      for place, axis in enumerate(axes) for value in axis[1:]]


def refuse_fractions(config: DictConfig, override: Override) -> None:
    """Refuse an interval of fractions for a whole number. Raises ConfigError."""
    value, key = override.value(), override.get_key_element()
    if isinstance(value, IntervalSweep) and isinstance(value.start, float) and \
            in_words(type_of(config, key)) == NAMES[int]:
        _, _, typed = str(override.input_line).partition("=")
        raise ConfigError(f"{override.input_line} draws fractions, and {key} is a whole number. "
                          f"Draw whole ones: '{key}=int({typed})'")


def run(hydra: Hydra, words: list[str], folder: Path, engine: Engine, task: Any) -> None:
    """Let the sweeper launch `task` for each trial in `folder`; a search that has begun there is continued."""
    os.environ.setdefault("SQLALCHEMY_SILENCE_UBER_WARNING", "1")  # optuna 2.10 was written for SQLAlchemy 1.4
    own = [word for word in words if word not in engine.space or engine.package == OPTUNA]
    config = hydra.compose_config("config", own, RunMode.MULTIRUN, with_log_configuration=True)
    arguments = [*config.hydra.overrides.task, *(word for word in words if word not in own)]
    folder.mkdir(parents=True, exist_ok=True)
    if engine.resumable:
        OmegaConf.save(config, folder / NOTE)
    done = finished_trials(config) if engine.package == OPTUNA and engine.resumable else 0
    if done and config.hydra.sweeper.sampler.get("seed") is not None:
        config.hydra.sweeper.sampler.seed += done  # the same seed would draw the first points again
    context = HydraContext(config_loader=hydra.config_loader, callbacks=Callbacks())
    sweeper: Any = Plugins.instance().instantiate_sweeper(config=config, hydra_context=context, task_function=task)
    if engine.package == OPTUNA:
        sweeper.sweeper.job_idx, sweeper.sweeper.n_trials = done, max(0, config.hydra.sweeper.n_trials - done)
    with log_printed(f"hydra_plugins.{engine.package}"):
        sweeper.sweep(arguments=arguments)


def finished_trials(config: DictConfig) -> int:
    """Count the trials that have ended, and put interrupted ones back into the queue, where they come first.

    Raises ConfigError where the file holds a search in another direction.
    """
    import optuna

    optuna.logging.set_verbosity(optuna.logging.WARNING)  # the sweeper logs the same, without colours
    sweeper = config.hydra.sweeper
    try:
        study = optuna.create_study(study_name=sweeper.study_name, storage=sweeper.storage, load_if_exists=True,
                                    direction=direction(sweeper.direction))
    except ValueError as error:
        raise ConfigError(f"{config.hydra.sweep.dir} holds a search in another direction than hydra.sweeper.direction="
                          f"{sweeper.direction}. Name another folder.") from error
    waiting = optuna.trial.TrialState.WAITING
    interrupted = [trial for trial in study.trials if not trial.state.is_finished()]
    for trial in interrupted:
        study._storage.set_trial_state(trial._trial_id, waiting)
    return len(study.trials) - len(interrupted)


@contextmanager
def log_printed(package: str) -> Iterator[None]:
    """Print the log of a sweeper: what failed, what it left out, the best that it found."""
    log, handler = logging.getLogger(package), logging.StreamHandler(sys.stdout)
    before = log.level, log.propagate
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    log.propagate = False  # not into the log of the last run
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.level, log.propagate = before


def noted(folder: Path) -> dict[str, Any]:
    """The part hydra.sweeper of a sweep's folder, as composed; {} where none is recorded."""
    note = folder / NOTE
    try:
        return dict(yaml.safe_load(note.read_text())["hydra"]["sweeper"]) if note.is_file() else {}
    except (yaml.YAMLError, KeyError, TypeError, ValueError):
        return {}
