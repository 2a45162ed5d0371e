"""sbatch, srun, sacct and scancel for tests on machines without Slurm: each by the name that it is called by.

The tasks of an array run one after the other on this machine. Each waits for a file in the folder that STANDIN_SLURM
names: the first for `begin`, the others for `free`.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PROGRAMS = ("sbatch", "srun", "sacct", "scancel")
JOB = "1000"


@contextmanager
def standin(folder: Path) -> Iterator[dict[str, str]]:
    """Put the programs into a folder; the environment in which they are found. Ends what still waits there."""
    folder.mkdir()
    for name in PROGRAMS:
        program = folder / name
        program.write_text(f"#!/bin/sh\nexec {sys.executable} {__file__} {name} \"$@\"\n")
        program.chmod(0o755)
    try:
        yield {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "STANDIN_SLURM": str(folder)}
    finally:
        (folder / "over").touch()


def sbatch(folder: Path, script: str) -> None:
    """Begin an array in a process of its own."""
    subprocess.Popen([sys.executable, __file__, "work", script], stdin=subprocess.DEVNULL, start_new_session=True,
                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    print(f"Submitted batch job {JOB}")


def work(folder: Path, script: str) -> None:
    """Run the tasks of a script's array."""
    last = int(re.findall(r"^#SBATCH --array=0-(\d+)", Path(script).read_text(), re.MULTILINE)[0])
    for task in range(last + 1):
        while not (folder / ("free" if task else "begin")).exists():
            if (folder / "over").exists():
                return
            time.sleep(0.1)
        (folder / f"{task}.state").write_text("RUNNING")
        about = {"SLURM_JOB_ID": f"{int(JOB) + task}", "SLURM_ARRAY_JOB_ID": JOB, "SLURM_ARRAY_TASK_ID": str(task),
                 "SLURM_NTASKS": "1", "SLURM_JOB_NUM_NODES": "1", "SLURM_NODEID": "0", "SLURM_PROCID": "0",
                 "SLURM_LOCALID": "0"}
        failed = subprocess.run(["bash", script], env={**os.environ, **about}).returncode
        (folder / f"{task}.state").write_text("FAILED" if failed else "COMPLETED")


def srun(folder: Path, *words: str) -> None:
    """Become the command, with its output where --output says."""
    left = list(words)
    while left[0].startswith("--"):
        option = left.pop(0)
        if option in ("--output", "--error"):
            place = left.pop(0).replace("%A", JOB).replace("%a", os.environ["SLURM_ARRAY_TASK_ID"]).replace("%t", "0")
            handle = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
            for stream in (1, 2) if option == "--output" else (2,):
                os.dup2(handle, stream)
    os.execvp(left[0], left)


def sacct(folder: Path, *words: str) -> None:
    """Print the states of the tasks."""
    print("JobID|State|NodeList")
    for file in sorted(folder.glob("*.state")):
        print(f"{JOB}_{file.stem}|{file.read_text()}|here")


def scancel(folder: Path, *words: str) -> None:
    """End what waits."""
    (folder / "over").touch()


if __name__ == "__main__":
    {"sbatch": sbatch, "work": work, "srun": srun, "sacct": sacct, "scancel": scancel}[sys.argv[1]](
        Path(os.environ["STANDIN_SLURM"]), *sys.argv[2:])
