"""This checkout and an older one in turns: start-up, a whole episode, C-BET, the large map. One table, one command.

    git worktree add --detach /tmp/old 7cd86ae
    .venv/bin/python benchmarks/turns.py /tmp/old --write    # n = 8, about 16 CPU-minutes; --turns 3: 7
    .venv/bin/python benchmarks/turns.py /tmp/old --only map

Each turn runs every row once with the old code and once with this, one thread, so that a machine that is shared slows
both alike: compare the ratios. CPU-seconds are user and system time of a process and its children; MB is the largest
of them. Both run with the Python, the libraries and the extra `fast` of this checkout.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import date
from pathlib import Path
from typing import NamedTuple

import numpy as np
from simulator import machine, write

HERE = Path(__file__).resolve().parents[1]
SHORT = ("explore", "device=cpu", "loop.episodes=1")
SETS = ("avx2", "avx512f", "avx512_bf16", "amx_bf16", "asimd", "bf16")  # flags of /proc/cpuinfo
SECTION = "turns of two commits"


class Command(NamedTuple):
    """curionav with these words; alone: those that the older code does not know."""

    words: tuple[str, ...]
    alone: tuple[str, ...] = ()


COMMANDS = {
    "`curionav explore --help`": Command(("explore", "--help")),
    "100 steps of `random`, figures": Command((*SHORT, "loop.steps=100", "agent=random")),
    "100 steps of `lbs_dreamer`, 4 updates, figures": Command((*SHORT, "loop.steps=100", "loop.iterations=4")),
    "500 steps of `lbs_dreamer`, 100 updates": Command((*SHORT, "loop.steps=500", "loop.iterations=100")),
    "the same, `compile=fused`": Command((*SHORT, "loop.steps=500", "loop.iterations=100"), ("compile=fused",)),
}
MAP = "the 100 x 100 m map loads"
CBET = "C-BET"
Numbers = dict[str, list[float]]  # "old", "new": CPU-seconds (C-BET: CPU-ms a frame) in each turn; "... MB"


def environment(tree: Path) -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(tree), "OMP_NUM_THREADS": "1", "OMP_WAIT_POLICY": "PASSIVE"}


def spent(tree: Path, words: tuple[str, ...]) -> tuple[float, float]:
    """CPU-seconds and MB of `curionav WORDS` by that checkout's code. Raises SystemExit where it fails."""
    folder = tempfile.mkdtemp()
    child = subprocess.Popen([sys.executable, "-m", "curionav_cli", *words], cwd=folder, env=environment(tree),
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    shutil.rmtree(folder)
    if child.returncode is None:
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"{tree}: curionav {' '.join(words)} ended with code {child.returncode}.")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3


def map_loaded(tree: Path) -> tuple[float, float]:
    """CPU-seconds and MB of loading the large map."""
    done = subprocess.run([sys.executable, tree / "benchmarks" / "contenders.py", "office", "0"], check=True, text=True,
                          env=environment(tree), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    found = json.loads(done.stdout.splitlines()[-1])
    return found["load"], found["memory"]


def whole_processes(trees: dict[str, Path], only: str, turns: int) -> Iterator[tuple[str, Numbers]]:
    """Yield each row that is a process of its own; one run before the first turn fills the caches of files."""
    for name, command in COMMANDS.items():
        if only in name:
            yield name, measured(trees, turns, lambda which, tree, command=command: spent(
                tree, command.words + (command.alone if which == "new" else ())))
    if only in MAP:
        yield MAP, measured(trees, turns, lambda which, tree: map_loaded(tree))


def measured(trees, turns, once) -> Numbers:
    numbers: Numbers = {}
    for turn in range(-1, turns):
        for which, tree in trees.items():
            seconds, memory = once(which, tree)
            if turn >= 0:
                numbers.setdefault(which, []).append(seconds)
                numbers.setdefault(f"{which} MB", []).append(memory)
    return numbers


@contextmanager
def asked(tree: Path) -> Iterator[subprocess.Popen]:
    """C-BET by that checkout's code, ready to be asked for an episode."""
    with subprocess.Popen([sys.executable, HERE / "benchmarks" / "cbet_pieces.py", tree], env=environment(tree),
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as child:
        child.stdout.readline()
        yield child
        child.stdin.close()


def pieces(trees: dict[str, Path], turns: int) -> dict[str, Numbers]:
    """C-BET's pieces, CPU-ms a frame: two episodes a turn."""
    found: dict[str, Numbers] = {}
    with asked(trees["old"]) as old, asked(trees["new"]) as new:
        for _ in range(2 * turns):
            for which, child in (("old", old), ("new", new)):
                print("episode", file=child.stdin, flush=True)
                for name, value in json.loads(child.stdout.readline()).items():
                    found.setdefault(f"{CBET}, {name}, ms a frame", {}).setdefault(which, []).append(value)
    return found


def quartiles(values: np.ndarray, digits: int = 2) -> str:
    low, middle, high = np.quantile(values, (0.25, 0.5, 0.75))
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def row(name: str, numbers: Numbers) -> str:
    old, new = (np.array(numbers[which]) for which in ("old", "new"))
    memory = [f"{np.median(numbers[key]):.0f}" if (key := f"{which} MB") in numbers else "" for which in ("old", "new")]
    digits = 3 if name.startswith(CBET) else 2
    return (f"| {name} | {len(new)} | {quartiles(old, digits)} | {quartiles(new, digits)} | {quartiles(new / old)} "
            f"| {', '.join(filter(None, memory))} |")


def commit(tree: Path) -> str:
    said = subprocess.run(["git", "-C", tree, "describe", "--always", "--dirty"], capture_output=True, text=True)
    return said.stdout.strip() or tree.name


def head(trees: dict[str, Path], before: float) -> str:
    """Where and when: the processor with its instruction sets, both commits, the load."""
    flags = set(Path("/proc/cpuinfo").read_text().split())
    sets = ", ".join(name for name in SETS if name in flags)
    return (f"{machine()} ({sets}), {date.today()}; old {commit(trees['old'])}, new {commit(trees['new'])}, in turns; "
            f"medians and quartiles; load average {before:.1f} before and {os.getloadavg()[0]:.1f} after.\n")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path, help="a checkout of the older commit")
    parser.add_argument("--turns", type=int, default=8)
    parser.add_argument("--only", default="", help=f"only rows whose name contains this; {CBET} for its pieces")
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    chosen = parser.parse_args()
    trees, before = {"old": chosen.old.resolve(), "new": HERE}, os.getloadavg()[0]
    lines = ["| what, CPU-seconds | n | old | new | new / old | MB, old, new |", "|---" * 6 + "|"]
    for name, numbers in whole_processes(trees, chosen.only, chosen.turns):
        lines.append(row(name, numbers))
        print(lines[-1], file=sys.stderr, flush=True)
    if chosen.only in CBET:
        lines += [row(name, numbers) for name, numbers in pieces(trees, chosen.turns).items()]
    text = "\n".join([head(trees, before), *lines])
    print(text)
    if chosen.write:
        write(text, SECTION)


if __name__ == "__main__":
    main()
