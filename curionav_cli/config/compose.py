"""Compose every job once before anything runs, so that a wrong setting is answered at the prompt."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice, product
from pathlib import Path
from typing import cast

from hydra._internal.hydra import Hydra
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from curionav_cli.config.loader import Loader
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.paths import as_typed, quoted
from curionav_cli.config.safety import refuse_callables
from curionav_cli.config.schema import Config
from curionav_cli.config.search import Engine, corners, ends, engine, foreign, refuse_fractions
from curionav_cli.config.settings import as_settings
from curionav_cli.config.sources import MAIN, opened
from curionav_cli.config.suggestions import first_line
from curionav_cli.errors import ConfigError, SceneError, UserError
from curionav_cli.files import folder_for

COMPOSED = 16  # jobs; of a larger sweep each value is still composed once


@dataclass(frozen=True)
class Plan:
    """What is to be run. overrides: for Hydra, with the output folder fixed. jobs: the overrides of each job.

    beside: whether the jobs run in other processes; queued: as jobs of Slurm.
    engine: a sweeper that draws its own values; `jobs` are then examples of what it can draw.
    """

    overrides: list[str]
    multirun: bool
    folder: Path
    jobs: list[list[str]]
    beside: bool = False
    queued: bool = False
    engine: Engine | None = None


Check = Callable[[Config], None]


def plan(hydra: Hydra, words: list[str], multirun: bool, check: Check | None = None) -> Plan:
    """Plan the run or sweep that `words` ask for. Raises ConfigError, or what `check` raises, with the cure."""
    words = [as_typed(hydra, word) for word in words]
    mistakes = OverrideErrors(hydra, words)
    overrides = mistakes.parse(multirun)
    own = [word for override, word in zip(overrides, words) if not (multirun and foreign(override))]
    mode = RunMode.MULTIRUN if multirun else RunMode.RUN
    with mistakes.explained(own):
        master = hydra.compose_config(MAIN, own, mode)
    refuse_callables(master)
    multirun = multirun or master.hydra.mode == RunMode.MULTIRUN
    if not multirun and check is not None:  # without a check nothing runs
        mistakes.refuse_sweeps(overrides)
    swept = [*sweeper_params(hydra, master), *overrides] if multirun else []
    drawn = engine(master, swept) if multirun else None
    jobs = expand(master, swept, drawn) if multirun else [words]
    for job in sample(jobs):
        settings, chosen = compose(hydra, mistakes, job)
        if check is not None:
            with naming_the_cause(hydra, mistakes, job, check, f"env/{settings.env.name}.yaml", f"env/{chosen}"):
                check(settings)
    folder = output_folder(master, multirun)
    if not folder.strip():
        raise ConfigError(f"hydra.{'sweep' if multirun else 'run'}.dir is empty. Name a folder, or leave it out.")
    where = folder_for(folder)
    if master.hydra.launcher.get("n_jobs") == 0:
        raise ConfigError("hydra.launcher.n_jobs=0 runs nothing. It is how many run at once; -1: as many as cores.")
    launcher = master.hydra.launcher._target_.rpartition(".")[2] if multirun else "BasicLauncher"
    pinned = pin(where, multirun)
    if own == words:
        cast(Loader, hydra.config_loader).pin(MAIN, words, mode, pinned)
    return Plan(words + [pinned], multirun, where, jobs, launcher != "BasicLauncher",
                launcher == "SlurmLauncher", drawn)


def compose(hydra: Hydra, mistakes: OverrideErrors, job: list[str]) -> tuple[Config, str]:
    """The settings of a job, and the name of its environment's file."""
    with mistakes.explained(job):
        config = hydra.compose_config(MAIN, job, RunMode.RUN)
    refuse_callables(config)
    chosen = str(config.hydra.runtime.choices.env)
    mistakes.refuse_unread(config)
    return as_settings(config), chosen


