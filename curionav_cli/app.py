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
from typing import Annotated, Any

import typer

from curionav_cli import __version__
from curionav_cli.commands import options as opt
from curionav_cli.commands.settings_help import SettingsCommand
from curionav_cli.errors import RunFailed, Terminated, Unread, UserError

app = typer.Typer(
    name="curionav",
    help="A robot learns to navigate from scratch with a world model and curiosity.",
    context_settings=opt.HELP,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


def show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"curionav {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True,
                                          help="Print the version.")] = False,
) -> None:
    """Options before the command."""


def command_with_settings(name: str, about: str) -> None:
    """Register a command whose arguments are settings; commands/<name>.py runs it."""
    @app.command(name, help=about, cls=SettingsCommand, context_settings={**opt.HELP, "ignore_unknown_options": True})
    def command(
        overrides: opt.Overrides = None, multirun: opt.Multirun = False, cfg: opt.Cfg = None,
        resolve: opt.Resolve = False, package: opt.Package = None, info: opt.Info = None,
        config_dir: opt.ConfigDir = None,
    ) -> None:
        from curionav_cli.execution.launch import Request

        module = importlib.import_module(f"curionav_cli.commands.{name}")
        raise typer.Exit(module.run(
            Request(name, overrides or [], multirun, cfg, package, resolve, info, (config_dir,) if config_dir else ())))


command_with_settings("explore", "Run an agent, store its episodes and draw its coverage.")
command_with_settings("train", "Train an agent offline on stored episodes: data=RUN loop.iterations=2000; "
                               "or as the learner of a remote robot: storage=URL --follow.")
command_with_settings("evaluate", "Run a trained agent, which does not learn, in the same or another world: "
                                  "curionav evaluate RUN env=apartment_1.")
command_with_settings("dock", "Test the return to dock: explore for an episode, drive home and dock, dock.requests "
                              "times.")
command_with_settings("sheet", "Draw a world: floor plan, view from above, camera images and depth.")


def command_with_words(name: str, words: list[str] | None, **options: str | None) -> None:
    """Run commands/<name>.py; options that were given follow the words as KEY=VALUE."""
    given = [f"{key}={value}" for key, value in options.items() if value is not None]
    raise typer.Exit(importlib.import_module(f"curionav_cli.commands.{name}").run([*(words or []), *given]))


@app.command()
def runs(words: opt.RunFolders = None, state: opt.State = None, env: opt.Env = None, agent: opt.AgentName = None,
         seed: opt.Seed = None, sort: opt.Sort = None) -> None:
    """List runs with their state, coverage, age and size."""
    command_with_words("runs", words, state=state, env=env, agent=agent, seed=seed, sort=sort)


@app.command()
def doctor() -> None:
    """Check packages, devices, launchers and folders, and that a small run repeats to the byte."""
    from curionav_cli.commands import doctor

    raise typer.Exit(doctor.run())


@app.command()
def init(folder: opt.NewFolder) -> None:
    """Make a config directory of your own, with an environment, an agent and an experiment to edit."""
    from curionav_cli.commands import init

    raise typer.Exit(init.run(folder))


@app.command("list")
def list_options(group: opt.Group = None, config_dir: opt.ConfigDir = None) -> None:
    """List the groups of settings, or the options of one: curionav list env."""
    from curionav_cli.commands import listing

    raise typer.Exit(listing.run(group, config_dir))


@app.command()
def resume(folder: opt.BegunFolder, changes: opt.Changes = None, failed: opt.Failed = False) -> None:
    """Continue an interrupted run, or every run of a sweep that was interrupted or never began."""
    from curionav_cli.commands import resume

    raise typer.Exit(resume.run(folder, changes or [], failed))


@app.command()
def watch(folder: opt.WatchedFolder, port: opt.Port = 8787) -> None:
    """Show a run or a sweep as it goes on, on a page of this machine: heatmap, curves, camera, state, time left."""
    from curionav_cli.commands import watch

    raise typer.Exit(watch.run(folder, port))


@app.command()
def coverage(words: opt.CoverageFolders = None, marking: opt.CoverageMarking = None,
             denominator: opt.CoverageDenominator = None, episodes: opt.Episodes = None, film: opt.Film = None,
             out: opt.CoverageOut = None) -> None:
    """Recompute the coverage of runs by every cell-marking rule and draw it; also paths, films and predictions."""
    command_with_words("coverage", words, marking=marking, denominator=denominator, episodes=episodes, film=film,
                       out=out)


