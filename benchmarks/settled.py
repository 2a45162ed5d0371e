"""What is left of surprise at the end of a long run of lbs_dreamer, by how often a view was read and by where it is.

    .venv/bin/python benchmarks/settled.py RUN      # its images kept (loop.keep=all or replay); one CPU-minute

Loads the newest checkpoint and prints two tables. The first: KL of posterior and prior over EACH episodes of every age,
and the reward that the head expects of the same states, mean ± sd over episodes, beside the reads of a frame that are
expected of uniform replay. The second: KL on the world's probe (privileged: poses drawn from the true map), by the
distance from views that the run had. Nothing is learned or written.
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
from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.errors import ConfigError, UserError
from curionav_cli.execution.trained import take_weights, trained_in
from curionav_cli.records import Episode
from curionav_cli.results.prediction import novelty
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world import walks

AGES = (0, 5, 20, 80, 320, 960)  # episodes before the end
EACH = 12  # episodes of an age that are judged
SETTLED = novelty.SETTLED


def reads(settings: Config, episodes: int, index: int) -> float:
    """Expected reads of a frame of episode `index` by uniform replay until the end: each is drawn in proportion."""
    agent = settings.agent
    drawn = settings.loop.iterations * agent.batch_size * agent.sequence_length
    frames = settings.loop.steps / agent.action_repeat
    return float(drawn / frames * (1 / np.arange(index + 1, episodes + 1)).sum())


def by_age(run: RunFolder, settings: Config, agent: Agent) -> None:
    """Print the table of ages."""
    paths = run.episode_paths()
    end, rng = len(paths), np.random.default_rng(0)
    print("| episodes before the end | reads of a frame | KL, nats | expected by the head | their correlation |")
    print("|---" * 5 + "|")
    for youngest, oldest in zip(AGES, (*AGES[1:], end)):
        indices = np.arange(max(0, end - oldest), end - youngest)
        if not len(indices):
            continue
        chosen = np.sort(rng.choice(indices, min(EACH, len(indices)), replace=False))
        found = [agent.predict(int(n), Episode.load(paths[n], thinned=True)).surprise for n in chosen]
        kl, reward = ([getattr(one, key)[:, SETTLED:].ravel() for one in found] for key in ("kl", "reward"))
        alike = np.corrcoef(np.concatenate(kl), np.concatenate(reward))[0, 1]
        often = np.mean([reads(settings, end, n) for n in chosen])
        print(f"| {youngest} to {oldest} | {often:.1f} | {spread(kl)} | {spread(reward)} | {alike:.2f} |")


def by_place(run: RunFolder, settings: Config, agent: Agent) -> None:
    """Print the table of distances from views that the run had."""
    world = build.scene(settings)
    probe = walks.draw(world, agent.every)
    surprise = agent.probe(probe).surprise  # (N, H)
    pose = probe.pose[:, -surprise.shape[1]:].reshape(-1, 3)
    away = novelty.distance(pose, seen(run, agent))
    print("\n| views of the probe | n | KL, nats |\n|---|---|---|")
    for name, chosen in (("known, within 0.1 m", away < novelty.KNOWN), ("new, beyond 0.25 m", away > novelty.NEW)):
        mean = f"{surprise.ravel()[chosen].mean():.1f}" if chosen.any() else "-"
        print(f"| {name} | {chosen.sum()} | {mean} |")


def seen(run: RunFolder, agent: Agent) -> np.ndarray:
    """The poses (M, 3) of all frames that the agent acted on, to a millimetre."""
    poses = []
    for path in run.episode_paths():
        with np.load(path) as stored:
            poses.append(stored["pose"][agent.every.decisions(stored["action"], stored["collided"], path).frame])
    return np.unique(np.concatenate(poses).round(3), axis=0)


def spread(values: list[np.ndarray]) -> str:
    """Mean ± standard deviation over the episodes' means."""
    means = np.array([one.mean() for one in values])
    return f"{means.mean():.1f} ± {means.std(ddof=1):.1f}" if len(means) > 1 else f"{means.mean():.1f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path)
    run = RunFolder(parser.parse_args().run)
    try:
        trained = trained_in(run.path)
        settings = trained.settings
        if settings.agent.name != "lbs_dreamer":
            raise ConfigError(f"{run.path}: a run of lbs_dreamer is needed, and this is one of {settings.agent.name}.")
        agent = build.agent(settings, build.scene(settings))
        take_weights(agent, settings, trained)
        by_age(run, settings, agent)
    except UserError as error:
        raise SystemExit(str(error)) from None
    by_place(run, settings, agent)


if __name__ == "__main__":
    main()
