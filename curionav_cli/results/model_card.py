"""The README of a model card: what was trained, where, for how long, what it covered, and how it is used."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from curionav_cli.results import evaluations, tables
from curionav_cli.results.runs import Run

HIDDEN = ("run", "state")  # columns of evaluations that say where on a machine it was
USE = (("evaluate FOLDER env=apartment_1", "it acts, and learns nothing"),
       ("explore init=FOLDER env=apartment_1", "it goes on learning there"),
       ("train init=FOLDER data=outputs/DATE/RUN env=apartment_1", "it learns from stored episodes"))
LIMITS = ("It was trained in simulated worlds, with one seed. What it does in another world, on another robot or with "
          "another seed is not known until it is measured: `curionav evaluate`.")


def readme(run: Run, card: dict[str, Any], licence: str | None, figures: Sequence[str],
           measured: Sequence[dict[str, Any]]) -> str:
    """The text of README.md.

    card: the content of card.json. figures: names in the folder. measured: rows of evaluations of these weights.
    """
    facts = "\n".join(f"| {name} | {value} |" for name, value in about(run, card))
    commands = "\n".join(f"curionav {words:<58} # {what}" for words, what in USE)
    return "\n".join(part for part in (
        f"---\nlibrary_name: curionav\nlicense: {licence or 'other'}\n"
        "tags: [reinforcement-learning, robotics, exploration, intrinsic-motivation]\n---\n",
        f"# {card['agent']}, trained in {card['env']}\n",
        f"A robot explores a building without a map. Agent `{card['agent']}` of curionav {card['curionav']}, "
        f"{card['parameters']:,} weights.\n", f"| | |\n|---|---|\n{facts}\n",
        "## Use\n", f"```\n{commands}\n```\n", evaluated(measured), *(f"![]({name})\n" for name in figures),
        f"## Limits\n\n{LIMITS}\n", f"## Licence\n\n{licence or 'None was chosen by who trained it.'}\n",
        f"`weights.safetensors` has the SHA-256 {card['sha256']}; nothing in this folder is pickled.\n"))


def about(run: Run, card: dict[str, Any]) -> list[tuple[str, str]]:
    """Name and value of what is known of the training; of curionav train no coverage, as it runs no episodes."""
    settings, unit = run.config, card["unit"].removesuffix("s" if card["done"] == 1 else "")
    facts = [("world", card["env"]), ("robot", settings["robot"]["name"]),
             ("training", f"{card['done']:,} {unit}" + (f" of {card['steps']:,} steps in all" if card["steps"]
                                                         else " on stored episodes")),
             ("seed, preset", f"{settings['seed']}, {settings['scale']}")]
    last: dict[str, Any] = next(reversed(run.folder.metrics()), {})
    if card["unit"] == "episodes":
        row = run.row()
        facts.append(("covered while it learned", tables.covered(row["coverage"], row["visited"], row["cells"],
                                                                 row["denominator"])))
        facts += [(name, str(row[name])) for name in ("docked", "carried") if name in row]
    facts += [(name, f"{last[key]:.4f}") for name, key in (
        ("error of images predicted 5 actions ahead, last episode", "open_loop_mse_5"),
        ("the same of repeating the last image", "repeat_mse_5"), ("error on the building's probe", "probe_error"))
        if key in last]
    facts += [(name, f"{last[key]:,.0f}") for name, key in (("updates", "updates"), ("frames read", "frames_replayed"))
              if key in last]
    return facts


def evaluated(rows: Sequence[dict[str, Any]]) -> str:
    """The part about evaluations; empty where there were none."""
    columns = tuple(column for column in evaluations.COLUMNS
                    if column[0] not in HIDDEN and any(row.get(column[1]) is not None for row in rows))
    return f"## Evaluated\n\n{tables.markdown(rows, columns, evaluations.BELOW)}" if rows else ""