def composed(command: str, *words: str, config_dirs: Sequence[Path] = ()) -> Config:
    """The settings that `words` give to a command, as in composed("explore", "env=large_lab"). Raises ConfigError."""
    with opened(command, *config_dirs) as hydra:
        return compose(hydra, OverrideErrors(hydra, words), list(words))[0]


@contextmanager
def naming_the_cause(hydra: Hydra, mistakes: OverrideErrors, job: list[str], check: Check, scene: str,
            file: str) -> Iterator[None]:
    """Let a SceneError name the setting that causes it, or else the scene's file."""
    try:
        yield
    except SceneError as error:
        own = [word.input_line for word in mistakes.values_of(job) if word.key_or_group.startswith("env.")]
        cause = next((word for word in own if is_valid(hydra, mistakes, [it for it in job if it != word], check)), "")
        raise SceneError(str(error).replace(f"{scene}:", f"{cause or mistakes.file(file)}:", 1)) from error


def is_valid(hydra: Hydra, mistakes: OverrideErrors, job: list[str], check: Check) -> bool:
    """Whether the job composes and passes the check."""
    try:
        check(compose(hydra, mistakes, job)[0])
    except UserError:
        return False
    return True


def sweeper_params(hydra: Hydra, master: DictConfig) -> list[Override]:
    """hydra.sweeper.params as overrides. Raises ConfigError for one that cannot be read."""
    parser = OverridesParser.create(config_loader=hydra.config_loader)
    params = [f"{key}={value}" for key, value in (master.hydra.sweeper.get("params") or {}).items()]
    try:
        return parser.parse_overrides(params)
    except HydraException as error:
        if not master.hydra.sweeper._target_.endswith(("BasicSweeper", "OptunaSweeper")):
            return []  # it has a grammar of its own
        raise ConfigError("hydra.sweeper.params: each is a list of values, as in seed: 0,1,2 or seed: range(5). "
                          + first_line(str(error))) from error


def expand(master: DictConfig, swept: list[Override], drawn: Engine | None) -> list[list[str]]:
    """The jobs of a sweep as Hydra's basic sweeper makes them; of a sweeper that draws, both ends of each range."""
    axes = {override.get_key_element(): override for override in swept}
    for override in axes.values():
        if drawn:
            refuse_fractions(master, override)
        elif override.is_sweep_override() and not override.is_discrete_sweep():
            raise ConfigError(f"{override.input_line} needs a sweeper that draws values: hydra/sweeper=optuna. "
                              "Without one: key=1,2,3")
    values = [ends(override, drawn) if drawn else words_of(override) for override in axes.values()]
    kept = [axis for axis in values if axis]
    return corners(kept) if drawn else [list(job) for job in product(*kept)]


def words_of(override: Override) -> list[str]:
    """The 'key=value' words of an override, one for each of its values."""
    if not override.is_sweep_override():
        return [str(override.input_line)]
    return [f"{override.get_key_element()}={value}" for value in override.sweep_string_iterator()]


def sample(jobs: list[list[str]]) -> Iterator[list[str]]:
    """The first COMPOSED jobs, then those with a value that no job before them has."""
    yield from islice(jobs, COMPOSED)
    seen = {word for job in jobs[:COMPOSED] for word in job}
    for job in jobs[COMPOSED:]:
        if not seen.issuperset(job):
            seen.update(job)
            yield job


def output_folder(config: DictConfig, multirun: bool) -> str:
    """The output folder, resolved once: the time in its name changes whenever Hydra composes."""
    HydraConfig.instance().set_config(config)
    return str(OmegaConf.select(config, "hydra.sweep.dir" if multirun else "hydra.run.dir"))


def pin(folder: Path, multirun: bool) -> str:
    """The override that fixes the output folder; absolute, as a launcher's workers may run in another directory."""
    return f"hydra.{'sweep' if multirun else 'run'}.dir={quoted(str(folder.absolute()))}"
