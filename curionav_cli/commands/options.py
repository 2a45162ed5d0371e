"""Every argument and option of the command line, as Typer takes them; app.py names the commands that have them."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from curionav_cli.commands.settings_help import Kind, Part

HELP = {"help_option_names": ["-h", "--help"]}
MARKING = "Which cells a step marks: landing, swept or footprint."
DENOMINATOR = "Which cells coverage is a share of: visitable or floor."
OUT = "The folder to write into."


def complete(ctx: typer.Context, incomplete: str) -> list[str]:
    """Completions of a setting; under bash only the piece after '=', which is what bash replaces."""
    from curionav_cli.config.completion import completions, shell_words

    words = [str(word) for word in ctx.params.get("overrides") or ()]
    word, replaced = incomplete, incomplete
    bash = shell_words()
    if bash:
        words, word = bash[0][2:-1], bash[0][-1]
        replaced = bash[1]
    kept = len(word) - len(replaced)
    found = completions(str(ctx.info_name), words, word, ctx.params.get("config_dir"))
    return [whole[kept:] for whole in found]


def option(command: str, key: str, about: str) -> Any:
    """A Typer option --key of commands/<command>.py, completed by the values of its CHOICES."""
    def values(incomplete: str) -> list[str]:
        choices = importlib.import_module(f"curionav_cli.commands.{command}").CHOICES[key]
        return [value for value in choices if value.startswith(incomplete)]
    return typer.Option(f"--{key}", metavar=key.upper(), autocompletion=values, show_default=False, help=about)


def complete_what(ctx: typer.Context, incomplete: str) -> list[str]:
    """The first word of curionav paper; after it, none: the shell's own completion finds the folders of runs."""
    from curionav_cli.commands.paper import WHAT

    return [] if ctx.params.get("words") else [what for what in WHAT if what.startswith(incomplete)]


def complete_group(ctx: typer.Context, incomplete: str) -> list[str]:
    """A group of settings."""
    from curionav_cli.config.completion import group_names

    return group_names(incomplete, ctx.params.get("config_dir"))


def folders(metavar: str, about: str, completed: Callable[..., list[str]] | None = None) -> Any:
    """The folders that a command reads; its options may also stand among them as KEY=VALUE."""
    return typer.Argument(metavar=metavar, autocompletion=completed, show_default=False, help=about)


Overrides = Annotated[list[str] | None, typer.Argument(
    metavar="SETTING=VALUE", autocompletion=complete, show_default=False,
    help="As in env=small_room seed=1; with -m also several values, as in seed=0,1,2.")]
Multirun = Annotated[bool, typer.Option("-m", "--multirun", help="Run every combination of the values.")]
Cfg = Annotated[Part | None, typer.Option("--cfg", help="Print the settings instead of running.")]
Resolve = Annotated[bool, typer.Option("--resolve", help="With --cfg: resolve interpolations.")]
Package = Annotated[str | None, typer.Option("-p", "--package", help="With --cfg: only this part, such as agent.")]
Info = Annotated[Kind | None, typer.Option("--info", help="Print where the settings come from.")]
ConfigDir = Annotated[Path | None, typer.Option(
    "-cd", "--config-dir", help="Your own directory with env/, agent/ ...; or set CURIONAV_CONFIG_PATH.")]

RunFolders = Annotated[list[str] | None, folders("DIR", "Folders to look through; without any, outputs.")]
State = Annotated[str | None, option("runs", "state", "Only running, done, failed, interrupted or broken runs.")]
Env = Annotated[str | None, option("runs", "env", "Only runs in this environment.")]
AgentName = Annotated[str | None, option("runs", "agent", "Only runs of this agent.")]
Seed = Annotated[str | None, option("runs", "seed", "Only runs with this seed.")]
Sort = Annotated[str | None, option("runs", "sort", "By age, coverage, size, state, env, agent, seed or run.")]

WatchedFolder = Annotated[Path, typer.Argument(metavar="RUN", show_default=False, help="A run or a sweep.")]
Port = Annotated[int, typer.Option("--port", min=0, max=65535, help="Of the page; 0: one that is free.")]

CoverageFolders = Annotated[list[str] | None, folders("RUN", "Folders of runs or sweeps.")]
CoverageMarking = Annotated[str | None, option("coverage", "marking", f"{MARKING} Default: all.")]
CoverageDenominator = Annotated[str | None, option("coverage", "denominator", f"{DENOMINATOR} Default: both.")]
Episodes = Annotated[str | None, option("coverage", "episodes", "Draw the paths of these episodes: 0,5,last.")]
Film = Annotated[str | None, option("coverage", "film", "Make a .webm film of these episodes: 0,last.")]
CoverageOut = Annotated[str | None, option(
    "coverage", "out", f"{OUT} The runs of an environment are then also drawn side by side.")]

CompareFolders = Annotated[list[str] | None, folders("RUN", "Folders of runs or sweeps.")]
Baseline = Annotated[str | None, option(
    "compare", "baseline", "The arm to compare all others with, by its label, such as random.")]
