"""How often must a frame be read before surprise separates new views from known ones?

    .venv/bin/python benchmarks/reads.py RUN...      # runs of lbs_dreamer; one and a half CPU-minutes each

An agent of the run's settings learns from the run's first EPISODES episodes alone and, each time they have been read
so often, is surprised by the next JUDGED ones, which it never learns from. Prints the table of novelty.py's ratio (mean
surprise of new views over that of known ones) and area under the ROC curve, mean ± sd over the runs.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
os.environ |= {"OMP_NUM_THREADS": "1", "OMP_WAIT_POLICY": "PASSIVE"}  # as the command line sets them, before torch
from curionav_cli import build
from curionav_cli.config.settings import read_settings
from curionav_cli.records import Episode
from curionav_cli.results.prediction import novelty
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder

EPISODES, JUDGED = 10, 5
READS = (7, 14, 28, 56, 112, 224)  # of each frame


def judged(run: RunFolder) -> dict[int, dict[str, float]]:
    """Reads a frame -> the row of all views. Raises SystemExit for a run that is too short, or of another agent."""
    settings = read_settings(run.config)
    paths = run.episode_paths()
    if settings.agent.name != "lbs_dreamer" or len(paths) < EPISODES + JUDGED:
        raise SystemExit(f"{run.path}: a run of lbs_dreamer with {EPISODES + JUDGED} episodes or more is needed.")
    agent = build.agent(settings, build.scene(settings))
    known, new = ([Episode.load(path) for path in some] for some in (paths[:EPISODES], paths[EPISODES:][:JUDGED]))
    replay = Replay(known, every=agent.every)
    frames = sum(len(replay.episode(index)) for index in range(len(replay)))
    batch = settings.agent.batch_size * settings.agent.sequence_length
    chosen = [agent.every.decisions(one.action, one.collided).frame for one in new]
    earlier, found = np.concatenate([replay.episode(index).pose for index in range(len(replay))]), {}
    for reads in READS:
        agent.learn(replay, round(reads * frames / batch) - agent.learner.updates, lambda done: None)
        views = [novelty.judged(agent.predict(EPISODES + n, one), frame, novelty.distance(one.pose[frame], earlier),
                                novelty.kinds(one.action, one.collided, frame))
                 for n, (one, frame) in enumerate(zip(new, chosen, strict=True))]
        found[reads] = novelty.table(novelty.Views(*(np.concatenate(parts, -1) for parts in zip(*views))))[0]
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path)
    tables = [judged(RunFolder(path)) for path in parser.parse_args().runs]
    views = sum(np.array([found[READS[0]]["new"], found[READS[0]]["known"]]) for found in tables)
    print(f"{len(tables)} runs; {views[0]} new views, {views[1]} known\n")
    columns = [f"{signal} {key}" for signal in novelty.SIGNALS for key in ("ratio", "auc")]
    print(f"| reads of each frame | {' | '.join(columns)} |\n{'|---' * (len(columns) + 1)}|")
    for reads in READS:
        numbers = np.array([[found[reads][column] for column in columns] for found in tables], float)
        cells = [f"{mean:.2f} ± {sd:.2f}" for mean, sd in zip(numbers.mean(0), numbers.std(0, ddof=len(tables) > 1))]
        print(f"| {reads} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
