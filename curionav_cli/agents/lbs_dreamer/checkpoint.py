"""The learner's checkpoint: safetensors and JSON, nothing pickled.

    weights.safetensors     all networks, with slow critic and reward normaliser
    training.safetensors    Adam's moments as 'optimiser/parameter/moment', the generator as 'generator'
    training.json           counters, and the kind of device that the generator belongs to
"""

from __future__ import annotations

import json
from pathlib import Path

from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.weights import below, load_weights, prefixed, read_tensors, save_weights, write_tensors
from curionav_cli.files import read_json, write_whole

TRAINING, COUNTERS = "training.safetensors", "training.json"


def save_learner(learner: Learner, folder: Path) -> None:
    """Write the three files into an existing folder."""
    training = {"generator": learner.generator.get_state()}
    for name, optimiser in learner.optimisers.items():
        training |= prefixed(name, optimiser.state())
    counters = {
        "updates": learner.updates, "behaviour_updates": learner.behaviour_updates,
        "device": learner.device.type,
    }
    save_weights(learner.networks, folder)
    write_tensors(folder / TRAINING, training)
    write_whole(folder / COUNTERS, lambda file: file.write(json.dumps(counters).encode()))


def load_learner(learner: Learner, folder: Path) -> None:
    """Restore what `save_learner` wrote. On another kind of device the generator is seeded anew from the counters.

    Raises RunFolderError where a file is missing or broken, or the weights are another network's.
    """
    load_weights(learner.networks, folder)
    training, counters = read_tensors(folder / TRAINING), read_json(folder / COUNTERS)
    for name, optimiser in learner.optimisers.items():
        optimiser.load_state(below(name, training))
    learner.updates, learner.behaviour_updates = counters["updates"], counters["behaviour_updates"]
    if counters["device"] == learner.device.type:
        learner.generator.set_state(training["generator"])
    else:
        learner.generator.manual_seed(learner.updates)
