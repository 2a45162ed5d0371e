"""Answers to wrong overrides, in one to four lines: what is wrong, and what to type instead; each a ConfigError.

Hydra's own answers are long, and its advice for an unknown key ("use +key=1") adds a key that nothing reads.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from functools import cached_property
from pathlib import Path
from typing import NoReturn, get_type_hints

import yaml
from hydra._internal.hydra import Hydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.core.utils import JobRuntime
from hydra.errors import HydraException, MissingConfigException, OverrideParseException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from curionav_cli.agents.registry import unread
from curionav_cli.config import catalogue
from curionav_cli.config.paths import as_text
from curionav_cli.config.suggestions import (
    closest,
    did_you_mean,
    exists,
    first_line,
    has,
    in_words,
    located,
    near_options,
    of_agents,
    owner_of,
)
from curionav_cli.errors import ConfigError

EXTRAS = {  # of pyproject.toml
    "hydra/launcher": {"joblib": "sweep", "submitit_slurm": "slurm", "submitit_local": "slurm"},
    "hydra/sweeper": {"optuna": "hpo"},
}
REQUIRED = ("env", "agent", "robot", "scale")
FOR_SWEEPS = re.compile(r"launcher$|hydra[/.](launcher|sweeper)\b")
PARAMS = "hydra.sweeper.params."
UNREADABLE = (HydraException, OmegaConfBaseException, yaml.YAMLError, ValueError, OSError,
              AssertionError)  # OmegaConf's, for a key below one that is null


class OverrideErrors:
    """Checks of the overrides of one command line. words: the overrides as typed."""

    def __init__(self, hydra: Hydra, words: Sequence[str]):
        self.hydra = hydra
        self.words = list(words)
        self.command = f"curionav {JobRuntime.instance().get('name')}"

    @cached_property
    def groups(self) -> dict[str, list[str]]:
        return catalogue.groups(self.hydra)

    def parse(self, multirun: bool) -> list[Override]:
        """Parse the overrides, and check each one as far as it can be without composing. Raises ConfigError."""
        for index, word in enumerate(self.words):
            if word.startswith("-"):
                self.dashes(word, self.words[index + 1 : index + 2])
        parser = OverridesParser.create(config_loader=self.hydra.config_loader)
        overrides = []
        for word in self.words:
            try:
                overrides += parser.parse_overrides([word])
            except OverrideParseException as error:
                self.unreadable(word, error)
        for override in overrides:
            self.check(override, multirun)
        return overrides

    def check(self, override: Override, multirun: bool) -> None:
        """Refuse a sweep without -m, a removed key, an option that its group does not have. Raises ConfigError."""
        key, swept = override.key_or_group, override.is_sweep_override()
        options = catalogue.options_of(self.hydra, key)
        if not key:
            raise ConfigError(f"{override.input_line} names no setting. Settings are written as key=value.")
        if override.is_delete():
            raise ConfigError(f"{override.input_line}: a setting can be changed, not removed. Give it another value.")
        if swept and not multirun:
            line = as_text(str(override.input_line))
            text = f"\n(If it is one text: {line}; if {key} is itself a list: {key}=[...].)"
            raise ConfigError(f"A list of values needs a sweep. Add -m: {self.command} -m {shlex.join(self.words)}"
                              + ("" if options else text))
        if swept and not override.is_discrete_sweep():
            return
        value = list(override.sweep_string_iterator()) if swept else override.value()
        if swept and not value:
            nothing = f"{override.input_line} matches nothing, so no job would run."
            raise ConfigError(nothing + has(key, options))
        if options and override.package is None:
            for choice in value if isinstance(value, list) else [value]:
                self.option(key, choice, options)

    def option(self, group: str, choice: object, options: list[str]) -> None:
        """Refuse a choice that is none of the group's options. Raises ConfigError."""
        if str(choice) in options or (choice in (None, "null") and group not in REQUIRED):
            return
        if extra := EXTRAS.get(group, {}).get(str(choice)):
            raise ConfigError(f"{group}={choice} needs the extra {extra}, which is not installed. "
                              f".venv/bin/pip install -c constraints.txt -e '.[{extra}]'")
        if choice in (None, "null", ""):
            raise ConfigError(f"{group} needs one of its options." + has(group, options))
        guess = did_you_mean(near_options(str(choice), options))
        raise ConfigError(f"There is no {choice} in the group {group}.{guess}" + has(group, options))

    def refuse_sweeps(self, overrides: list[Override]) -> None:
        """Refuse a launcher or a sweeper without -m, which nothing would read. Raises ConfigError."""
        for override in overrides:
            if FOR_SWEEPS.match(override.key_or_group) and override.value() is not None:
                line = f"{self.command} -m {shlex.join(self.words)}"
                raise ConfigError(f"{override.input_line} is for sweeps. Add -m: {line}")

    def dashes(self, word: str, following: list[str]) -> NoReturn:
        """Raise ConfigError for an unknown option, with the setting that is nearest."""
        name, _, value = word.lstrip("-").partition("=")
        value = value or next((text for text in following if not text.startswith("-")), "...")
        known = self.known_keys([])
        key = next(iter(closest(name, known)), name)
        raise ConfigError(
            f"There is no option {word}. Settings are written without dashes: {key}={value}\n"
            f"{self.command} --help lists options and settings."
        )

    def unreadable(self, word: str, error: OverrideParseException) -> NoReturn:
        """Raise ConfigError for a word that is no key=value."""
        if re.fullmatch(r"[\w./]+", word):
            options = self.groups.get(word)
            known = self.known_keys([])
            if options or word in known:
                raise ConfigError(f"{word} needs a value: {word}=..." + has(word, options or []))
            guess = self.guess(word, known)
            raise ConfigError(f"{word} is not a setting. Settings are written as key=value.{guess}")
        if "=" not in word:
            raise ConfigError(f"{word!r} is not a setting. Settings are written as key=value; "
                              f"{self.command} --help lists them all.")
        raise ConfigError(
            f"{word} cannot be read as key=value: {first_line(str(error.message))}\n"
            f"Text with commas, brackets and the like is quoted twice, for the shell and for Hydra: {as_text(word)}"
        ) from error

    @contextmanager
    def explained(self, job: list[str]) -> Iterator[None]:
        """Turn what Hydra, OmegaConf and the YAML parser raise while composing `job` into a ConfigError."""
        try:
            yield
        except MissingConfigException as error:
            group, _, choice = str(error.missing_cfg_file).rpartition("/")
            self.option(group, choice, list(error.options or []))
            raise ConfigError(first_line(str(error))) from error
        except yaml.MarkedYAMLError as error:
            mark = error.problem_mark
            where = f"{mark.name}, line {mark.line + 1}" if mark else "a config file"
            raise ConfigError(f"{where}: this is not YAML: {error.problem}.") from error
        except UNREADABLE as error:
            self.composition(job, error)

    def composition(self, job: list[str], error: Exception) -> NoReturn:
        """Raise ConfigError for an unknown key; where all are known, for a wrong value."""
        base = self.base(job)
        for override in self.values_of(job):
            key = override.key_or_group
            known = catalogue.hydra_keys(base) if key.startswith("hydra.") else [key for key, _ in catalogue.flat(base)]
            inner = [name for name in known if name.startswith(f"{key}.")]
            if inner:
                raise ConfigError(f"{key} holds several settings: {', '.join(inner)}.") from error
            if not (override.is_add() or override.is_force_add() or exists(base, key)):
                if key.startswith(PARAMS):
                    raise ConfigError(f"{override.input_line}: no such key is declared. Type the setting itself: "
                                      f"{str(override.input_line).removeprefix(PARAMS)}") from error
                raise ConfigError(f"The settings have no key {key}.{self.guess(key, known)}") from error
        self.value(job, base, error)

    def value(self, job: list[str], base: DictConfig, error: Exception) -> NoReturn:
        """Raise ConfigError for a known key with a value that its type does not allow, typed or in a file."""
        inner = located(error)
        file = re.match(r"In '([^']+)'", str(error))
        where = f"{self.file(file[1])}: " if file else ""
        key = str(inner.full_key).partition("[")[0] if inner and inner.full_key else ""
        parent, dot, leaf = key.rpartition(".")
        owner = owner_of(inner.parent_node, "") if inner and file else owner_of(base, parent)
        hints = get_type_hints(owner) if is_dataclass(owner) else {}
        if file and hints and leaf not in hints:
            known = [f"{parent}{dot}{name}" for name in hints]
            raise ConfigError(f"{where}the settings have no key {key}.{self.guess(key, known)}") from error
        typed = {override.key_or_group: override for override in self.values_of(job)}
        expected = in_words(hints.get(leaf))
        if expected:
            text = str(typed[key].input_line).partition("=")[2] if key in typed else getattr(inner, "value", "it")
            raise ConfigError(f"{where}{key}: {text!r} is not {expected}.") from error
        raise ConfigError(where + "\n".join(str(inner or error).splitlines()[:2])) from error

    def refuse_unread(self, config: DictConfig) -> None:
        """Refuse what the agent does not read, and +key=1 for a key that no schema has. Raises ConfigError."""
        for override in self.values_of(self.words):
            parent, _, leaf = override.key_or_group.rpartition(".")
            owner = owner_of(config, parent)
            if leaf in unread(owner):
                raise ConfigError(f"agent={config.agent.name} does not read {parent}.{leaf}."
                                  + of_agents(override.key_or_group))
            if not (override.is_add() or override.is_force_add()):
                continue
            if is_dataclass(owner) and leaf not in {field.name for field in fields(owner)}:
                known = [key for key, _ in catalogue.flat(config) if key != override.key_or_group]
                guess = self.guess(override.key_or_group, known)
                raise ConfigError(f"{override.input_line} would add a key that nothing reads.{guess}")

    def base(self, job: list[str]) -> DictConfig:
        """What the groups alone compose to: its keys are the ones to suggest."""
        values = {override.input_line for override in [*self.values_of(job), *self.swept(job)]}
        for words in ([word for word in job if word not in values], []):
            try:
                return self.hydra.compose_config("config", words, catalogue.RunMode.RUN)
            except UNREADABLE:
                continue
        return OmegaConf.create()

    def known_keys(self, job: list[str]) -> list[str]:
        return [key for key, _ in catalogue.flat(self.base(job))]

    def values_of(self, job: list[str]) -> list[Override]:
        """The overrides that set a key, not an option of a group."""
        parsed = OverridesParser.create(config_loader=self.hydra.config_loader).parse_overrides(job)
        return [override for override in parsed if not catalogue.options_of(self.hydra, override.key_or_group)]

    def swept(self, job: list[str]) -> list[Override]:
        """The overrides with several values, of keys and of groups."""
        parsed = OverridesParser.create(config_loader=self.hydra.config_loader).parse_overrides(job)
        return [override for override in parsed if override.is_sweep_override()]

    def guess(self, key: str, known: list[str]) -> str:
        close = closest(key, [*known, *self.groups])
        return of_agents(key) or did_you_mean(close) or f"\n{self.command} --help lists them all."

    def file(self, config_path: str) -> str:
        """The path of 'env/mine' on the search path; env=map for a file of ours, which is not to be mended."""
        for source in self.hydra.config_loader.get_sources():
            path = Path(source.path) / f"{config_path}.yaml"
            if source.scheme() == "file" and path.is_file():
                return config_path.replace("/", "=") if source.provider == "main" else str(path)
        return config_path
