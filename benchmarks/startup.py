"""CPU-seconds of short commands, user and system, in turns with other checkouts: curionav explore --help, and one
episode of 100 steps with its figures.

python benchmarks/startup.py [CHECKOUT ...] --turns 8    a row for this checkout and for each other, quartiles, ratio
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
SHORT = ("explore", "device=cpu", "loop.episodes=1", "loop.steps=100")
COMMANDS = {
    "explore --help": ("explore", "--help"),
    "agent=random": (*SHORT, "agent=random"),
    "agent=lbs_dreamer, 4 updates": (*SHORT, "agent=lbs_dreamer", "loop.iterations=4"),
}


def seconds(checkout: Path, words: tuple[str, ...]) -> float:
    """CPU-seconds of `curionav WORDS` by that checkout's code, its children included."""
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-m", "curionav_cli", *words], check=True, cwd=folder, env=environment,
                       stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def row(name: str, took: list[float], first: list[float]) -> str:
    """A row of the table: median, quartiles, and the median of the ratios to the first checkout, turn by turn."""
    low, middle, high = statistics.quantiles(took, n=4, method="inclusive")
    ratio = statistics.median(own / theirs for own, theirs in zip(first, took, strict=True))
    return f"| {name} | {middle:.2f} | {low:.2f} to {high:.2f} | {ratio:.2f} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("others", nargs="*", type=Path, help="other checkouts, such as a worktree of an older commit")
    parser.add_argument("--turns", type=int, default=8)
    asked = parser.parse_args()
    checkouts = [HERE, *(path.resolve() for path in asked.others)]
    for checkout in checkouts:  # once before, for files that Python and matplotlib cache
        seconds(checkout, COMMANDS["agent=random"])
    print(f"| command, checkout (n = {asked.turns}) | CPU-s | quartiles | ours to it |\n|---|---|---|---|")
    for command, words in COMMANDS.items():
        took: dict[Path, list[float]] = {checkout: [] for checkout in checkouts}
        for _ in range(asked.turns):
            for checkout in checkouts:
                took[checkout].append(seconds(checkout, words))
        for checkout in checkouts:
            print(row(f"{command}, {checkout.name}", took[checkout], took[HERE]), flush=True)


if __name__ == "__main__":
    main()
