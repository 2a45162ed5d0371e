"""Fixed sequences of choices from poses all over a building, drawn from the true map: a probe for world models.

The same scene gives the same probe, whatever the seed of a run: it has a seed of its own, the numpy engine draws it,
and what changes between episodes is as in episode 0 of the run with seed 0 (furniture where the scene file has it).
"""

from __future__ import annotations

import numpy as np

from curionav_cli.constants import FORWARD, HEADINGS, IMAGE_SHAPE, LEFT, Stream
from curionav_cli.decisions import EACH_STEP, Every
from curionav_cli.probe import Probe
from curionav_cli.world import motion
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene

SEQUENCES, LENGTH = 200, 16  # choices of a sequence
REPEAT = 0.75  # probability that a step repeats the action before it; else each action is equally likely
ARRANGEMENT = 0, 0  # episode and seed whose furniture and light it has


def draw(scene: Scene, every: Every = EACH_STEP) -> Probe:
    """Draw the probe of a scene, for agents that choose so: perfect motion, scene.collision.

    A sequence begins anywhere on the visitable cells, at any of the 36 headings, each equally likely. Two actions in a
    row are the same one repeated with probability REPEAT to the power of the steps that each is held for; options are
    drawn uniformly.
    """
    now, _ = scene.at(*ARRANGEMENT)
    rng = np.random.default_rng([ARRANGEMENT[1], Stream.probe])
    x, y, heading = starts(now, rng)
    choice = decisions(len(every.names), REPEAT**every.held if every.held else 0.0, rng)
    renderer = Renderer(now)
    image = np.empty((SEQUENCES, LENGTH + 1, *IMAGE_SHAPE), np.uint8)
    pose = np.empty((SEQUENCES, LENGTH + 1, 3))
    for row, (start, chosen) in enumerate(zip(zip(x, y, heading), choice.tolist())):
        at_x, at_y, headings = walk(now, start, chosen, every)
        image[row], _ = renderer.render(at_x, at_y, headings)
        pose[row] = np.stack([at_x, at_y, motion.YAW[headings]], axis=-1)
    return Probe(image, choice, pose, every.held)


def starts(scene: Scene, rng: np.random.Generator) -> tuple[list[float], list[float], list[int]]:
    """Positions in metres, uniform over the visitable cells, and headings (steps of 10 degrees): (SEQUENCES,) each."""
    row, column = np.nonzero(scene.plan.visitable)
    cell = rng.integers(0, len(row), SEQUENCES)
    within = rng.random((2, SEQUENCES))
    x, y = (scene.plan.cell * (side[cell] + part) for side, part in zip((column, row), within))
    return x.tolist(), y.tolist(), rng.integers(0, HEADINGS, SEQUENCES).tolist()


def decisions(choices: int, repeat: float, rng: np.random.Generator) -> np.ndarray:
    """Choices (SEQUENCES, LENGTH) int64: each is the one before with this probability, else uniformly drawn."""
    chosen = rng.integers(0, choices, (SEQUENCES, LENGTH))
    kept = rng.random(chosen.shape) < repeat
    for step in range(1, LENGTH):
        chosen[:, step] = np.where(kept[:, step], chosen[:, step - 1], chosen[:, step])
    return chosen


def walk(scene: Scene, start: tuple[float, float, int], choices: list[int], every: Every
         ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y (T+1,) in metres and headings (T+1,) before, between and after T choices, each carried out."""
    x, y, heading = start
    places, execution = [start], every.execution()
    for choice in choices:
        execution.start(choice)
        collided = False
        while True:
            action = execution.step()
            if action == FORWARD:
                x, y, collided = motion.forward(scene.plan.visitable, scene.plan.cell, x, y, heading, scene.collision)
            else:
                heading = (heading + (1 if action == LEFT else -1)) % HEADINGS
            if execution.due({"collided": collided and action == FORWARD}):
                break
        places.append((x, y, heading))
    xs, ys, headings = zip(*places)
    return np.array(xs), np.array(ys), np.array(headings)
