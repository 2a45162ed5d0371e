"""curionav explore: an agent lives in a world; its run folder holds all that came of it."""

from __future__ import annotations

import errno
import hashlib
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.commands.launch import Request, launch
from curionav_cli.commands.progress import report
from curionav_cli.commands.recorder import Recorder
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config, Env
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import RunFailed, RunFolderError
from curionav_cli.loop import LearnHere, live
from curionav_cli.records import FloorPlan, read_json
from curionav_cli.results.coverage import cover
from curionav_cli.storage import checkpoint, provenance
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scene import Scene


def run(request: Request) -> int:
    """The command: its exit code."""
    return launch(request, work, summary, check)


def explore(settings: Config, folder: Path) -> RunFolder:
    """Live the run in `folder` to its end; a folder that holds its beginning is continued.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    settings = replace(settings, env=rooted(settings.env))
    run, world = RunFolder(folder), build.scene(settings)
    with run.alone():
        fixed = fixed_settings(settings, world.plan)
        begun, found = run.config.is_file(), None
        if begun:
            checkpoint.refuse_changes(folder, read_json(run.path / "fixed.json"), fixed)
            found = checkpoint.newest(run.checkpoints, fixed)
        if found and found[0] >= settings.loop.episodes and run.status.get("state") == "done":
            return run
        agent = build.agent(settings, world)
        try:
            if begun:
                go_on(run, agent, found)
                run.write("config.yaml", settings_yaml(settings))  # it may have become longer
            else:
                run.create(settings_yaml(settings), fixed, about(settings, folder, agent), world.plan)
            live_run(settings, run, world, agent, fixed, found[0] if found else 0)
            draw(run)
            run.set_status(state="done")
        except BaseException as error:
            failure = ended(run, error)
            if failure is error:
                raise
            raise failure from error
    return run


def rooted(env: Env) -> Env:
    """Its files by absolute paths: a run is resumed from any folder."""
    def absolute(path: str | None) -> str | None:
        return str(Path(path).expanduser().resolve()) if path else None
    return replace(env, map=absolute(env.map), overlay=absolute(env.overlay))


def live_run(settings: Config, run: RunFolder, world: Scene, agent: Agent, fixed: dict[str, Any], first: int) -> None:
    """From episode `first` to the last."""
    coverage, memory = cover(run.plan, run.poses()), settings.loop.replay_memory * 1e9
    stored = run.episode_paths() if agent.learns else []
    with closing(Replay.open(stored, memory=memory, folder=run.path)) as replay, \
            closing(report(f"{settings.agent.name} seed {settings.seed}", settings.loop, first)) as show:
        recorder = Recorder(run, agent, replay, coverage, fixed, show)
        learn = LearnHere(agent, replay, settings.loop.iterations, recorder, run.save_episode)
        run.set_status(state="running", error=None, episode=first, episodes=settings.loop.episodes, **recorder.counts())
        live(build.env(settings, world), agent, learn, episodes=settings.loop.episodes, steps=settings.loop.steps,
             seed=settings.seed, watch=recorder, first=first)


def go_on(run: RunFolder, agent: Agent, found: tuple[int, Path] | None) -> None:
    """Put the run back to its newest checkpoint."""
    episodes, folder = found or (0, None)
    run.rewind(episodes)
    if folder:
        agent.load(folder)
    print(f"{run.path}: goes on after {episodes} finished episode{'' if episodes == 1 else 's'}", flush=True)


def ended(run: RunFolder, error: BaseException) -> BaseException:
    """Note in status.json how the run ended; the error to raise for it."""
    state, line = "failed", f"{type(error).__name__}: {error}"
    if isinstance(error, KeyboardInterrupt):
        state, line = "interrupted", "interrupted by Ctrl-C"
    elif isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        error = RunFailed(f"The disk is full; what was saved in {run.path} is whole. "
                          f"Free some space, then: curionav resume {run.path}")
        line = str(error)
    with suppress(OSError, RunFolderError):  # on a full disk the status stays what it was
        run.set_status(state=state, error=line)
    return error


def fixed_settings(settings: Config, plan: FloorPlan) -> dict[str, Any]:
    """What a run may not change when it goes on. Files may move: what is in them stands for them."""
    plain = yaml.safe_load(settings_yaml(settings))
    fixed = {key: plain[key] for key in ("env", "agent", "robot", "seed")}
    fixed["env"] = {key: value for key, value in plain["env"].items() if key not in ("map", "overlay")}
    fixed["loop"] = {key: plain["loop"][key] for key in ("steps", "iterations")}
    fixed["visitable cells (sha256)"] = hashlib.sha256(plan.visitable.tobytes()).hexdigest()
    if settings.env.overlay:
        fixed["overlay (sha256)"] = hashlib.sha256(Path(settings.env.overlay).read_bytes()).hexdigest()
    return fixed


def about(settings: Config, folder: Path, agent: Agent) -> dict[str, Any]:
    return provenance.about(folder, str(agent.device), settings.env.engine.value, settings.seed)


def draw(run: RunFolder) -> None:
    """The run's figures and table."""
    from curionav_cli.results import plots, tables  # matplotlib is loaded once there is something to draw
    from curionav_cli.results.runs import Run

    result = Run(run)
    share = f"{result.coverage.share:.1%} of {result.coverage.total} {result.denominator} cells"
    plots.save(plots.heatmap(result.coverage, f"{result.label}\n{share}"), run.figures / "heatmap.png")
    plots.save(plots.curves([result], result.label), run.figures / "coverage.png")
    row = {**result.row(), "state": "done"}
    run.write("table.md", tables.markdown([row]))
    run.write("results.csv", tables.comma_separated([row]))


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """One job, as the launchers call it."""
    return {"coverage": explore(settings, folder).status["coverage"]}  # what a sweeper that searches maximises


def check(settings: Config) -> None:
    """What the schema cannot see: a world that stands, sequences that fit. Raises UserError."""
    build.scene(settings)
    build.check(settings)


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """The last lines of a run or a sweep, also of one that was interrupted."""
    from curionav_cli.commands.summary import show  # matplotlib is loaded once there is something to draw

    show(folder, [outcome.folder for outcome in outcomes])
