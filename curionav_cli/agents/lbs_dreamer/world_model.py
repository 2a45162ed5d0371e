"""The world model and its loss, equation (1) of the paper.

    L_wm = KL[ q(s_t | s_{t-1}, a_{t-1}, x_t) || p(s_t | s_{t-1}, a_{t-1}) ] - E_q[ log p(x_t | s_t) ]

The KL is balanced and has free nats (DreamerV2, algorithm 2); p(x | s) is a normal distribution of variance one, so the
second term is half a squared error but for a constant.

Letters: T steps, B sequences, N frames, F features, S latents, C classes, (G, G, P) an image as patches (networks.py).
"""

from __future__ import annotations

from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.kernels.patches import to_images, to_patches
from curionav_cli.agents.lbs_dreamer.networks import Decoder, Encoder
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, Observed, State


class Sequences(NamedTuple):
    """B windows of T steps from the replay, time first, on the device."""

    image: Tensor  # (T, B, 64, 64, 3) uint8
    action: Tensor  # (T, B) int64, a_{t-1}: the action that led to the step, -1 for none
    is_start: Tensor  # (B,) bool, the window begins where an episode does
    counts: Tensor | None = None  # (T, B) float32, visits of each step's cell or key, for curiosities that count


def choose(total: int, count: int, noise: Tensor) -> Tensor | slice:
    """Draw `count` of `total` indices without replacement, by the order of `noise` (total,): (count,)."""
    return slice(None) if count == total else noise.argsort()[:count]


class WorldModel(nn.Module):
    """Encoder, RSSM (posterior and dynamics) and decoder; `decoded` of a batch's frames are reconstructed."""

    def __init__(self, hyper: lbs_settings.LBSDreamer, actions: int):
        super().__init__()
        self.encoder = Encoder(hyper.encoder_channels, hyper.encoder_kernels, hyper.encoder_strides)
        self.rssm = RSSM(self.encoder.size, actions, hyper.gru_units, hyper.rssm_hidden,
                         hyper.latent_dimension, hyper.latent_classes)
        self.decoder = Decoder(self.rssm.features, self.encoder.size, hyper.decoder_channels,
                               hyper.decoder_kernels, hyper.decoder_strides)
        self.balance, self.free_nats = hyper.kl_balance, hyper.free_nats
        frames = hyper.batch_size * hyper.sequence_length
        self.decoded = max(1, round(hyper.decoded_share * frames))

    def patches(self, image: Tensor) -> Tensor:
        """Images (..., 64, 64, 3) uint8 as the encoder reads and the decoder returns them: (N, G, G, P) float32.

        Where encoder and error are fused for a CPU (compile.py) the same in bytes, which only those two read.
        """
        return to_patches(image, self.encoder.stride)

    def observe(self, state: State, patches: Tensor, action: Tensor, noise: Tensor) -> Observed:
        """Filter T steps: patches (T * B, G, G, P), action (T, B), noise (T, B, S)."""
        embed = self.encoder(patches).unflatten(0, action.shape)  # (T, B, E)
        return self.rssm.observe(state, embed, action, noise)

    def loss(self, data: Sequences, noise: Tensor, frame_noise: Tensor
             ) -> tuple[Tensor, Observed, dict[str, Tensor]]:
        """Equation (1) on a batch, without the constant of log p(x | s): scalar loss, filtered steps, metrics.

        noise (T, B, S) draws the latents; frame_noise (T * B,) chooses the frames to be decoded.
        """
        patches = self.patches(data.image)  # (T * B, G, G, P)
        state = self.rssm.initial(data.action.shape[1])
        observed = self.observe(state, patches, data.action, noise)
        chosen = choose(len(patches), min(self.decoded, len(patches)), frame_noise)
        features = observed.states.features.flatten(0, 1)  # (T * B, F)
        error = self.image_error(features[chosen], patches[chosen])
        divergence = latent.balanced_kl(observed.posterior, observed.prior, self.balance, self.free_nats)
        loss = divergence + error / 2
        metrics = {
            "model_loss": loss, "image_loss": error / 2, "image_mse": error / patches[0].numel(),
            "prior_entropy": latent.entropy(observed.prior.detach()).sum(-1).mean(),
            "posterior_entropy": latent.entropy(observed.posterior.detach()).sum(-1).mean(),
        }
        return loss, observed, metrics

    def image_error(self, features: Tensor, patches: Tensor) -> Tensor:
        """Squared error summed over an image, mean over N images: features (N, F) -> scalar."""
        decoded = self.decoder(features).float()
        return F.mse_loss(decoded, patches, reduction="sum") / len(patches)

    @torch.no_grad()
    def predict(self, image: Tensor, action: Tensor, context: int, noise: Tensor) -> Tensor:
        """Predict images open-loop: filter the first `context` steps, then follow the dynamics, given the actions.

        image (T, B, 64, 64, 3) uint8, action (T, B), noise (T, B, S) -> images (T, B, 64, 64, 3) uint8.
        """
        observed = self.observe(self.rssm.initial(action.shape[1]), self.patches(image[:context]),
                                action[:context], noise[:context])
        states = [State(*parts) for parts in zip(*observed.states, strict=True)]
        for step in range(context, len(action)):
            states.append(self.rssm.imagine(states[-1], self.rssm.action_input(action[step]), noise[step]))
        features = torch.stack([state.features for state in states]).flatten(0, 1)
        return to_images(self.decoder(features), self.decoder.stride).view(image.shape)
