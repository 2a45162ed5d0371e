"""Predicted observations (paper, section "Qualitative results"): a few frames are seen, then only the actions.

The pictures come from the windows in which most happens, one in each part of the episode; the errors from
windows evenly spread, whatever happens in them; surprise is that of every step.
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
from curionav_cli.records import Episode, Prediction, Surprise
from curionav_cli.storage.replay import NO_ACTION

CONTEXT, HORIZON = 5, 20
STEPS = np.array([0, 1, 3, 5, 8, 11, 15, 20])  # that are drawn, counted from the last frame that is seen
SHOWN, MEASURED = 6, 16  # windows


def predict_episode(networks: Networks, episode: Episode, length: int, rng: np.random.Generator, device: torch.device,
                    every: int = 1) -> Prediction | None:
    """Open-loop predictions of an episode; None where it is too short for one. length: of a training sequence;
    every: steps for which an action is held. Windows are made of the frames that are acted on."""
    episode = episode.every(every)
    horizon = min(HORIZON, len(episode.image) - CONTEXT)
    if horizon < 1:
        return None
    last = len(episode.image) - CONTEXT - horizon
    shown = liveliest(episode.image, last, horizon)
    start = np.concatenate([shown, np.linspace(0, last, MEASURED).round().astype(np.int64)])
    at = start[:, None] + np.arange(CONTEXT + horizon)  # (B, T), frames of the episode
    truth = episode.image[at]
    predicted = predict(networks.world_model, truth, led_to(episode.action, at), rng, device)
    step = STEPS[horizon >= STEPS]
    drawn = CONTEXT - 1 + step
    truth, whole = truth[len(shown):], predicted[len(shown):]
    surprised = surprise(networks, episode, length, rng, device)
    return Prediction(step * every, at[:len(shown), drawn] * every, predicted[:len(shown), drawn],
                     squared_error(whole[:, CONTEXT:], truth[:, CONTEXT:]),
                     squared_error(truth[:, CONTEXT - 1:CONTEXT], truth[:, CONTEXT:]),
                     replace(surprised, frame=surprised.frame * every), every)


@torch.no_grad()
def surprise(networks: Networks, episode: Episode, length: int, rng: np.random.Generator, device: torch.device
             ) -> Surprise:
    """KL and curiosity's reward at every step, filtered as in training: windows of `length`, each from a zero state.

    The last window is flush with the episode's end. The reward is that of states drawn from the dynamics, as
    in imagination.
    """
    length = min(length, len(episode.image))
    start = np.minimum(np.arange(0, len(episode.image), length), len(episode.image) - length)
    at = start[:, None] + np.arange(length)  # (M, L)
    model, rssm = networks.world_model, networks.world_model.rssm
    frames, action = time_first(device, episode.image[at], led_to(episode.action, at))
    noise = torch.from_numpy(rng.random((2, *action.shape, rssm.latents), np.float32)).to(device)
    seen = model.observe(rssm.initial(len(at)), model.patches(frames), action, noise[0])
    expected = State(seen.states.deter, latent.draw(seen.prior, noise[1])[0].flatten(-2))
    reward = networks.curiosity.reward(Imagined(expected.features, action[1:]))
    kl = latent.kl(seen.posterior, seen.prior)
    return Surprise(at, *(found.t().float().cpu().numpy() for found in (kl, reward)))


def liveliest(image: np.ndarray, last: int, horizon: int) -> np.ndarray:
    """Of each of SHOWN parts of the starts 0 to `last` the one whose predicted frames change most: (W,) int64."""
    coarse = image[:, ::4, ::4].astype(np.int16)
    moved = np.concatenate([[0.0], np.abs(np.diff(coarse, axis=0)).mean((1, 2, 3)).cumsum()])
    seen = np.arange(last + 1) + CONTEXT - 1
    change = moved[seen + horizon] - moved[seen]
    parts = np.array_split(np.arange(last + 1), min(SHOWN, last + 1))
    return np.array([part[change[part].argmax()] for part in parts])


def led_to(action: np.ndarray, at: np.ndarray) -> np.ndarray:
    """The actions that led to the frames `at` (B, T); none leads to a window's first."""
    into = np.concatenate([[NO_ACTION], action])[at]
    into[:, 0] = NO_ACTION
    return into


def predict(model: WorldModel, image: np.ndarray, action: np.ndarray, rng: np.random.Generator,
            device: torch.device) -> np.ndarray:
    """Batch first, in numpy: image (B, T, 64, 64, 3) uint8, action (B, T) -> what was expected, as image."""
    frames, actions = time_first(device, image, action)
    noise = torch.from_numpy(rng.random((*actions.shape, model.rssm.latents), np.float32)).to(device)
    return model.predict(frames, actions, CONTEXT, noise).transpose(0, 1).cpu().numpy()


def time_first(device: torch.device, *arrays: np.ndarray) -> list[torch.Tensor]:
    """Arrays (B, T, ...) as tensors (T, B, ...)."""
    return [torch.from_numpy(array).transpose(0, 1).contiguous().to(device) for array in arrays]


def squared_error(image: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """(N, H) float32 in units of [0, 1]: mean over pixels and colours of images (N, H or 1, 64, 64, 3)."""
    apart = (image.astype(np.float32) - truth) / 255
    return np.square(apart).mean((2, 3, 4), dtype=np.float64).astype(np.float32)
