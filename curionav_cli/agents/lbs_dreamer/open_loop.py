"""Open-loop predictions (paper, "Qualitative results"): CONTEXT frames are observed, then only the actions are known.

The images shown come from the windows that change most, one in each part of the episode; the errors from evenly spread
windows; the surprise from every step.

Letters: W windows shown, B windows, T frames of a window, M windows of L frames for the surprise, H horizon, N windows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import torch

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.learner import Networks
from curionav_cli.agents.lbs_dreamer.rssm import State
from curionav_cli.agents.lbs_dreamer.world_model import WorldModel
from curionav_cli.decisions import Every
from curionav_cli.records import Episode, Prediction, Surprise
from curionav_cli.storage.replay import NO_ACTION

CONTEXT, HORIZON = 5, 20
STEPS = np.array([0, 1, 3, 5, 8, 11, 15, 20])  # that are shown, counted from the last observed frame
SHOWN, MEASURED = 6, 16  # windows


def predict_episode(networks: Networks, episode: Episode, length: int, rng: np.random.Generator, device: torch.device,
                    every: Every) -> Prediction | None:
    """Predict windows of an episode, and measure its surprise; None where it is too short for a window.

    length: of a training sequence. every: how often the agent chooses; windows are of the frames at which it did.
    """
    chosen = every.decisions(episode.action, episode.collided)
    episode = episode.at(chosen)
    horizon = min(HORIZON, len(episode.image) - CONTEXT)
    if horizon < 1:
        return None
    last = len(episode.image) - CONTEXT - horizon
    shown = most_changing(episode.image, last, horizon)
    start = np.concatenate([shown, np.linspace(0, last, MEASURED).round().astype(np.int64)])
    frame = start[:, None] + np.arange(CONTEXT + horizon)  # (B, T), of the episode
    truth = episode.image[frame]
    predicted = predict(networks.world_model, truth, led_to(episode.action, frame), rng, device)
    step = STEPS[horizon >= STEPS]
    at = CONTEXT - 1 + step  # of the window
    truth, measured = truth[len(shown):], predicted[len(shown):]
    measured_surprise = surprise(networks, episode, length, rng, device)
    return Prediction(step * max(1, every.held), chosen.frame[frame[:len(shown), at]], predicted[:len(shown), at],
                     squared_error(measured[:, CONTEXT:], truth[:, CONTEXT:]),
                     squared_error(truth[:, CONTEXT - 1:CONTEXT], truth[:, CONTEXT:]),
                     replace(measured_surprise, frame=chosen.frame[measured_surprise.frame]), every.held)


@torch.no_grad()
def surprise(networks: Networks, episode: Episode, length: int, rng: np.random.Generator, device: torch.device
             ) -> Surprise:
    """KL and intrinsic reward at every step, filtered as in training: windows of `length`, each from a zero state.

    The last window ends where the episode does. The reward is of states drawn from the dynamics, as in imagination.
    """
    length = min(length, len(episode.image))
    start = np.minimum(np.arange(0, len(episode.image), length), len(episode.image) - length)
    frame = start[:, None] + np.arange(length)  # (M, L)
    model, rssm = networks.world_model, networks.world_model.rssm
    frames, action = time_first(device, episode.image[frame], led_to(episode.action, frame))
    noise = torch.from_numpy(rng.random((2, *action.shape, rssm.latents), np.float32)).to(device)
    observed = model.observe(rssm.initial(len(frame)), model.patches(frames), action, noise[0])
    expected = State(observed.states.deter, latent.draw(observed.prior, noise[1])[0].flatten(-2))
    reward = networks.curiosity.intrinsic_reward(Imagined(expected.features, action[1:]))  # (L, M)
    kl = latent.kl(observed.posterior, observed.prior)  # (L, M)
    return Surprise(frame, *(rows.t().float().cpu().numpy() for rows in (kl, reward)))


def most_changing(image: np.ndarray, last: int, horizon: int) -> np.ndarray:
    """From each of SHOWN parts of the starts 0 to `last` the one whose predicted frames change most: (W,) int64."""
    coarse = image[:, ::4, ::4].astype(np.int16)
    moved = np.concatenate([[0.0], np.abs(np.diff(coarse, axis=0)).mean((1, 2, 3)).cumsum()])
    observed = np.arange(last + 1) + CONTEXT - 1  # the last observed frame of each window
    change = moved[observed + horizon] - moved[observed]
    parts = np.array_split(np.arange(last + 1), min(SHOWN, last + 1))
    return np.array([part[change[part].argmax()] for part in parts])


def led_to(action: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """The actions (B, T) that led to frames (B, T) of an episode with actions (T,); NO_ACTION for a window's first."""
    before = np.concatenate([[NO_ACTION], action])[frame]
    before[:, 0] = NO_ACTION
    return before


def predict(model: WorldModel, image: np.ndarray, action: np.ndarray, rng: np.random.Generator,
            device: torch.device) -> np.ndarray:
    """Open-loop predictions (B, T, 64, 64, 3) uint8, batch first, from images of that shape and actions (B, T)."""
    frames, actions = time_first(device, image, action)
    noise = torch.from_numpy(rng.random((*actions.shape, model.rssm.latents), np.float32)).to(device)
    return model.predict(frames, actions, CONTEXT, noise).transpose(0, 1).cpu().numpy()


def time_first(device: torch.device, *arrays: np.ndarray) -> list[torch.Tensor]:
    """Arrays (B, T, ...) as tensors (T, B, ...)."""
    return [torch.from_numpy(array).transpose(0, 1).contiguous().to(device) for array in arrays]


def squared_error(image: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """(N, H) float32 in units of [0, 1]: mean over pixels and colours of images (N, H or 1, 64, 64, 3)."""
    difference = (image.astype(np.float32) - truth) / 255
    return np.square(difference).mean((2, 3, 4), dtype=np.float64).astype(np.float32)
