"""docs/reference/settings.md: every setting with its type, default, range and meaning."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import yaml

from curionav_cli.config.catalogue import leaves
from curionav_cli.config.suggestions import in_words
from curionav_cli.places import conf_dir
from documentation.markdown import GENERATED, code, table
from documentation.settings_rows import Setting, common, meaning, options, scaled, settings, value

HEADER = ("setting", "type", "default", "range", "meaning")
SAID_ELSEWHERE = ("env.note", "env.visitable_sha256")  # of an option: docs/scenes.md and `curionav list` have them
ABOUT = """# Settings

Settings are typed as `KEY=VALUE` after a command: `curionav explore env=small_room loop.episodes=50`. `curionav explore
--help` shows the same keys with the values of what is chosen beside it. A value out of its range or of another type
and a key that does not exist are answered before anything runs. Values with commas or brackets are quoted:
`'env.start=[0.5,0.5,90]'`. With `-m` several values make a sweep: `seed=0,1,2`.

Groups are chosen by name: `env=`, `agent=`, `robot=`, `scale=`, `launcher=`, `experiment=`; `curionav list GROUP` shows
their options. Files of your own: [scenes](../scenes.md), [agents](../agents.md), `curionav init DIR`.

Where the bound of a range is another setting, the number shown is that setting's default.
"""


INTRODUCTIONS = {
    "remote": "[Remote training](../remote.md) says what they are for.",
    "env=small_room": "Rooms, walls, furniture and the other lists are those of a [scene](../scenes.md); they stand in "
                      "a file rather than on the command line.",
    "env=live": "[A real robot](../robot-live.md).",
    "agent=lbs_dreamer": "[Agents](../agents.md), [controls](../curiosity-controls.md), [fidelity](../fidelity.md).",
    "agent=curious_mapper": "[The curious mapper](../curious-mapper.md).",
    "agent=cbet": "[C-BET](../cbet.md).",
    "agent=mapper": "[Explorers](../explorers.md).",
    "robot=turtlebot2i": "[The simulated robot](../robot.md), [docking](../docking.md).",
    "robot=rosbridge": "[A real robot](../robot-live.md). The profile shown is that of `robot.profile=turtlebot2i`; "
                       "`turtlebot3`, `turtlebot4` and your own name other topics.",
}


def page() -> str:
    """The whole page."""
    remote = {key: one for key, one in common().items() if key.startswith("remote.")}
    run = {key: one for key, one in common().items() if key not in remote}
    lines = [GENERATED.format("the schema, conf/ and documentation/meanings.yaml"), "", ABOUT]
    lines += ["## A run", "", *table(HEADER, map(row, run.values())), ""]
    lines += ["## Remote training", "", INTRODUCTIONS["remote"], "", *table(HEADER, map(row, remote.values())), ""]
    for group, title in (("env", "Worlds"), ("agent", "Agents"), ("robot", "Robots")):
        lines += [f"## {title}", "", *families(options(group))]
    return "\n".join([*lines, *folders_and_launchers()]).rstrip() + "\n"


def row(one: Setting) -> tuple[str, ...]:
    return code(one.key), one.kind, code(value(one)), one.limits, meaning(one.key)


def families(words: Sequence[str]) -> Iterator[str]:
    """A part for each option; one with the settings of an earlier one says only what differs from that."""
    relatives = {word: relative(word, words[:index]) for index, word in enumerate(words)}
    for word in words:
        parent = relatives[word]
        if not parent:
            yield from [f"### `{word}`", "", *introduction(word), *own_table(word)]
            for other in (other for other, its in relatives.items() if its == word and not new_in(other, word)):
                yield from [f"`{other}` differs in {differing(other, word)}", ""]
        elif new := new_in(word, parent):
            yield from [f"### `{word}`", "", *introduction(word), f"It has the settings of `{parent}`, differing in "
                        f"{differing(word, parent)} Its own are:", "", *table(HEADER, map(row, new)), ""]


def new_in(word: str, parent: str) -> list[Setting]:
    """The settings that an option has and another has not."""
    return [one for key, one in settings(word).items() if key not in settings(parent)]


def relative(word: str, before: Sequence[str]) -> str | None:
    """The earlier option whose settings this one has too, and perhaps more; None for an option of its own kind."""
    return next((other for other in before if settings(other) and not new_in(other, word)), None)


def introduction(word: str) -> list[str]:
    return [INTRODUCTIONS[word], ""] if word in INTRODUCTIONS else []


def own_table(word: str) -> list[str]:
    """The table of an option, with a column for scale=paper where that sets other numbers."""
    found = settings(word)
    if not found:
        return ["It has no settings.", ""]
    if word not in scaled():
        return [*table(HEADER, map(row, found.values())), ""]
    paper = settings(word, paper=True)
    rows = [(*row(one)[:3], code(value(paper[key])) if paper[key].default != one.default else "the same", *row(one)[3:])
            for key, one in found.items()]
    return [*table((*HEADER[:2], "`scale=cpu`", "`scale=paper`", *HEADER[3:]), rows), ""]


def differing(word: str, parent: str) -> str:
    """The settings whose default is another one than the parent's, ended by a full stop."""
    pairs = [(one, settings(parent)[key]) for key, one in settings(word).items() if key in settings(parent)]
    other = [one for one, base in pairs if one.default != base.default and one.key not in SAID_ELSEWHERE
             and not a_scene(one.default) and not a_scene(base.default)]
    return (", ".join(code(f"{one.key}={value(one)}") for one in other) or "nothing") + "."


def a_scene(default: Any) -> bool:
    """Whether a default is a list or dictionary of a scene."""
    return isinstance(default, dict) or (isinstance(default, list) and any(isinstance(item, dict) for item in default))


def folders_and_launchers() -> list[str]:
    """The section of Hydra's settings that conf/ gives values."""
    main = yaml.safe_load((conf_dir() / "config.yaml").read_text(encoding="utf-8"))["hydra"]
    lines = ["## Folders and launchers", "", "Of Hydra's own settings these are of use; [scaling](../scaling.md) has "
             "examples, and those of searches (`hydra.sweeper`).", ""]
    found = [("", of_hydra(key, default)) for key, default in leaves(main, "hydra.")
             if key.startswith(("hydra.run.", "hydra.sweep."))]
    for path in sorted((conf_dir() / "launcher").glob("*.yaml")):
        launcher = yaml.safe_load(path.read_text(encoding="utf-8")).get("hydra", {})
        found += [(f"launcher={path.stem}", of_hydra(key, default)) for key, default in leaves(launcher, "hydra.")]
    return [*lines, *table(("with", *HEADER[:3], HEADER[4]), [
        (code(group), code(one.key), one.kind, code(value(one)), meaning(one.key)) for group, one in found])]


def of_hydra(key: str, default: Any) -> Setting:
    return Setting(key, in_words(type(default)) or "a list [...]", default, None, listed=False)
