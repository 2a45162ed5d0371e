"""What a step costs the mapping explorer, early in a run and late, where little is left: two commits in turns.

    git worktree add --detach /tmp/old 9ac5a52
    curionav explore env=large_lab agent=mapper robot=ideal env.engine=numba loop.episodes=142 loop.keep=poses seed=0
    OMP_NUM_THREADS=1 python benchmarks/explorers_turns.py /tmp/old --late RUN --write    # RUN: the folder of that run

CPU-milliseconds of `act` and `begin` a step. Each contender is a process of its own, which acts in the worlds of
--worlds from the beginning, and in large_lab from the newest checkpoint of RUN; an episode each, in turns. Pictures are
drawn, and not counted. Stops unless all choose the same actions.
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
SECTION = "explorers in turns"


def work(tree: str, engine: str, world: str, run: str) -> None:
    """Answer each line of the input with an episode: [CPU-ms a step, digest of the actions, cells visited so far]."""
    sys.path.insert(0, tree)
    if engine == "numpy":
        sys.modules[NUMBA] = None  # type: ignore[assignment]
    import curionav_cli  # of that tree, before others put theirs first

    assert Path(tree).resolve() in Path(curionav_cli.__file__).parents, curionav_cli.__file__
    from explorers import Acting

    acting = Acting(world, ("agent=mapper",))
    if run:
        folder = max(path.parent for path in Path(run).glob("checkpoint/*/done"))
        acting.agent.load(folder)
        acting.seen = acting.env.reset(seed=0, options={"episode": int(folder.name)})
    for _ in sys.stdin:
        spent = acting.episode()
        visited = int(acting.agent.memory.visited.sum())  # type: ignore[attr-defined]
        print(json.dumps([spent, hashlib.sha256(bytes(acting.actions)).hexdigest(), visited]), flush=True)


def turns(contenders: dict[str, tuple[str, str]], world: str, run: str, episodes: int) -> dict[str, list[list]]:
    """The answers of each contender (tree, engine), one an episode. Raises SystemExit where actions differ."""
    ways = {name: subprocess.Popen([sys.executable, __file__, "--work", *contender, world, run], text=True,
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            for name, contender in contenders.items()}
    answers: dict[str, list[list]] = {name: [] for name in ways}
    for episode in range(episodes):
        for name, way in ways.items():
            print(file=way.stdin, flush=True)
            answers[name].append(json.loads(way.stdout.readline()))
        if len({found[-1][1] for found in answers.values()}) > 1:
            raise SystemExit(f"{world}: in episode {episode} the contenders chose other actions than each other.")
    for way in ways.values():
        way.communicate()
    return answers


def table(world: str, answers: dict[str, list[list]]) -> list[str]:
    """The rows of a world; the ratio is the median over turns of those to the first contender's, numpy's before."""
    spent = {name: np.array([answer[0] for answer in found]) for name, found in answers.items()}
    base, *_ = spent.values()
    visited = [answer[2] for answer in next(iter(answers.values()))]
    lines = []
    for name, numbers in spent.items():
        low, middle, high = np.quantile(numbers, (0.25, 0.5, 0.75))
        lines.append(f"| {world}, {visited[0]} to {visited[-1]} cells | {name} | {middle:.2f} "
                     f"| {low:.2f} to {high:.2f} | {np.median(numbers / base):.2f} |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", help="a checkout to compare this one with")
    parser.add_argument("--worlds", nargs="*", default=("small_room", "apartment_0", "large_lab"))
    parser.add_argument("--late", metavar="RUN", help="the folder of a run of agent=mapper in large_lab")
    parser.add_argument("--episodes", type=int, default=5)
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    options = parser.parse_args()
    before = os.getloadavg()[0]
    contenders = {f"{engine}'s searches, {age} commit": (tree, engine)
                  for engine in ("numpy", "numba") for age, tree in (("older", options.old), ("this", str(HERE)))}
    places = [(world, "") for world in options.worlds] + [("large_lab", options.late)] * bool(options.late)
    rows = [line for place in places for line in table(place[0], turns(contenders, *place, options.episodes))]
    text = "\n".join([
        f"{machine()}, {date.today()}; {options.episodes} episodes of 500 steps each, one thread, the same actions in "
        f"all four; load average {before:.1f} before and {os.getloadavg()[0]:.1f} after.", "",
        "| world, cells visited | mapper | CPU-ms a step | quartiles | x the first |", "|---|---|---|---|---|",
        *rows])
    print(text)
    if options.write:
        write(text, SECTION)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--work"]:
        work(*sys.argv[2:6])
    else:
        main()