At = Annotated[str | None, option("compare", "at", "Also show coverage after so many steps: 1000,5000.")]
CompareMarking = Annotated[str | None, option("compare", "marking", f"{MARKING} Default: landing.")]
CompareDenominator = Annotated[str | None, option("compare", "denominator", f"{DENOMINATOR} Default: visitable.")]
CompareOut = Annotated[str | None, option("compare", "out", OUT)]

CardFolders = Annotated[list[str] | None, folders(
    "RUN [EVALUATION]", "The folder of a run that has learned, then those of its evaluations.")]
CardOut = Annotated[str | None, option("card", "out", f"{OUT} Default: card in the run's.")]
Licence = Annotated[str | None, option("card", "licence", "Of the weights, such as apache-2.0.")]
Pretrained = Annotated[str | None, option(
    "card", "pretrained", "Write into the user's cache, where evaluate pretrained=NAME finds it.")]

MapFolder = Annotated[list[str] | None, folders("RUN", "The folder of one run, of agent=mapper or a docking robot.")]
MapOut = Annotated[str | None, option("map", "out", f"{OUT} Default: the run's.")]

ExportWords = Annotated[list[str] | None, folders(
    "RUN | SETTING=VALUE", "mcap, summary: folders of runs or sweeps; glb: the world, as in env=apartment_0, and "
    "its settings.")]
ExportTo = Annotated[str | None, option("export", "to", "The format: mcap, summary or glb.")]
ExportOut = Annotated[str | None, option(
    "export", "out", "mcap: the folder to write into, default: bags in each run's; summary: the same, default: outputs/"
    "summaries; glb: the file, default: NAME.glb.")]
ExportEpisodes = Annotated[str | None, option("export", "episodes", "Only these episodes: 0,5,last. Default: all.")]
ExportImages = Annotated[str | None, option(
    "export", "images", "png: CompressedImage, without loss (the default); raw: Image.")]
ExportDepth = Annotated[str | None, option(
    "export", "depth", "yes (the default): depth of simulated worlds, drawn again; no.")]
ExportProfile = Annotated[str | None, option(
    "export", "profile", "The robot whose topics are used: turtlebot2i, turtlebot3 or turtlebot4 (the default).")]
ExportEpisode = Annotated[str | None, option(
    "export", "episode", "glb: the episode in which what moves stands as written. Default: 0.")]
ExportRate = Annotated[str | None, option("export", "rate", "Steps a second, from 0.1 to 1000. Default: 10.")]

PaperWords = Annotated[list[str] | None, folders(
    "WHAT [RUN]", "hyperparameters: the paper's and ours; sizes: of the scenes; docking: the diagram of the docking "
    "server; of these runs: numbers: every number of the paper beside ours; figures: coverage at the paper's axes; "
    "changes: what moved objects do to surprise and coverage.", complete_what)]
PaperOut = Annotated[str | None, option("paper", "out", f"{OUT} Default: the current one.")]
PaperPage = Annotated[str | None, option(
    "paper", "page", "figures, changes: Markdown pages, comma-separated, whose blocks get the tables and pictures.")]
PaperKeep = Annotated[str | None, option(
    "paper", "keep", "figures: yes: what stands in out of other worlds than those of the runs stays. Default: no.")]

Profile = Annotated[str, typer.Argument(metavar="PROFILE", help="turtlebot2i, turtlebot3, turtlebot4, or your own.")]
RobotWords = Annotated[list[str] | None, typer.Argument(
    metavar="SETTING=VALUE", show_default=False, help="As in robot.host=192.168.1.20 robot.namespace=robot1.")]
Move = Annotated[bool, typer.Option("--move", help="Also turn 10 degrees to both sides and drive 0.25 m ahead.")]

NewFolder = Annotated[Path, typer.Argument(metavar="DIR", help="The directory to make or to add to.")]
Group = Annotated[str | None, typer.Argument(
    metavar="GROUP", autocompletion=complete_group, show_default=False,
    help="One of agent, env, experiment, launcher, robot, scale.")]
BegunFolder = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a run or a sweep.")]
Changes = Annotated[list[str] | None, typer.Argument(
    metavar="SETTING=VALUE", show_default=False,
    help="To make it longer: loop.episodes, loop.iterations or dock.requests; of a search hydra.sweeper.n_trials. "
         "Also where files and storage are, logger, compile, loop.replay_memory.")]
Failed = Annotated[bool, typer.Option("--failed", help="Of a sweep: also run again what failed.")]
ServedWords = Annotated[list[str] | None, typer.Argument(
    metavar="SETTING=VALUE", show_default=False,
    help="Of the world, as in env=large_lab robot=turtlebot2i, and of topics and server: robot.profile=turtlebot4 "
         "robot.host=... robot.port=... robot.namespace=...")]
Speed = Annotated[float, typer.Option("--speed", min=0.01, max=100, help="Simulated seconds a second.")]
Images = Annotated[float, typer.Option("--images", min=0.1, max=50, help="Images a simulated second.")]
Robots = Annotated[list[str] | None, typer.Option(
    "--robot", metavar="NAME", show_default=False, help="A robot in a namespace; may be given several times.")]
Exact = Annotated[bool, typer.Option("--exact", help="Motion and sensors without errors.")]
