"""Runs of the paper's lengths: which of them are the paper's agent, how far they came, what they covered and cost."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from curionav_cli.errors import RunFolderError
from curionav_cli.files import disk, read_json
from curionav_cli.results.comparison.comparison import TWICE, Comparison, measures
from curionav_cli.results.comparison.parallel import read_all
from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.labels import scene_name
from curionav_cli.results.summary_file import SummaryFile, is_summary, opened, spent_by_end
from curionav_cli.results.tables import Columns, Row, percent
from curionav_cli.storage.run_folder import RunFolder

APARTMENTS = ("apartment_0", "apartment_1", "apartment_2")
UNTIL = {**dict.fromkeys(APARTMENTS, 5_000_000), "small_room": 280_000, "large_lab": 600_000}  # the paper's axes
OURS, OURS_BY, OURS_UNTIL = "lbs_dreamer", "lbs", 2_000_000  # in the apartments
COUNTS = (10_000, 30_000, 100_000, 200_000, 400_000, 600_000, 1_000_000, 2_000_000)  # steps that are reported

RUN_COLUMNS: Columns = (
    ("env", "env", "{}"), ("arm", "arm", "{}"), ("seed", "seed", "{}"), ("commit", "commit", "{}"),
    ("steps", "steps", "{:,}"), ("the paper's", "planned", "{:,}"), ("CPU-hours", "hours", "{:.2f}"),
    ("memory, GB", "memory", "{:.2f}"), ("disk, GB", "disk", "{:.3f}"), ("state", "state", "{}"),
    ("error", "error", "{}"), ("folder", "folder", "{}"))
ARM_COLUMNS: Columns = (
    ("env", "env", "{}"), ("arm", "arm", "{}"), ("n", "n", "{}"),
    *((f"{count:,}", f"coverage_at_{count}", "{}") for count in COUNTS))
COVERAGE_COLUMNS: Columns = (
    ("env", "env", "{}"), ("arm", "arm", "{}"), ("seed", "seed", "{}"),
    *((f"{count:,}", f"coverage_at_{count}", "{:.1%}") for count in COUNTS), ("steps", "steps", "{:,}"),
    ("at its end", "coverage", "{:.1%}"), ("area under the curve", "area_under_curve", "{:.3f}"))


class Drawn(NamedTuple):
    """A run in figures and tables: the names of its environment and arm, and the scene's."""

    env: str
    arm: str
    scene: str
    run: RunSummary

    @property
    def ours(self) -> bool:
        """Whether it is the paper's agent in the paper's world: by surprise, with what changes there."""
        by = self.run.arm.get("agent.curiosity", OURS_BY)
        return (self.run.agent, by) == (OURS, OURS_BY) and bool(self.run.env.get("changes", True))

    @property
    def planned(self) -> int | None:
        """Steps after which the paper's curve of this agent ends; None where it has none."""
        ours = self.scene in APARTMENTS and not self.run.agent.startswith("cbet")
        return OURS_UNTIL if ours else UNTIL.get(self.scene)


def read_learning(folders: Sequence[Path]) -> tuple[list[RunSummary], list[str]]:
    """Every run in these folders, and a line about each that cannot be read or evaluates an agent that was trained
    elsewhere: the paper's curves are of agents that learn."""
    runs, lost = read_all(folders, "landing", "visitable")
    lost += [f"LEFT OUT: {run.folder} evaluates a trained agent; the paper's curves are of agents that learn."
             for run in runs if run.evaluates]
    return [run for run in runs if not run.evaluates], lost


def named(comparison: Comparison) -> list[Drawn]:
    """Every run with its names, by environment and arm in their order of appearance, and by seed."""
    envs, arms = (list(dict.fromkeys(names)) for names in zip(*comparison.names.values()))
    found = sorted(comparison.names.items(),
                   key=lambda one: (envs.index(one[1][0]), arms.index(one[1][1]), str(one[0].seed)))
    return [Drawn(env, arm, scene_name(run.env), run) for run, (env, arm) in found]


def drawn(comparison: Comparison) -> list[Drawn]:
    """Every run once, the longest of those with the same arm, environment and seed."""
    return [one for one in named(comparison) if TWICE not in comparison.left_out.get(one.run, "")]


