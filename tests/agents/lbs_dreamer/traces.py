"""What tests compare of agents: everything that is saved, and the actions of an episode."""

import hashlib
import json


def ignore(done):
    """For `tick`."""


def fingerprint(agent):
    """Everything that is saved, as one hash."""
    digest = hashlib.sha256()
    for name, tensor in sorted(agent.learner.networks.state_dict().items()):
        digest.update(name.encode() + tensor.numpy().tobytes())
    for name, optimiser in agent.learner.optimisers.items():
        for path, tensor in sorted(optimiser.state().items()):
            digest.update(f"{name}/{path}".encode() + tensor.numpy().tobytes())
    digest.update(agent.learner.generator.get_state().numpy().tobytes())
    digest.update(json.dumps(agent.rng.bit_generator.state).encode())
    digest.update(f"{agent.learner.updates} {agent.learner.behaviour_updates}".encode())
    return digest.hexdigest()


def walk(agent, episode):
    """The actions on the images of an episode."""
    agent.begin()
    return [agent.act({"image": image}, {"episode_index": 0}) for image in episode.image]
