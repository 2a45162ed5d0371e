"""The world model and its loss, equation (1) of the paper: surprise of the latents plus reconstruction."""

from __future__ import annotations

from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.networks import Decoder, Encoder, to_images, to_patches
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, Observed, State


class Sequences(NamedTuple):
    """B windows of T steps from the replay, time first, on the device."""

    image: Tensor  # (T, B, 64, 64, 3) uint8
    action: Tensor  # (T, B) int64, the action that led to the step, -1 for none
    is_start: Tensor  # (B,) bool, the window begins where an episode does
    noted: Tensor | None = None  # (T, B) what the agent noted of each step, for curiosities that ask for it


def choose(total: int, count: int, noise: Tensor) -> Tensor | slice:
    """`count` of `total` indices without replacement, by the order of `noise` (total,)."""
    return slice(None) if count == total else noise.argsort()[:count]


class WorldModel(nn.Module):
    """Encoder, RSSM and decoder."""

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
        """(..., 64, 64, 3) uint8 -> (N, G, G, P), as the encoder reads and the decoder writes it."""
        return to_patches(image, self.encoder.stride)

    def observe(self, state: State, patches: Tensor, action: Tensor, noise: Tensor) -> Observed:
        """Filter T steps: patches (T * B, G, G, P), action (T, B), noise (T, B, S)."""
        return self.rssm.observe(state, self.encoder(patches).unflatten(0, action.shape), action, noise)

    def loss(self, data: Sequences, noise: Tensor, frame_noise: Tensor
             ) -> tuple[Tensor, Observed, dict[str, Tensor]]:
        """Equation (1) on a batch: KL with balancing and free nats, minus log p(x | s).

        noise (T, B, S) draws the latents; frame_noise (T * B,) chooses the frames to be decoded.
        Returns the scalar loss, what was filtered (with gradients) and metrics.
        """
        patches = self.patches(data.image)
        state = self.rssm.initial(data.action.shape[1])
        seen = self.observe(state, patches, data.action, noise)
        chosen = choose(len(patches), min(self.decoded, len(patches)), frame_noise)
        error = self.image_error(seen.states.features.flatten(0, 1)[chosen], patches[chosen])
        divergence = latent.balanced_kl(seen.posterior, seen.prior, self.balance, self.free_nats)
        loss = divergence + error / 2  # the constant of the normal distribution is left out
        metrics = {
            "model_loss": loss, "image_loss": error / 2, "image_mse": error / patches[0].numel(),
            "prior_entropy": latent.entropy(seen.prior.detach()).sum(-1).mean(),
            "posterior_entropy": latent.entropy(seen.posterior.detach()).sum(-1).mean(),
        }
        return loss, seen, metrics

    def image_error(self, features: Tensor, patches: Tensor) -> Tensor:
        """Squared error summed over an image, mean over N images: features (N, F) -> scalar."""
        decoded = self.decoder(features).float()
        return F.mse_loss(decoded, patches, reduction="sum") / len(patches)

    @torch.no_grad()
    def predict(self, image: Tensor, action: Tensor, context: int, noise: Tensor) -> Tensor:
        """Open loop: see the first `context` steps, then only the actions.

        image (T, B, 64, 64, 3) uint8, action (T, B), noise (T, B, S) -> images (T, B, 64, 64, 3) uint8.
        """
        seen = self.observe(self.rssm.initial(action.shape[1]), self.patches(image[:context]),
                            action[:context], noise[:context])
        states = [State(*parts) for parts in zip(*seen.states, strict=True)]
        for step in range(context, len(action)):
            states.append(self.rssm.imagine(states[-1], self.rssm.action_input(action[step]), noise[step]))
        features = torch.stack([state.features for state in states]).flatten(0, 1)
        return to_images(self.decoder(features), self.decoder.stride).view(image.shape)