def rows(runs: Sequence[Drawn]) -> list[Row]:
    """A row for each run: how far it came of the paper's steps, by which commits, and what it cost."""
    return [{"env": one.env, "arm": one.arm, "seed": one.run.seed, "steps": one.run.steps, "planned": one.planned,
             **cost(one.run.folder), "error": one.run.error or None, **about(one.run.folder)} for one in runs]


def begun_only(folders: Sequence[Path]) -> list[Row]:
    """A row for each of these folders whose run ended before its first episode did; none for one that holds no run."""
    found: list[Row] = []
    for folder in folders:
        try:
            settings, status = RunFolder(folder).settings, RunFolder(folder).status
            if status.get("state") == "done":  # a training, or a test of docking
                continue
            found.append({"env": scene_name(settings["env"]), "arm": settings["agent"]["name"],
                          "seed": settings["seed"], "steps": 0, "error": status.get("error"), **about(folder)})
        except RunFolderError:
            continue
    return found


def cost(folder: Path) -> dict[str, float | None]:
    """CPU-hours of acting and learning, and the peak of memory in GB; None where they were not noted."""
    noted = SummaryFile.load(folder).spent if is_summary(folder) else spent_by_end(RunFolder(folder))
    seconds = noted.get("cpu_seconds")
    return {"hours": None if seconds is None else seconds / 3600, "memory": noted.get("memory")}


def about(folder: Path) -> dict[str, Any]:
    """State, commits, disk and place of the run in a folder, or of a summary file."""
    if is_summary(folder):
        file = SummaryFile.load(folder)
        commit, size = commits(file.about), file.disk
    else:
        commit, size = noted_commits(folder / "run.json"), disk(folder)
    return {"state": opened(folder).state, "commit": commit, "disk": size / 1e9, "folder": str(folder)}


def noted_commits(path: Path) -> str | None:
    """The commits that run.json notes; "unreadable" where it is broken, None where there is none."""
    try:
        return commits(read_json(path)) if path.is_file() else None
    except RunFolderError:
        return "unreadable"


def commits(provenance: dict[str, Any]) -> str | None:
    """The commit that began a run, and every other that went on with it and from where; None where none was noted."""
    last = first = provenance.get("git_commit")
    words = []
    for line in provenance.get("resumed", ()):
        if line["git_commit"] != last:
            last = line["git_commit"]
            words.append(f"{brief(last)} from episode {line.get('episode', '?')}")
    return ", ".join([brief(first), *words]) if first or words else None


def brief(commit: str | None) -> str:
    return commit[:7] if commit else "unknown"


def coverages(runs: Sequence[Drawn]) -> list[Row]:
    """A row for each run: coverage at the reported steps that it reached and at its end, and the area until there."""
    return [{"env": one.env, "arm": one.arm, "seed": one.run.seed, "steps": one.run.steps,
             **{key: value for key, value in measures(one.run, one.run.steps, COUNTS).items() if "steps" not in key}}
            for one in runs]


def arm_coverages(runs: Sequence[Drawn]) -> list[Row]:
    """A row for each arm in each environment: mean and range of its runs' coverage at the reported steps."""
    found: dict[tuple[str, str], list[RunSummary]] = {}
    for one in runs:
        found.setdefault((one.env, one.arm), []).append(one.run)
    return [{"env": env, "arm": arm, "n": len(same),
             **{f"coverage_at_{count}": words for count in COUNTS if (words := mean_and_range(same, count))}}
            for (env, arm), same in found.items()]


def mean_and_range(runs: Sequence[RunSummary], steps: int) -> str:
    """Coverage after so many steps of the runs that reached them, as '39.6% (39.3% to 39.9%)'; empty without one."""
    each = [int(run.curve.at(steps)) / run.curve.cells for run in runs if run.steps >= steps]
    if not each:
        return ""
    spread = f" ({percent(min(each))} to {percent(max(each))})" if len(each) > 1 else ""
    return f"{percent(sum(each) / len(each))}{spread}{f', n = {len(each)}' if len(each) < len(runs) else ''}"
