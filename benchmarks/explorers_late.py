"""What a step costs the mapping explorer late in a run, where little is left: two trees of this repository in turns.

    curionav explore env=large_lab agent=mapper robot=ideal env.engine=numba loop.episodes=142 loop.keep=poses seed=0
    git worktree add --detach /tmp/old 82c13f6
    OMP_NUM_THREADS=1 python benchmarks/explorers_late.py RUN /tmp/old --write    # RUN: the folder of that run

CPU-milliseconds of `act` and `begin` a step. Each contender is a process that goes on from the run's newest checkpoint;
they act for an episode in turns. Pictures are drawn, and not counted. Fails unless all choose the same actions.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
from datetime import date
from pathlib import Path

import numpy as np
from simulator import machine, write

HERE = Path(__file__).resolve().parents[1]
NUMBA = "curionav_cli.agents.lattice_numba"
SECTION = "explorers late"


def work(tree: str, run: str, engine: str) -> None:
    """Answer each line of the input with an episode: [CPU-ms a step, digest of the actions, cells visited so far]."""
    sys.path.insert(0, tree)
    if engine == "numpy":
        sys.modules[NUMBA] = None  # type: ignore[assignment]
    import curionav_cli  # of that tree, before others put theirs first

    assert Path(tree).resolve() in Path(curionav_cli.__file__).parents, curionav_cli.__file__
    from explorers import Acting

    folder = max(path.parent for path in Path(run).glob("checkpoint/*/done"))
    acting = Acting("large_lab", ("agent=mapper",))
    acting.agent.load(folder)
    acting.seen = acting.env.reset(seed=0, options={"episode": int(folder.name)})
    for _ in sys.stdin:
        spent = acting.episode()
        visited = int(acting.agent.memory.visited.sum())  # type: ignore[attr-defined]
        print(json.dumps([spent, hashlib.sha256(bytes(acting.actions)).hexdigest(), visited]), flush=True)


def turns(contenders: dict[str, tuple[str, str]], run: str, episodes: int) -> dict[str, list[list]]:
    """The answers of each contender (tree, engine), one an episode. Raises SystemExit where actions differ."""
    ways = {name: subprocess.Popen([sys.executable, __file__, run, tree, "--work", engine], text=True,
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            for name, (tree, engine) in contenders.items()}
    answers: dict[str, list[list]] = {name: [] for name in ways}
    for episode in range(episodes):
        for name, way in ways.items():
            print(file=way.stdin, flush=True)
            answers[name].append(json.loads(way.stdout.readline()))
        if len({found[-1][1] for found in answers.values()}) > 1:
            raise SystemExit(f"The contenders chose other actions than each other in episode {episode}.")
    for way in ways.values():
        way.communicate()
    return answers


def table(answers: dict[str, list[list]]) -> list[str]:
    """The rows; the ratio is the median over turns of those to the first contender's."""
    spent = {name: np.array([answer[0] for answer in found]) for name, found in answers.items()}
    base = next(iter(spent.values()))
    lines = []
    for name, numbers in spent.items():
        low, middle, high = np.quantile(numbers, (0.25, 0.5, 0.75))
        lines.append(f"| {name} | {middle:.2f} | {low:.2f} to {high:.2f} | {numbers.max():.2f} "
                     f"| {np.median(numbers / base):.2f} |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", help="the folder of a run of agent=mapper in large_lab")
    parser.add_argument("old", help="a checkout to compare this one with")
    parser.add_argument("--episodes", type=int, default=8)
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    parser.add_argument("--work", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.work:
        work(options.old, options.run, options.work)
        return
    before = os.getloadavg()[0]
    contenders = {"the older tree": (options.old, "numba"), "this one, numpy's searches": (str(HERE), "numpy"),
                  "this one, numba's searches": (str(HERE), "numba")}
    answers = turns(contenders, options.run, options.episodes)
    visited = [answer[2] for answer in next(iter(answers.values()))]
    text = "\n".join([
        f"{machine()}, {date.today()}; large_lab, {options.episodes} episodes of 500 steps from {visited[0]} to "
        f"{visited[-1]} cells visited, one thread, the same actions in all; load average {before:.1f} before and "
        f"{os.getloadavg()[0]:.1f} after.", "",
        "| searches | CPU-ms a step | quartiles | most | x the older tree |", "|---|---|---|---|---|", *table(answers)])
    print(text)
    if options.write:
        write(text, SECTION)


if __name__ == "__main__":
    main()
