"""The policy of C-BET: five convolutions, dense layers, an LSTM, and linear heads for policy and value.

Letters: T steps, B unrolls, L layers of the LSTM, U its units, F features of the convolutions, A actions,
D distinct images of a batch.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple, cast

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.cbet import settings as cbet_settings
from curionav_cli.agents.elu import elu
from curionav_cli.constants import ACTIONS, IMAGE_CHANNELS, IMAGE_SIDE


class Memory(NamedTuple):
    """The LSTM's state, (L, B, U) each."""

    hidden: Tensor
    cell: Tensor


class ImageEncoder(nn.Module):
    """3 x 3 convolutions of stride 2 with ELU: images (..., 64, 64, 3) uint8 -> features (N, F) of N images."""

    def __init__(self, channels: list[int]):
        super().__init__()
        self.layers = nn.ModuleList(nn.Conv2d(i, o, 3, 2, 1) for i, o in pairwise([IMAGE_CHANNELS, *channels]))
        side = IMAGE_SIDE
        for _ in channels:
            side = (side + 1) // 2
        self.features = side * side * channels[-1]

    def forward(self, image: Tensor) -> Tensor:
        x = image.flatten(0, -4).permute(0, 3, 1, 2).float().mul_(1 / 255)
        for layer in self.layers:
            x = elu(layer(x))
        return x.flatten(1)


class PolicyNetwork(nn.Module):
    """The policy and the value of one image and the LSTM's memory; no last action, no reward, no pose."""

    def __init__(self, hyper: cbet_settings.CBET):
        super().__init__()
        self.eyes = ImageEncoder(hyper.conv_channels)
        sizes = [self.eyes.features, *hyper.dense_units]
        self.dense = nn.ModuleList(nn.Linear(i, o) for i, o in pairwise(sizes))
        self.lstm = nn.LSTM(sizes[-1], hyper.lstm_units, hyper.lstm_layers)
        self.policy = nn.Linear(hyper.lstm_units, len(ACTIONS))
        self.value = nn.Linear(hyper.lstm_units, 1)

    def initial(self, batch: int) -> Memory:
        """The memory before an episode: zeros, on the device of the weights."""
        shape = (self.lstm.num_layers, batch, self.lstm.hidden_size)
        return Memory(*(self.policy.weight.new_zeros(shape) for _ in range(2)))

    def step(self, image: Tensor, memory: Memory) -> tuple[Tensor, Memory]:
        """One step: images (B, 64, 64, 3) uint8 -> logits (B, A), and the memory after it."""
        output, memory = self._cells(self._encode(image), memory)
        return self.policy(output), memory

    def unroll(self, image: Tensor, frame: Tensor, memory: Memory, respawned: Tensor) -> tuple[Tensor, Tensor]:
        """T steps and the frame after them, of images (D, 64, 64, 3) uint8: logits (T, B, A), value (T + 1, B).

        frame: the image of each frame (T + 1, B).
        memory: before the first frame. respawned (B,) bool: the last frame begins an episode, so that the
        memory is zero before it; otherwise only the first frame of an unroll can.
        """
        inputs = F.embedding(frame, self._encode(image))
        output, state = self.lstm(inputs[:-1], tuple(memory))
        kept = ~respawned[None, :, None]
        last, _ = self._cells(inputs[-1], Memory(*(part * kept for part in state)))
        return self.policy(output), self.value(torch.cat([output, last[None]])).squeeze(-1)

    def _encode(self, image: Tensor) -> Tensor:
        x = self.eyes(image)
        for layer in self.dense:
            x = F.relu(layer(x))
        return x

    def _cells(self, x: Tensor, memory: Memory) -> tuple[Tensor, Memory]:
        """The LSTM for one step, layer by layer: (B, inputs) -> (B, U)."""
        hidden, cell = [], []
        for layer, state in enumerate(zip(*memory, strict=True)):
            x, c = torch.lstm_cell(x, state, *self.lstm.all_weights[layer])
            hidden.append(x)
            cell.append(c)
        return x, Memory(torch.stack(hidden), torch.stack(cell))


def initialise(module: nn.Module, generator: torch.Generator) -> None:
    """Draw orthogonal weights of gain sqrt 2 (heads: 1), zero biases; the LSTM uniform in +-1 / sqrt U, as torch."""
    for name, part in module.named_modules():
        if isinstance(part, (nn.Linear, nn.Conv2d)):
            nn.init.orthogonal_(part.weight, 1.0 if name in ("policy", "value") else 2**0.5, generator=generator)
            nn.init.zeros_(cast(Tensor, part.bias))
        elif isinstance(part, nn.LSTM):
            for weight in part.parameters():
                nn.init.uniform_(weight, -part.hidden_size**-0.5, part.hidden_size**-0.5, generator=generator)
