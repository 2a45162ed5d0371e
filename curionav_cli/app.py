"""The command line: registration only. Whatever is heavy is imported by the command that needs it."""

from __future__ import annotations

import atexit
import gc
import importlib
import logging
import os
import sys
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from curionav_cli import __version__
from curionav_cli.commands.settings_help import Kind, Part, SettingsCommand
from curionav_cli.errors import RunFailed, Terminated, Unread, UserError

SETTINGS = {"help_option_names": ["-h", "--help"], "ignore_unknown_options": True}


app = typer.Typer(
    name="curionav",
    help="A robot learns to navigate from scratch with a world model and curiosity.",
    context_settings={"help_option_names": ["-h", "--help"]},
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def complete(ctx: typer.Context, incomplete: str) -> list[str]:
    """Completion of settings; under bash only the piece after '=' is answered, as bash replaces that."""
    from curionav_cli.config.completion import completions, shell_words

    words = [str(word) for word in ctx.params.get("overrides") or ()]
    word, replaced = incomplete, incomplete
    bash = shell_words()
    if bash:
        words, word = [word for word in bash[0][2:-1] if "=" in word], bash[0][-1]
        replaced = bash[1]
    kept = len(word) - len(replaced)
    found = completions(str(ctx.info_name), words, word, ctx.params.get("config_dir"))
    return [whole[kept:] for whole in found]


Overrides = Annotated[list[str] | None, typer.Argument(
    metavar="[SETTING=VALUE]...", autocompletion=complete, show_default=False,
    help="env=small_room agent=random seed=1 loop.episodes=50; with -m also seed=0,1,2")]
Multirun = Annotated[bool, typer.Option("-m", "--multirun", help="Run every combination of listed values.")]
Cfg = Annotated[Part | None, typer.Option("--cfg", help="Print the settings instead of running.")]
Resolve = Annotated[bool, typer.Option("--resolve", help="With --cfg: with interpolations resolved.")]
Package = Annotated[str | None, typer.Option("-p", "--package", help="With --cfg: only this part, as agent.")]
Info = Annotated[Kind | None, typer.Option("--info", help="Print how the settings came about.")]
ConfigDir = Annotated[Path | None, typer.Option(
    "-cd", "--config-dir", help="A directory with env/, agent/ ... of your own; also CURIONAV_CONFIG_PATH.")]


def show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"curionav {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True,
                                          help="Print the version.")] = False,
) -> None:
    """What stands before the subcommand."""


def command_with_settings(name: str, about: str) -> None:
    """Register a command whose arguments are settings; commands/<name>.py runs it."""
    @app.command(name, help=about, cls=SettingsCommand, context_settings=SETTINGS)
    def command(
        overrides: Overrides = None, multirun: Multirun = False, cfg: Cfg = None, resolve: Resolve = False,
        package: Package = None, info: Info = None, config_dir: ConfigDir = None,
    ) -> None:
        from curionav_cli.execution.launch import Request

        module = importlib.import_module(f"curionav_cli.commands.{name}")
        raise typer.Exit(module.run(
            Request(name, overrides or [], multirun, cfg, package, resolve, info, (config_dir,) if config_dir else ())))


command_with_settings("explore", "Let an agent live in a world and draw what it covered.")
command_with_settings("train", "Let an agent learn from stored episodes: data=RUN loop.iterations=2000 (all together); "
                      "or for a robot: storage=URL, with --follow on and on.")
command_with_settings("dock", "Explore, drive home and dock, again and again: env=small_room dock.requests=600.")
command_with_settings("sheet", "Draw a contact sheet of a world: top view, camera images and depth.")


def option(command: str, key: str, about: str) -> Any:
    """A Typer option --key of a command; the values that the command allows for it are completed by the shell."""
    def values(incomplete: str) -> list[str]:
        choices = importlib.import_module(f"curionav_cli.commands.{command}").CHOICES[key]
        return [value for value in choices if value.startswith(incomplete)]
    return typer.Option(f"--{key}", metavar="", autocompletion=values, show_default=False, help=about)


def folders(metavar: str, about: str) -> Any:
    """The positional words of a command that reads folders; its options may also stand among them as KEY=VALUE."""
    return typer.Argument(metavar=f"{metavar} [KEY=VALUE]...", show_default=False, help=about)


def command_with_words(name: str, words: list[str] | None, **options: str | None) -> None:
    """Run commands/<name>.py; options that were given follow the words as KEY=VALUE."""
    given = [f"{key}={value}" for key, value in options.items() if value is not None]
    raise typer.Exit(importlib.import_module(f"curionav_cli.commands.{name}").run([*(words or []), *given]))


Text = str | None
MARKING = "Which cells a step marks: landing, swept or footprint."
DENOMINATOR = "What coverage is a share of: visitable or floor."
OUT = "The folder to write into."


@app.command()
def runs(
    words: Annotated[list[str] | None, folders("[DIR]...", "Folders to look through; without any, outputs.")] = None,
    state: Annotated[Text, option("runs", "state", "Only running, done, failed, interrupted or broken ones.")] = None,
    env: Annotated[Text, option("runs", "env", "Only runs in this environment.")] = None,
    agent: Annotated[Text, option("runs", "agent", "Only runs of this agent.")] = None,
    seed: Annotated[Text, option("runs", "seed", "Only runs with this seed.")] = None,
    sort: Annotated[Text, option("runs", "sort", "By age, coverage, size, state, env, agent, seed or run.")] = None,
) -> None:
    """List runs with their state, coverage, age and size."""
    command_with_words("runs", words, state=state, env=env, agent=agent, seed=seed, sort=sort)


@app.command()
def doctor() -> None:
    """Say what is installed, where one can compute, launch and write, and whether a small run repeats itself."""
    from curionav_cli.commands import doctor

    raise typer.Exit(doctor.run())


