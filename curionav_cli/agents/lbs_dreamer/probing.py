"""What a world model knows of a building: its open-loop error and its surprise on a fixed probe (probe.py).

A function of the world model alone, for every agent that has one.
Letters: N sequences, T frames of a sequence, B sequences at a time, S latents, H frames after the context.
"""

from __future__ import annotations

import numpy as np
import torch

from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.open_loop import squared_error, time_first
from curionav_cli.agents.lbs_dreamer.world_model import WorldModel
from curionav_cli.constants import Stream
from curionav_cli.probe import CONTEXT, Probe, Probed
from curionav_cli.storage.replay import NO_ACTION

AT_ONCE = 25  # sequences, B: bounds the memory


def measure(model: WorldModel, probe: Probe, device: torch.device) -> Probed:
    """Measure a world model on a probe; the formulas stand in `Probed`.

    Latents are drawn once, of the posterior in the context and of the prior after it, by noise that is the same for
    every model and at every time; an image is the mean of p(x | s), clipped to [0, 1] and rounded to 8 bits. The model
    starts from a zero state, as in training. Nothing is changed, and no random number of an agent is drawn.
    """
    rng = np.random.default_rng(Stream.probe_latents)
    led_to = np.pad(probe.action, ((0, 0), (1, 0)), constant_values=NO_ACTION)  # (N, T)
    predicted, surprise = zip(*(predict_and_filter(model, probe.image[at:at + AT_ONCE], led_to[at:at + AT_ONCE], rng,
                                                   device) for at in range(0, len(probe), AT_ONCE)))
    truth, seen = probe.image[:, CONTEXT:], probe.image[:, CONTEXT - 1:CONTEXT]
    return Probed(squared_error(np.concatenate(predicted), truth), squared_error(seen, truth), np.concatenate(surprise),
                  probe.free)


@torch.no_grad()
def predict_and_filter(model: WorldModel, image: np.ndarray, action: np.ndarray, rng: np.random.Generator,
                       device: torch.device) -> tuple[np.ndarray, np.ndarray]:
    """Predicted images (B, H, 64, 64, 3) uint8 and surprise (B, H) in nats of frames (B, T, 64, 64, 3), actions (B, T).
    """
    frames, actions = time_first(device, image, action)
    noise = torch.from_numpy(rng.random((*actions.shape, model.rssm.latents), np.float32)).to(device)
    predicted = model.predict(frames, actions, CONTEXT, noise)[CONTEXT:]
    observed = model.observe(model.rssm.initial(len(image)), model.patches(frames), actions, noise)
    surprise = latent.kl(observed.posterior, observed.prior)[CONTEXT:]
    return predicted.transpose(0, 1).cpu().numpy(), surprise.t().float().cpu().numpy()
