"""The policy for one image at a time, in torch or in numpy.

With a small network torch spends most of the time on its calls: the same sums in numpy take a third of it on a CPU.
Both hold the LSTM's memory of an episode, and the weights of its beginning.

Letters: L layers of the LSTM, U its units, A actions, O channels of the last convolution.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol, cast

import numpy as np
import torch
from numpy.lib.stride_tricks import as_strided
from torch import Tensor, nn

from curionav_cli.agents.cbet.network import PolicyNetwork
from curionav_cli.constants import IMAGE_CHANNELS, IMAGE_SIDE

ONE = np.ones(1, np.float32)

Memory = tuple[np.ndarray, np.ndarray]  # hidden and cell, (L, U) each


class Actor(Protocol):
    """The policy in one episode."""

    def step(self, image: np.ndarray) -> np.ndarray:
        """Logits (A,) float32 of the policy for an image (64, 64, 3) uint8; updates the memory."""

    def memory(self) -> Memory:
        """Copy the memory before the next image."""


class TorchActor:
    """Computes in torch, on the device of the network."""

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
    """Computes in numpy, on the CPU; convolutions are products with windows of padded images, channels last.

    inputs: those of the LSTM for each image so far; a third of the images have been there before in their episode.
    """

    def __init__(self, network: PolicyNetwork):
        self.layers, self.image, self.features = convolutions(network)
        dense = cast(Iterable[nn.Linear], network.dense)
        self.dense = [(columns(layer.weight), to_numpy(layer.bias)) for layer in dense]
        self.hidden = np.zeros((network.lstm.num_layers, network.lstm.hidden_size), np.float32)
        self.cell = self.hidden.copy()
        self.cells = [columns(halved(torch.cat([w_in, w_on, (b_in + b_on)[:, None]], dim=1)))
                      for w_in, w_on, b_in, b_on in network.lstm.all_weights]
        [self.policy] = weights([network.policy])
        self.inputs: dict[bytes, np.ndarray] = {}

    @np.errstate(over="ignore", invalid="ignore")
    def step(self, image: np.ndarray) -> np.ndarray:
        key = image.tobytes()
        x = self.inputs.get(key)
        if x is None:
            x = self.inputs[key] = self.encode(image)
        for weight, hidden, cell in zip(self.cells, self.hidden, self.cell, strict=True):
            into, keep, new, out = np.tanh(weight @ np.concatenate([x, hidden, ONE])).reshape(4, -1)
            cell[:] = 0.5 * ((1 + keep) * cell + (1 + into) * new)
            hidden[:] = 0.5 * (1 + out) * np.tanh(cell)
            x = hidden
        weight, bias = self.policy
        return weight @ x + bias

    def encode(self, image: np.ndarray) -> np.ndarray:
        """The LSTM's input for an image: convolutions, then dense layers."""
        np.multiply(image, np.float32(1 / 255), out=self.image)
        for layer in self.layers:
            layer()
        x = self.features.transpose(2, 0, 1).ravel()
        for weight, bias in self.dense:
            x = np.maximum(weight @ x + bias, 0)
        return x

    def memory(self) -> Memory:
        return self.hidden.copy(), self.cell.copy()


class Convolution:
    """A 3 x 3 convolution of stride 2 with ELU, from one fixed buffer to another.

    padded (H + 2, H + 2, C) is read, result (H / 2, H / 2, c) written; weight (c, C, 3, 3), bias (c,).
    A window is 3 x 5 and gives two neighbouring points, where there are as many: half as many windows are copied, which
    takes longer than the products with their zeros.
    """

    def __init__(self, weight: np.ndarray, bias: np.ndarray, padded: np.ndarray, result: np.ndarray):
        outputs, inputs, side = len(weight), weight.shape[1], len(result)
        points = 1 + (side % 2 == 0)
        wide = np.zeros((3, 2 * points + 1, inputs, points, outputs), np.float32)
        for point in range(points):
            wide[:, 2 * point:2 * point + 3, :, point] = weight.transpose(2, 3, 1, 0)
        self.kernel = np.vstack([wide.reshape(-1, points * outputs), np.tile(bias, points)])
        row, column, number = padded.strides
        self.windows = as_strided(padded, (side, side // points, 3, wide[0, ..., 0, 0].size),
                                  (2 * row, 2 * points * column, row, number))
        self.rows = np.ones((side * side // points, len(self.kernel)), np.float32)  # the last column is the bias's
        self.copied = self.rows[:, :-1].reshape(self.windows.shape)
        assert np.shares_memory(self.copied, self.rows)
        self.sums, self.negative, self.zeros = (
            np.zeros((side * side // points, points * outputs), np.float32) for _ in range(3))
        self.result = result

    def __call__(self) -> None:
        self.copied[:] = self.windows
        np.dot(self.rows, self.kernel, out=self.sums)
        np.expm1(np.minimum(self.sums, self.zeros, out=self.negative), out=self.negative)
        np.maximum(self.sums.reshape(self.result.shape), self.negative.reshape(self.result.shape), out=self.result)


def convolutions(network: PolicyNetwork) -> tuple[list[Convolution], np.ndarray, np.ndarray]:
    """The layers in order, the buffer of the image (64, 64, 3), and that of the features (side, side, O)."""
    padded = np.zeros((IMAGE_SIDE + 2, IMAGE_SIDE + 2, IMAGE_CHANNELS), np.float32)
    image = result = padded[1:-1, 1:-1]
    layers = []
    for weight, bias in weights(network.eyes.layers):
        side = (len(result) + 1) // 2
        following = np.zeros((side + 2, side + 2, len(weight)), np.float32)
        result = following[1:-1, 1:-1]
        layers.append(Convolution(weight, bias, padded, result))
        padded = following
    return layers, image, result


def weights(layers: Iterable[nn.Module]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Weight and bias of each layer, as copies."""
    for layer in layers:
        yield to_numpy(cast(Tensor, layer.weight)), to_numpy(cast(Tensor, layer.bias))


def to_numpy(tensor: Tensor) -> np.ndarray:
    """A copy as an array."""
    return tensor.detach().numpy().copy()


def columns(weight: Tensor) -> np.ndarray:
    """A copy in column-major order, in which a product with a vector is a fifth faster."""
    return weight.detach().t().clone(memory_format=torch.contiguous_format).numpy().T


def halved(weight: Tensor) -> Tensor:
    """Halve the weights (4 U, ...) of an LSTM's sigmoid gates: sigmoid(x) = (1 + tanh(x / 2)) / 2, one tanh for all."""
    return (weight.unflatten(0, (4, -1)) * weight.new_tensor([0.5, 0.5, 1, 0.5])[:, None, None]).flatten(0, 1)


def actor(network: PolicyNetwork) -> Actor:
    """Return the faster one for the network's device."""
    return NumpyActor(network) if network.policy.weight.device.type == "cpu" else TorchActor(network)
