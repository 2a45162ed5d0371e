"""curionav export RUN... --to summary: each run as one small file that comparisons and the paper's figures read."""

from __future__ import annotations

import json
import shlex
import zlib
from pathlib import Path
from typing import Any

from curionav_cli.commands.arguments import sorted_out
from curionav_cli.commands.report_page import MADE_WITH
from curionav_cli.commands.summary import print_files, print_next
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import file_name, folder_for, read_json
from curionav_cli.results.comparison.parallel import jobs_in
from curionav_cli.results.comparison.run_summaries import RunSummary, read
from curionav_cli.results.labels import scene_name
from curionav_cli.results.summary_file import COUNTED, SUFFIX, SummaryFile, is_summary, summarised

CHOICES: dict[str, tuple[str, ...]] = {"to": ("summary",), "out": ()}
DEFAULT = "outputs/summaries"
KEPT = ("question", "began", "resumed", *MADE_WITH)  # of run.json: no command, no folders


def run(words: list[str]) -> int:
    """Write a file for every run; returns the exit code: 1 where a run was left out. Raises UserError."""
    paths, chosen = sorted_out("export", words, CHOICES)
    out = folder_for(chosen.get("out", DEFAULT))
    jobs, lost = jobs_in(paths)
    made: dict[str, Path] = {}
    for job in jobs.values():
        try:
            name = written(job, out)
            if name in made:
                lost.append(f"LEFT OUT: {made[name]} has the settings and seed of {job}, which has as many steps or "
                            f"more and is now in {out / name}")
            made[name] = job
        except RunFolderError as error:
            lost.append(f"LEFT OUT: {error}")
    if not made:
        raise ConfigError("\n".join([*lost, "There is no run to summarise. Name folders of runs or sweeps, as in: "
                                            "curionav export outputs/DATE/SWEEP --to summary"]))
    console = a_console()
    for line in lost:
        console.print(line, soft_wrap=True, highlight=False, markup=False)
    print_files(console, out, list(made))
    print_next(console, [f"curionav compare {shlex.quote(str(out))}"])
    return 1 if lost else 0


def written(job: Path, out: Path) -> str:
    """Write the summary of the run in a folder; returns its name.

    Raises RunFolderError where nothing of it can be read, or where the file there holds more of the run.
    """
    if is_summary(job):
        raise RunFolderError(f"{job} is a summary already: copy the file")
    name = name_of(found := read(job, *COUNTED))
    if (out / name).exists():
        try:
            there = int(SummaryFile.load(out / name).ends[-1])
        except RunFolderError as error:
            raise RunFolderError(f"{error} Or remove it, and export {job} again") from error
        if there > found.steps:
            raise RunFolderError(f"{out / name} holds {there:,} steps of the same run, and {job} has {found.steps:,}. "
                                 "Remove the file to write it anew, or name another folder with out=DIR")
    out.mkdir(parents=True, exist_ok=True)
    summarised(job, provenance(job)).save(out / name)
    return name


def name_of(run: RunSummary) -> str:
    """A name by environment, agent, seed, and a checksum of these and all other settings: the same for the same run."""
    settings = json.dumps([run.arm, run.world, run.seed], sort_keys=True)
    label = f"{scene_name(run.env)} {run.agent} {run.seed} {zlib.crc32(settings.encode()):08x}"
    return f"{file_name(label)}{SUFFIX}"


def provenance(job: Path) -> dict[str, Any]:
    """What run.json says of versions and commits; {} where it cannot be read."""
    try:
        return {key: value for key, value in read_json(job / "run.json").items() if key in KEPT}
    except RunFolderError:
        return {}