@app.command()
def init(folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder to make, or to add to.")]) -> None:
    """Make a config directory of your own, with an environment, an agent and an experiment to edit."""
    from curionav_cli.commands import init

    raise typer.Exit(init.run(folder))


@app.command("list")
def list_options(
    group: Annotated[str | None, typer.Argument(
        metavar="[GROUP]", show_default=False, help="env, agent, robot, scale, launcher")] = None,
    config_dir: ConfigDir = None,
) -> None:
    """List what can be chosen: the groups, or the options of one, as in curionav list env."""
    from curionav_cli.commands import listing

    raise typer.Exit(listing.run(group, config_dir))


@app.command()
def resume(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a run or a sweep.")],
    changes: Annotated[list[str] | None, typer.Argument(
        metavar="[SETTING=VALUE]...", show_default=False,
        help="What may change: loop.episodes, loop.iterations or dock.requests, of a search hydra.sweeper.n_trials, to "
             "make it longer than was planned; where files and storage are; logger, compile, "
             "loop.replay_memory.")] = None,
    failed: Annotated[bool, typer.Option("--failed", help="Of a sweep: run what failed again, too.")] = False,
) -> None:
    """Go on with an interrupted run, or with every run of a sweep that was interrupted or never began."""
    from curionav_cli.commands import resume

    raise typer.Exit(resume.run(folder, changes or [], failed))


@app.command()
def coverage(
    words: Annotated[list[str] | None, folders("RUN...", "Folders of runs or sweeps.")] = None,
    marking: Annotated[Text, option("coverage", "marking", f"{MARKING} Without it, all.")] = None,
    denominator: Annotated[Text, option("coverage", "denominator", f"{DENOMINATOR} Without it, both.")] = None,
    episodes: Annotated[Text, option("coverage", "episodes", "Whose paths are drawn, as in 0,5,last.")] = None,
    film: Annotated[Text, option("coverage", "film", "Which episodes become a .webm film, as in 0,last.")] = None,
    out: Annotated[Text, option("coverage", "out", f"{OUT} There the runs of an environment are drawn side by side, "
                                                   "too.")] = None,
) -> None:
    """Count the coverage of runs again, by any marking rule and denominator, and draw it; films, predictions."""
    command_with_words("coverage", words, marking=marking, denominator=denominator, episodes=episodes, film=film,
                       out=out)


@app.command()
def compare(
    words: Annotated[list[str] | None, folders("RUNS_OR_SWEEP...", "Folders of runs or sweeps.")] = None,
    baseline: Annotated[Text, option("compare", "baseline", "The arm that all others are compared with, as its label "
                                                            "reads.")] = None,
    at: Annotated[Text, option("compare", "at", "Coverage after so many steps, too, as in 1000,5000.")] = None,
    marking: Annotated[Text, option("compare", "marking", MARKING)] = None,
    denominator: Annotated[Text, option("compare", "denominator", DENOMINATOR)] = None,
    out: Annotated[Text, option("compare", "out", OUT)] = None,
) -> None:
    """Compare agents over seeds and environments: figures and tables, with intervals."""
    command_with_words("compare", words, baseline=baseline, at=at, marking=marking, denominator=denominator, out=out)


@app.command()
def paper(
    words: Annotated[list[str] | None, folders(
        "WHAT [RUNS_OR_SWEEP...]", "hyperparameters: the paper's table beside what is composed; sizes: of the scenes; "
        "docking: the phases of the docking server; numbers: every number of the paper beside ours, from these "
        "runs.")] = None,
    out: Annotated[Text, option("paper", "out", f"{OUT} Without it, this one.")] = None,
) -> None:
    """Write the paper's tables, and its numbers beside ours."""
    command_with_words("paper", words, out=out)


def unwritable(error: OSError) -> str:
    """One line for a disk that is full or locked, wherever a command met it; any other error is raised again."""
    from curionav_cli.execution.interrupts import FULL, LOCKED

    if error.errno not in (*FULL, *LOCKED):
        raise error
    return f"{error.filename or 'A file'} cannot be written ({error.strerror})."


def main(arguments: list[str] | None = None) -> Any:
    """Exit codes: 0 done, 1 the run failed, 2 wrong use or config, 130 interrupted, 141 its output was closed,
    143 stopped by SIGTERM."""
    for name, value in (("OMP_WAIT_POLICY", "PASSIVE"), ("OMP_NUM_THREADS", "1")):
        os.environ.setdefault(name, value)  # one thread a run: spinning threads cost up to 33 times
    os.environ["MPLBACKEND"] = "agg"  # a notebook leaves one that is not installed here, and matplotlib does not load
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by who began it, as `>&-` does
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w"))
    logging.raiseExceptions = False  # of a closed pipe no word
    atexit.register(gc.freeze)  # torch leaves a million objects: to look through them at the end takes a second
    warnings.formatwarning = lambda message, *where, **more: f"warning: {message}\n"
    try:
        try:
            app(arguments)
        except SystemExit as end:
            if isinstance(end.__context__, BrokenPipeError):  # for rich and click the exit code 1
                raise Unread from end
            raise
        finally:
            sys.stdout.flush()  # while a closed pipe can still be answered
    except (Unread, BrokenPipeError):
        from curionav_cli.execution.screen import mute

        mute()
        code, message = 141, ""  # a shell's code for SIGPIPE
    except UserError as error:
        code, message = 2, str(error)
    except RunFailed as error:
        code, message = 1, str(error)
    except Terminated as error:
        code, message = 143, str(error)
    except OSError as error:
        code, message = 1, unwritable(error)
    with suppress(BrokenPipeError):
        print(message, end="\n" * bool(message), file=sys.stderr)
    sys.exit(code)
