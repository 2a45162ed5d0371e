"""curionav card RUN [EVALUATION...]: a trained agent as a folder to take along, with weights, settings and a README."""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

from curionav_cli import __version__
from curionav_cli.commands.arguments import sorted_out
from curionav_cli.commands.summary import print_files, print_next
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import ConfigError
from curionav_cli.execution.evaluation import CHECKPOINT
from curionav_cli.execution.screen import a_console
from curionav_cli.execution.trained import Trained, trained_in
from curionav_cli.files import file_name, folder_for, read_json
from curionav_cli.results import evaluations, model_card
from curionav_cli.results.runs import Run, distinguish
from curionav_cli.storage import model_card as stored
from curionav_cli.storage.run_folder import RunFolder

CHOICES: dict[str, tuple[str, ...]] = {"out": (), "licence": (), "pretrained": ()}
FIGURES = ("heatmap", "coverage", "predictions", "prediction_error", "probe")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+_-]*")


def run(words: list[str]) -> int:
    """Write the card into the run's folder `card`, or elsewhere; returns the exit code.

    Raises UserError where there is no such run, it has no weights, or the folder exists.
    """
    paths, chosen = sorted_out("card", words, CHOICES)
    if not paths:
        raise ConfigError("Name the folder of a run that has learned, as in: curionav card outputs/DATE/RUN")
    refuse_no_name(chosen)
    if stored.is_card(paths[0]):
        raise ConfigError(f"{paths[0]} is a card already. Copy the folder.")
    source, trained = Run(RunFolder.existing(paths[0])), trained_in(paths[0])
    if CHECKPOINT in read_json(source.folder.path / "fixed.json"):
        raise ConfigError(f"{paths[0]} is an evaluation, in which nothing was learned. Name the run that it evaluates "
                          f"first: curionav card RUN {shlex.quote(str(paths[0]))}")
    if not (trained.weights / stored.WEIGHTS).is_file():
        raise ConfigError(f"agent={source.config['agent']['name']} has no weights, so there is nothing to take along.")
    folder = target(chosen, source)
    card, measured = content(source, trained), evaluated(paths[1:], trained)
    pictures = figures(paths[0], paths[1:])
    metrics = {"metrics.jsonl": source.folder.metrics_file} if source.folder.metrics_file.is_file() else {}
    readme = model_card.readme(source, card, chosen.get("licence"), [*pictures], measured)
    folder.parent.mkdir(parents=True, exist_ok=True)
    stored.write_card(folder, card, {"README.md": readme, "config.yaml": settings_yaml(portable(trained.settings))}, {
        stored.WEIGHTS: trained.weights / stored.WEIGHTS, **metrics, **pictures})
    say_where(folder, chosen)
    return 0


def refuse_no_name(chosen: dict[str, str]) -> None:
    """Raises ConfigError for a licence, or a name of a pretrained agent, that cannot be one."""
    for key in ("licence", "pretrained"):
        if key in chosen and not NAME.fullmatch(chosen[key]):
            raise ConfigError(f"{key}={chosen[key]} is no name. Give a word, as in licence=apache-2.0 or "
                              "pretrained=apartments.")
    if "out" in chosen and "pretrained" in chosen:
        raise ConfigError("out=... and pretrained=... name the folder twice. Leave one out.")


def target(chosen: dict[str, str], source: Run) -> Path:
    """The folder to write. Raises ConfigError where it exists."""
    named = stored.cache() / chosen["pretrained"] if "pretrained" in chosen else source.folder.path / "card"
    folder = folder_for(chosen.get("out", named))
    if folder.exists():
        raise ConfigError(f"{folder} exists already. Name another folder with out=DIR, or remove it first.")
    return folder


def content(source: Run, trained: Trained) -> dict[str, Any]:
    """The content of card.json."""
    weights = trained.weights / stored.WEIGHTS
    steps = source.coverage.steps if trained.unit == "episodes" else None
    return {"agent": source.config["agent"]["name"], "env": trained.env, "unit": trained.unit, "done": trained.done,
            "steps": steps, "parameters": stored.parameters(weights), "sha256": stored.sha256(weights),
            "curionav": __version__}


def portable(settings: Config) -> Config:
    """The settings without what belongs to this machine: files keep their names, hosts and other folders go."""
    files: dict[str, Any] = {key: Path(value).name for key in ("map", "overlay", "floor")
                             if (value := getattr(settings.env, key, None))}
    robot = replace(settings.robot, host="localhost") if hasattr(settings.robot, "host") else settings.robot
    return replace(settings, env=replace(settings.env, **files), robot=robot, data=None, storage=None, init=None)


def evaluated(folders: list[Path], trained: Trained) -> list[dict[str, Any]]:
    """Rows of evaluations of these weights. Raises ConfigError for a run that is none."""
    runs = [Run(run) for folder in folders for run in RunFolder.found(folder)]
    for run in runs:
        fixed = read_json(run.folder.path / "fixed.json")
        if fixed.get(CHECKPOINT, {}).get(stored.WEIGHTS) != trained.checksums[stored.WEIGHTS]:
            raise ConfigError(f"{run.folder.path} is no evaluation of these weights. Make one: "
                              f"curionav evaluate {shlex.quote(str(trained.config.parent))}")
    distinguish(runs)
    return [evaluations.row(run) for run in runs]


def figures(run: Path, others: list[Path]) -> dict[str, Path]:
    """The figures to copy, by their names in the card: the run's, then heatmaps of its evaluations."""
    own = {f"figures/{name}.png": run / "figures" / f"{name}.png" for name in FIGURES}
    more = {f"figures/{file_name(folder.name)}_{path.name}": path for folder in others
            for path in sorted((folder / "figures").glob("heatmap*.png"))}
    return {name: path for name, path in {**own, **more}.items() if path.is_file()}


def say_where(folder: Path, chosen: dict[str, str]) -> None:
    """Print the files, and what to type next."""
    console, name = a_console(), shlex.quote(str(folder))
    print_files(console, folder, ["README.md", stored.WEIGHTS, "config.yaml", "metrics.jsonl", "figures"])
    size = (folder / stored.WEIGHTS).stat().st_size / 1e6
    console.print(f"{size:.1f} MB of weights", soft_wrap=True, highlight=False)
    word = f"pretrained={chosen['pretrained']}" if "pretrained" in chosen else name
    init = word if "pretrained" in chosen else f"init={name}"
    print_next(console, [f"curionav evaluate {word} env=apartment_1", f"curionav explore {init} env=apartment_1"])
    if "licence" not in chosen:
        console.print("No licence was chosen: licence=apache-2.0 or another names one.", soft_wrap=True,
                      highlight=False)
