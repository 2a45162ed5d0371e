"""What the agent is, as files: safetensors and JSON, nothing pickled.

    weights.safetensors     all networks and the running size of rewards
    training.safetensors    RMSprop's moments as 'optimiser/parameter/moment'
    memory.safetensors      count tables as 'counts/name/table/...', the cells each environment has seen, and the
                            unrolls that wait for an update as 'waiting/...'
    memory.json             updates, the states of the random streams of count resets, what projections are
                            drawn from, and what the alarm has counted
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import torch

from curionav_cli.agents.cbet.learner import Learner
from curionav_cli.agents.cbet.unrolls import Unroll
from curionav_cli.agents.weights import below, load_weights, prefixed, read_tensors, save_weights, write_tensors
from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_json, write_whole

TRAINING, MEMORY, NUMBERS = "training.safetensors", "memory.safetensors", "memory.json"
Waiting = list[Unroll]


def save_learner(learner: Learner, folder: Path) -> None:
    """Networks and optimisers, into an existing folder."""
    save_weights(learner.networks, folder)
    training: dict[str, torch.Tensor] = {}
    for name, optimiser in learner.optimisers.items():
        training |= prefixed(name, optimiser.state())
    write_tensors(folder / TRAINING, training)


def load_learner(learner: Learner, folder: Path) -> None:
    """Raises RunFolderError where a file is missing or broken, or the weights are another network's."""
    load_weights(learner.networks, folder)
    training = read_tensors(folder / TRAINING)
    for name, optimiser in learner.optimisers.items():
        optimiser.load_state(below(name, training))


def save_memory(learner: Learner, waiting: Waiting, seen: np.ndarray, folder: Path) -> None:
    """Tables, streams, what waits. seen: (E, cells) bool."""
    reward = learner.reward
    arrays = {"seen": seen}
    for name, counts in reward.counts.items():
        arrays |= {f"counts/{name}/{path}": array for path, array in counts.state().items()}
    for field, parts in zip(Unroll._fields, zip(*waiting, strict=True)):
        arrays[f"waiting/{field}"] = np.stack(parts)
    write_tensors(folder / MEMORY, {name: torch.from_numpy(array) for name, array in arrays.items()})
    dice = [stream.bit_generator.state for stream in reward.generators]
    numbers = {"updates": learner.updates, "numbers": reward.numbers, "dice": dice,
               "alarm": reward.alarm.state()}
    write_whole(folder / NUMBERS, lambda file: file.write(json.dumps(numbers).encode()))


def load_memory(learner: Learner, folder: Path) -> tuple[Waiting, np.ndarray]:
    """What `save_memory` wrote; the unrolls that wait, and the cells seen. Raises RunFolderError."""
    tensors, numbers = read_tensors(folder / MEMORY), read_json(folder / NUMBERS)
    if numbers["numbers"] != learner.reward.numbers:
        raise RunFolderError(f"{folder / NUMBERS} was written by a run of another seed, whose keys are others. "
                             "Use the seed of that run.")
    learner.updates = numbers["updates"]
    learner.reward.alarm.load_state(numbers.get("alarm", learner.reward.alarm.state()))  # older ones have none
    for stream, state in zip(learner.reward.generators, numbers["dice"], strict=True):
        stream.bit_generator.state = state
    for name, counts in learner.reward.counts.items():
        counts.load_state({path: tensor.numpy() for path, tensor in below(f"counts/{name}", tensors).items()})
    parts = below("waiting", tensors)
    waiting = [Unroll(*row) for row in zip(*(parts[field].numpy() for field in Unroll._fields), strict=True)] \
        if parts else []
    return waiting, tensors["seen"].numpy()
