"""Predictions that an agent stored before it learned from an episode, beside the episode's own frames."""

from __future__ import annotations

import math
import warnings
from typing import NamedTuple

import numpy as np

from curionav_cli.errors import RunFolderError, SoundnessWarning
from curionav_cli.records import Episode, Prediction, counted
from curionav_cli.results.prediction import moved_objects
from curionav_cli.results.runs import Run
from curionav_cli.storage import pictures

NEWEST = 5  # episodes; the agent hardly changes over them


class Strip(NamedTuple):
    """One window of an episode at F steps, counted from the last frame that the agent saw.

    step (F,); frame (F,), of the episode; truth and predicted (F, 64, 64, 3) uint8; pose (F, 3); places in
    metres where objects that moved before the episode stood and stand; circles (F): around what differs because
    of them. unit: what `step` counts.
    """

    episode: int
    step: np.ndarray
    frame: np.ndarray
    truth: np.ndarray
    predicted: np.ndarray
    pose: np.ndarray
    places: list[tuple[float, float]]
    circles: list[list[moved_objects.Ellipse]]
    unit: str = "steps"


class Errors(NamedTuple):
    """Mean squared errors in units of [0, 1] after 1 to H actions, one row an episode or a run: (N, H) each.

    every: steps for which an action is held; 0 for options, which then are what is counted.
    """

    predicted: np.ndarray
    repeated: np.ndarray
    every: int

    @property
    def steps(self) -> np.ndarray:
        """Steps of the robot (H,), or options, after which each error was measured."""
        return np.arange(1, self.predicted.shape[1] + 1) * max(1, self.every)

    @property
    def unit(self) -> str:
        """What `steps` counts."""
        return counted(self.every)

    def after(self, actions: int) -> tuple[float, float]:
        """Mean error of the prediction and of the repeated frame after so many actions."""
        return float(self.predicted[:, actions - 1].mean()), float(self.repeated[:, actions - 1].mean())


def newest(run: Run, most: int = NEWEST) -> dict[int, Prediction]:
    """Read the predictions of the newest episodes, oldest first; none where the agent predicts nothing.

    Broken ones are named in a SoundnessWarning and left out: nothing else is built on them.
    """
    found = {}
    for index, path in list(run.predictions.items())[-most:]:
        try:
            found[index] = Prediction.load(path)
        except RunFolderError as error:
            warnings.warn(f"{error} Left out.", SoundnessWarning, stacklevel=2)
    return found


def errors(run: Run) -> Errors | None:
    """Errors over the newest episodes, each the mean of its windows; None without predictions."""
    read = list(newest(run).values())
    return over_runs([Errors(one.error, one.repeat, one.every) for one in read]) if read else None


def over_runs(several: list[Errors]) -> Errors:
    """Stack several errors, one row each, up to the fewest actions that any of them predicted."""
    actions = min(one.predicted.shape[1] for one in several)
    predicted = np.stack([one.predicted.mean(0)[:actions] for one in several])
    repeated = np.stack([one.repeated.mean(0)[:actions] for one in several])
    return Errors(predicted, repeated, several[0].every)


def strips(run: Run) -> list[Strip]:
    """Read every window of the newest episodes, the newest episode first; none where images were not kept."""
    env = run.config["env"]
    camera = moved_objects.Camera(env["camera"], math.tan(math.radians(env["fov"] / 2)))
    found = [window for index, one in reversed(newest(run).items()) for window in windows(run, index, one)]
    differences = [moved_objects.difference(window.predicted, window.truth) for window in found]
    usual = [moved_objects.usual(np.stack(same)) for same in zip(*differences)]
    return [window._replace(circles=circles(window, difference, usual, camera))
            for window, difference in zip(found, differences)]


def windows(run: Run, index: int, prediction: Prediction) -> list[Strip]:
    """Read predictions beside the episode's own frames; circles are empty yet. None where images were not kept."""
    path = run.folder.episode_path(index)
    held = pictures.kept(path)
    if not len(prediction.image) or (held is not None and not np.isin(prediction.frame, held).all()):
        return []
    episode = Episode.load(path, thinned=True)
    places = moved_objects.places(episode.events)
    return [Strip(index, prediction.step, frame, episode.images(frame, path), image, episode.pose[frame], places, [],
                  counted(prediction.every))
            for frame, image in zip(prediction.frame, prediction.image)]


def circles(window: Strip, difference: np.ndarray, usual: list[float], camera: moved_objects.Camera
            ) -> list[list[moved_objects.Ellipse]]:
    """Find the circles of every step of a window; a step that was seen has none. difference (F, 64, 64), usual (F)."""
    return [[moved_objects.ellipse(region) for region in
             moved_objects.regions(apart, one_usual, moved_objects.around(window.places, pose, camera, len(apart)))]
            if step > 0 else []
            for step, apart, one_usual, pose in zip(window.step, difference, usual, window.pose)]
