"""Trained weights that a command begins with: curionav evaluate RUN, and init=RUN or pretrained=NAME.

With them the agent's settings come from the run, or model card, that they were trained in.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.config.compose import composed
from curionav_cli.config.paths import quoted
from curionav_cli.config.schema import Config, Learner
from curionav_cli.config.settings import plain_settings
from curionav_cli.errors import ConfigError
from curionav_cli.execution.launch import Request
from curionav_cli.execution.trained import take_weights, trained_in
from curionav_cli.places import place
from curionav_cli.storage.model_card import pretrained


def with_pretrained(request: Request) -> Request:
    """The request with init=FOLDER in place of pretrained=NAME. Raises ConfigError where there is no such agent."""
    words = [f"init={quoted(str(pretrained(word.partition('=')[2])))}" if word.startswith("pretrained=") else word
             for word in request.overrides]
    if len(without(words, "init")) < len(words) - 1:
        raise ConfigError("init=... and pretrained=... name trained weights twice. Leave one out.")
    return replace(request, overrides=words)


def with_agent_of(request: Request) -> Request:
    """The request of explore or train; the agent's settings are those of init=FOLDER unless agent=... is given.

    Raises ConfigError where the agents of several folders differ, RunFolderError where one cannot be read.
    """
    if request.info:
        return request
    request = with_pretrained(request)
    given, named = keys(request.overrides), folders(request.overrides)
    if not named or "agent" in given:
        return request
    taken = as_words(request, next(iter(settings_of(map(place, named)).values())), ())
    return replace(request, overrides=[*unless_given(taken, given), *request.overrides])


def keys(words: Iterable[str]) -> set[str]:
    """The keys that the words set."""
    return {word.partition("=")[0].lstrip("+~") for word in words}


def folders(words: Iterable[str]) -> list[str]:
    """The folders that init=... names, several with commas between them; none without it, or where it is null."""
    values = [word.partition("=")[2] for word in words if word.startswith("init=")]
    text = values[-1] if values else ""
    parts = [text] if place(text.strip("'\"")).exists() else text.split(",")
    return [part.strip("'\"") for part in parts if part not in ("", "null")]


def without(words: Iterable[str], key: str) -> list[str]:
    """The words but those that set `key`."""
    return [word for word in words if not word.startswith(f"{key}=")]


def unless_given(words: Iterable[str], given: Collection[str]) -> list[str]:
    """The words whose keys are not given."""
    return [word for word in words if word.partition("=")[0].lstrip("+") not in given]


def settings_of(paths: Iterable[Path]) -> dict[str, Config]:
    """The settings of trained runs and cards, by absolute path.

    Raises ConfigError where their agents differ, RunFolderError where one cannot be read.
    """
    found = {str(path.resolve()): trained_in(path).settings for path in paths}
    first = next(iter(found.values()))
    for path, settings in found.items():
        if (settings.agent, settings.scale) != (first.agent, first.scale):
            raise ConfigError(f"{path} has an agent of other settings than {next(iter(found))}. "
                              "Take them one after the other.")
    return found


def as_words(request: Request, settings: Config, groups: Sequence[str]) -> list[str]:
    """Scale, agent and these groups of a run as overrides: [scale=..., agent=..., agent.lr=..., env=...].

    Of a group only what differs from its file is among them; + is before keys that the file does not have.
    """
    groups = ["agent", *groups]
    words = [f"scale={settings.scale.value}", *(f"{group}={getattr(settings, group).name}" for group in groups)]
    recorded = plain_settings(settings)
    files = plain_settings(composed("evaluate", *words, config_dirs=request.config_dirs))
    held = {key: value for group in groups for key, value in leaves(files[group], group).items()}
    return words + [f"{'' if key in held else '+'}{key}={value}" for group in groups
                    for key, value in leaves(recorded[group], group).items() if value != held.get(key)]


def leaves(settings: dict[str, Any], prefix: str) -> dict[str, str]:
    """Dotted keys with their values as Hydra's grammar has them; lists stay whole."""
    found: dict[str, str] = {}
    for key, value in settings.items():
        found |= leaves(value, f"{prefix}.{key}") if isinstance(value, dict) else {f"{prefix}.{key}": literal(value)}
    return found


def literal(value: Any) -> str:
    """A value in Hydra's grammar: text in quotes, lists and dictionaries by their items."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, list):
        return f"[{','.join(map(literal, value))}]"
    if isinstance(value, dict):
        return "{" + ",".join(f"{key}:{literal(item)}" for key, item in value.items()) + "}"
    return json.dumps(value)


def check(settings: Config, world: build.World) -> None:
    """Check that the agent can take the weights of init=... Raises UserError."""
    if not settings.init:
        return
    if settings.storage or settings.learner is Learner.remote:
        raise ConfigError("init=... is for learning in one process: robot and server would begin with other weights. "
                          "Leave it out.")
    take_weights(build.agent(settings, world), settings, trained_in(Path(settings.init)))
