"""The policy for one picture after another, in torch or in numpy.

A small network costs torch mostly its calls: the same sums in numpy take a third of the time on a CPU. Both hold the
memory of an episode, and the weights as they were when it began.

Letters: L layers of the LSTM, U its units, A actions.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, cast

import numpy as np
import torch
from numpy.lib.stride_tricks import as_strided
from torch import Tensor, nn

from curionav_cli.agents.cbet.network import SIDE, PolicyNetwork

Memory = tuple[np.ndarray, np.ndarray]  # hidden and cell, (L, U) each


class Actor(Protocol):
    """One episode of acting."""

    def step(self, image: np.ndarray) -> np.ndarray:
        """(64, 64, 3) uint8 -> logits (A,) float32."""

    def memory(self) -> Memory:
        """What it remembers before the next picture, copied."""


class TorchActor:
    """On the device of the network."""

    def __init__(self, network: PolicyNetwork):
        self.network, self.state = network, network.initial(1)

    @torch.inference_mode()
    def step(self, image: np.ndarray) -> np.ndarray:
        logits, self.state = self.network.step(torch.from_numpy(image).to(self.state.hidden.device)[None], self.state)
        return logits[0].numpy(force=True)

    def memory(self) -> Memory:
        hidden, cell = (part[:, 0].numpy(force=True).copy() for part in self.state)
        return hidden, cell


class NumpyActor:
    """On the CPU. Convolutions are products with strided windows of padded pictures, channels last."""

    def __init__(self, network: PolicyNetwork):
        self.kernels, self.padded, self.windows, side = [], [], [], SIDE
        for weight, bias in weights(network.eyes.layers):
            inputs = weight.shape[1]
            self.kernels.append((weight.transpose(2, 3, 1, 0).reshape(-1, len(weight)).copy(), bias))
            self.padded.append(np.zeros((side + 2, side + 2, inputs), np.float32))
            side, (row, column, _) = (side + 1) // 2, self.padded[-1].strides
            self.windows.append(as_strided(self.padded[-1], (side, side, 3, 3 * inputs),
                                           (2 * row, 2 * column, row, self.padded[-1].itemsize)))
        self.dense = list(weights(network.dense))
        self.cells = [(plain(torch.cat([w_in, w_on], dim=1)), plain(b_in + b_on))
                      for w_in, w_on, b_in, b_on in network.lstm.all_weights]
        [self.policy] = weights([network.policy])
        self.hidden = np.zeros((len(self.cells), network.lstm.hidden_size), np.float32)
        self.cell = self.hidden.copy()

    @np.errstate(over="ignore", invalid="ignore")
    def step(self, image: np.ndarray) -> np.ndarray:
        x = self.see(image)
        for weight, bias in self.dense:
            x = np.maximum(weight @ x + bias, 0)
        for layer, (weight, bias) in enumerate(self.cells):
            gates = weight @ np.concatenate([x, self.hidden[layer]]) + bias
            into, keep, new, out = gates.reshape(4, -1)
            self.cell[layer] = sigmoid(keep) * self.cell[layer] + sigmoid(into) * np.tanh(new)
            x = self.hidden[layer] = sigmoid(out) * np.tanh(self.cell[layer])
        weight, bias = self.policy
        return weight @ x + bias

    def see(self, image: np.ndarray) -> np.ndarray:
        """The features of the convolutions, in the network's order."""
        x = image * np.float32(1 / 255)
        for (weight, bias), padded, windows in zip(self.kernels, self.padded, self.windows, strict=True):
            padded[1:len(x) + 1, 1:len(x) + 1] = x
            side = len(windows)
            y = windows.reshape(side * side, -1) @ weight + bias
            x = np.maximum(y, np.expm1(np.minimum(y, 0))).reshape(side, side, -1)  # ELU: expm1(y) >= y
        return x.transpose(2, 0, 1).ravel()

    def memory(self) -> Memory:
        return self.hidden.copy(), self.cell.copy()


def weights(layers: Iterable[nn.Module]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Weight and bias of each."""
    for layer in layers:
        yield plain(cast(Tensor, layer.weight)), plain(cast(Tensor, layer.bias))


def plain(tensor: Tensor) -> np.ndarray:
    return tensor.detach().numpy().copy()


def sigmoid(x: np.ndarray) -> np.ndarray:
    return 0.5 + 0.5 * np.tanh(0.5 * x)


def actor(network: PolicyNetwork) -> Actor:
    """The faster one for where the network is."""
    return NumpyActor(network) if network.policy.weight.device.type == "cpu" else TorchActor(network)
