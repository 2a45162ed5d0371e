"""A learner small enough for a test, as overrides for the command line."""

from __future__ import annotations

from pathlib import Path

LEARNER = (
    "env=small_room", "agent=lbs_dreamer", "device=cpu", "loop.steps=12", "loop.iterations=4", "loop.episodes=4",
    "agent.batch_size=3", "agent.sequence_length=8", "agent.gru_units=16", "agent.rssm_hidden=16",
    "agent.mlp_units=16", "agent.mlp_layers=1", "agent.latent_dimension=4", "agent.latent_classes=4",
    "agent.horizon=4", "agent.imagination_starts=12", "agent.action_repeat=1",
)


def at_storage(storage: str, folder: Path | str, *more: str) -> list[str]:
    """The same with a storage, in a run folder; later words replace earlier ones."""
    given = {word.partition("=")[0]: word for word in (*LEARNER, f"storage={storage}", "remote.poll=0.05",
                                                       f"hydra.run.dir={folder}", *more)}
    return list(given.values())
