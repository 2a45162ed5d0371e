"""The agent's checkpoint: safetensors and JSON, nothing pickled.

    weights.safetensors     all networks and the running size of rewards
    training.safetensors    RMSprop's moments as 'optimiser/parameter/moment'
    memory.safetensors      count tables as 'counts/name/table/...' (but those that last: count_log.py), the cells
                            visited in each environment as 'seen', and the unrolls that wait for an update as
                            'waiting/...'
    memory.json             updates; 'dice': states of the generators that clear tables; 'numbers': seed of the
                            projections; 'alarm': state of the reward monitor; 'log': of count_log.py
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import torch

from curionav_cli.agents.cbet.count_log import NAME as LOG
from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.learner import Learner
from curionav_cli.agents.cbet.unrolls import Unroll
from curionav_cli.agents.weights import below, load_weights, prefixed, read_tensors, save_weights, write_tensors
from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_json, write_whole

TRAINING, MEMORY, NUMBERS = "training.safetensors", "memory.safetensors", "memory.json"
Waiting = list[Unroll]


def save_learner(learner: Learner, folder: Path) -> None:
    """Write networks and optimisers into an existing folder."""
    save_weights(learner.networks, folder)
    training: dict[str, torch.Tensor] = {}
    for name, optimiser in learner.optimisers.items():
        training |= prefixed(name, optimiser.state())
    write_tensors(folder / TRAINING, training)


def load_learner(learner: Learner, folder: Path) -> None:
    """Restore networks and optimisers. Raises RunFolderError where a file is missing, broken or another network's."""
    load_weights(learner.networks, folder)
    training = read_tensors(folder / TRAINING)
    for name, optimiser in learner.optimisers.items():
        optimiser.load_state(below(name, training))


def save_memory(learner: Learner, waiting: Waiting, visited: np.ndarray, folder: Path) -> None:
    """Write count tables, generators, and the unrolls that wait; visited (E, cells) bool."""
    reward = learner.reward
    arrays = {"seen": visited}
    for name, counts in passing(reward.counts).items():
        arrays |= {f"counts/{name}/{path}": array for path, array in counts.state().items()}
    for field, parts in zip(Unroll._fields, zip(*waiting, strict=True)):
        arrays[f"waiting/{field}"] = np.stack(parts)
    write_tensors(folder / MEMORY, {name: torch.from_numpy(array) for name, array in arrays.items()})
    states = [generator.bit_generator.state for generator in reward.generators]
    numbers = {"updates": learner.updates, "numbers": reward.seed, "dice": states, "alarm": reward.monitor.state()}
    if held := lasting(reward.counts):
        numbers["log"] = learner.count_log.append(folder.resolve().parent / LOG, held)
    write_whole(folder / NUMBERS, lambda file: file.write(json.dumps(numbers).encode()))


def load_memory(learner: Learner, folder: Path) -> tuple[Waiting, np.ndarray]:
    """Restore what `save_memory` wrote; returns the unrolls that wait, and the cells visited.

    Raises RunFolderError where a file is missing or broken, or of a run with another seed.
    """
    tensors, numbers = read_tensors(folder / MEMORY), read_json(folder / NUMBERS)
    if numbers["numbers"] != learner.reward.seed:
        raise RunFolderError(f"{folder / NUMBERS} was written by a run of another seed, whose keys differ. "
                             "Use the seed of that run.")
    learner.updates = numbers["updates"]
    learner.reward.monitor.load_state(numbers.get("alarm", learner.reward.monitor.state()))  # older ones have none
    for generator, state in zip(learner.reward.generators, numbers["dice"], strict=True):
        generator.bit_generator.state = state
    held = lasting(learner.reward.counts) if "log" in numbers else {}  # older checkpoints hold all tables
    if held:
        learner.count_log.read(folder.resolve().parent / LOG, numbers["log"], held)
    for name, counts in learner.reward.counts.items() if not held else passing(learner.reward.counts).items():
        counts.load_state({path: tensor.numpy() for path, tensor in below(f"counts/{name}", tensors).items()})
    parts = below("waiting", tensors)
    waiting = [Unroll(*row) for row in zip(*(parts[field].numpy() for field in Unroll._fields), strict=True)] \
        if parts else []
    return waiting, tensors["seen"].numpy()


def lasting(counts: dict[str, Counts]) -> dict[str, Counts]:
    """The tables that stand in the file beside the checkpoints."""
    return {name: one for name, one in counts.items() if one.lasting}


def passing(counts: dict[str, Counts]) -> dict[str, Counts]:
    """The tables that stand in each checkpoint."""
    return {name: one for name, one in counts.items() if not one.lasting}
