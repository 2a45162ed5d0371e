"""What the agent is, as files: safetensors and JSON, nothing pickled.

    weights.safetensors     all networks, slow critic and reward normaliser included
    training.safetensors    Adam's moments as 'optimiser/parameter/moment', the generator as 'generator'
    training.json           counters, and the device that the generator belongs to
"""

from __future__ import annotations

import json
from pathlib import Path

from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor

from curionav_cli.agents.lbs_dreamer.learner import Learner, Networks
from curionav_cli.errors import RunFolderError
from curionav_cli.records import write_whole

WEIGHTS, TRAINING, COUNTERS = "weights.safetensors", "training.safetensors", "training.json"


def save_learner(learner: Learner, folder: Path) -> None:
    """Write the three files into an existing folder."""
    training = {
        f"{name}/{path}": tensor
        for name, optimiser in learner.optimisers.items() for path, tensor in optimiser.state().items()
    }
    training["generator"] = learner.generator.get_state()
    counters = {
        "updates": learner.updates, "behaviour_updates": learner.behaviour_updates,
        "device": learner.device.type,
    }
    _write(folder / WEIGHTS, save(_plain(learner.networks.state_dict())))
    _write(folder / TRAINING, save(_plain(training)))
    _write(folder / COUNTERS, json.dumps(counters).encode())


def load_learner(learner: Learner, folder: Path) -> None:
    """Become what was saved. On another kind of device the generator is seeded anew from the counters.

    Raises RunFolderError where a file is missing or broken, or the weights are another network's.
    """
    load_weights(learner.networks, folder)
    training = _read(folder / TRAINING)
    try:
        counters = json.loads((folder / COUNTERS).read_text())
    except (OSError, ValueError) as error:
        raise RunFolderError(f"{folder / COUNTERS} cannot be read ({error}).") from error
    generator = training.pop("generator")
    for name, optimiser in learner.optimisers.items():
        prefix = f"{name}/"
        optimiser.load_state({path.removeprefix(prefix): tensor.to(learner.device)
                              for path, tensor in training.items() if path.startswith(prefix)})
    learner.updates, learner.behaviour_updates = counters["updates"], counters["behaviour_updates"]
    if counters["device"] == learner.device.type:
        learner.generator.set_state(generator)
    else:
        learner.generator.manual_seed(learner.updates)


def load_weights(networks: Networks, folder: Path) -> None:
    """The weights alone, for acting. Raises RunFolderError as `load_learner` does."""
    weights, own = _read(folder / WEIGHTS), networks.state_dict()
    for name in sorted(own.keys() | weights.keys()):
        there, here = (tuple(side[name].shape) if name in side else None for side in (weights, own))
        if there != here:
            raise RunFolderError(
                f"{folder / WEIGHTS} does not fit this agent: {name} is {there or 'absent'} there and "
                f"{here or 'absent'} here. Use the settings (scale=..., agent....) that it was trained with.")
    networks.load_state_dict(weights)


def _plain(tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()}


def _read(path: Path) -> dict[str, Tensor]:
    try:
        return load(path.read_bytes())
    except (OSError, SafetensorError) as error:
        raise RunFolderError(f"{path} cannot be read ({error}).") from error


def _write(path: Path, content: bytes) -> None:
    write_whole(path, lambda file: file.write(content))