@app.command()
def compare(words: opt.CompareFolders = None, baseline: opt.Baseline = None, at: opt.At = None,
            marking: opt.CompareMarking = None, denominator: opt.CompareDenominator = None,
            out: opt.CompareOut = None) -> None:
    """Compare agents over seeds and environments: figures and tables with intervals, and one HTML page."""
    command_with_words("compare", words, baseline=baseline, at=at, marking=marking, denominator=denominator, out=out)


@app.command()
def card(words: opt.CardFolders = None, out: opt.CardOut = None, licence: opt.Licence = None,
         pretrained: opt.Pretrained = None) -> None:
    """Write a trained agent as a folder to take along: weights, settings, metrics, figures and a README."""
    command_with_words("card", words, out=out, licence=licence, pretrained=pretrained)


@app.command("map")
def write_map(words: opt.MapFolder = None, out: opt.MapOut = None) -> None:
    """Write the map that a run's robot made as a ROS map (PGM and YAML), which env=map and Nav2 open."""
    command_with_words("map", words, out=out)


@app.command()
def export(words: opt.ExportWords = None, to: opt.ExportTo = None, out: opt.ExportOut = None,
           episodes: opt.ExportEpisodes = None, images: opt.ExportImages = None, depth: opt.ExportDepth = None,
           profile: opt.ExportProfile = None, rate: opt.ExportRate = None, episode: opt.ExportEpisode = None) -> None:
    """Write episodes of runs as ROS 2 bags (--to mcap), what runs covered as small files that compare reads in their
    place (--to summary), or a world as a mesh for Blender and env=scan (--to glb)."""
    command_with_words("export", words, to=to, out=out, episodes=episodes, images=images, depth=depth, profile=profile,
                       rate=rate, episode=episode)


@app.command()
def paper(words: opt.PaperWords = None, out: opt.PaperOut = None, page: opt.PaperPage = None,
          keep: opt.PaperKeep = None) -> None:
    """Write the paper's tables, and each of its numbers beside ours."""
    command_with_words("paper", words, out=out, page=page, keep=keep)


robot = typer.Typer(help="A real robot: see whether it can be driven.", no_args_is_help=True, context_settings=opt.HELP)
app.add_typer(robot, name="robot")


@robot.command("check")
def robot_check(profile: opt.Profile, words: opt.RobotWords = None, move: opt.Move = False) -> None:
    """Connect to a real robot, list what it offers and what to mend: curionav robot check turtlebot4 robot.host=..."""
    from curionav_cli.commands import robot as command

    raise typer.Exit(command.check(profile, words or [], move))


@app.command()
def serve(words: opt.ServedWords = None, speed: opt.Speed = 1.0, images: opt.Images = 10.0, robots: opt.Robots = None,
          exact: opt.Exact = False) -> None:
    """A simulated world as a robot for others, over rosbridge: curionav serve env=small_room robot=turtlebot2i."""
    from curionav_cli.commands import serve as command
    from curionav_cli.live.served.settings import Serving

    raise typer.Exit(command.run(words or [], Serving(speed, images, exact=exact), robots or []))


def unwritable(error: OSError) -> str:
    """Return one line for a disk that is full or locked; raise any other error again."""
    from curionav_cli.execution.interrupts import FULL, LOCKED

    if error.errno not in (*FULL, *LOCKED):
        raise error
    return f"{error.filename or 'A file'} cannot be written ({error.strerror}). Free some space or make it writable."


def main(arguments: list[str] | None = None) -> Any:
    """Run the command line and exit: 0 done, 1 the run failed, 2 wrong use or config, 130 interrupted, 141 its output
    was closed, 143 stopped by SIGTERM."""
    for name, value in (("OMP_WAIT_POLICY", "PASSIVE"), ("OMP_NUM_THREADS", "1")):
        os.environ.setdefault(name, value)  # one thread a run: spinning threads made runs up to 33 times slower
    os.environ["MPLBACKEND"] = "agg"  # a notebook sets one that is not installed here, and matplotlib fails to load
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by the caller, as `>&-` does
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w"))
    logging.raiseExceptions = False  # a closed pipe is not reported
    atexit.register(gc.freeze)  # torch leaves a million objects: collecting them at exit takes a second
    warnings.formatwarning = lambda message, *where, **more: f"warning: {message}\n"
    try:
        try:
            app(arguments)
        except SystemExit as end:
            if isinstance(end.__context__, BrokenPipeError):  # for rich and click the exit code 1
                raise Unread from end
            raise
        finally:
            sys.stdout.flush()  # here, where a closed pipe is still caught
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
