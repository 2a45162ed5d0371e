"""Evaluations of trained agents: one row for each, over worlds and seeds."""

from __future__ import annotations

from typing import Any

import numpy as np

from curionav_cli.files import read_json
from curionav_cli.records import Prediction
from curionav_cli.results.runs import Run
from curionav_cli.results.tables import Columns

COLUMNS: Columns = (
    ("env", "env", "{}"), ("agent", "agent", "{}"), ("trained in", "trained_env", "{}"), ("for", "trained_for", "{}"),
    ("training seed", "training_seed", "{}"), ("seed", "seed", "{}"), ("state", "state", "{}"),
    ("steps", "steps", "{:,}"), ("coverage", "coverage", "{:.1%}"), ("area", "area_under_curve", "{:.3f}"),
    ("cancelled", "cancelled", "{:.0%}"), ("docked", "docked", "{}"), ("carried", "carried", "{}"),
    ("surprise", "surprise", "{:.2f}"), ("error", "open_loop", "{:.4f}"), ("repeating", "repeated", "{:.4f}"),
    ("run", "folder", "{}"),
)
BELOW = ("Nothing was learned. surprise: mean KL of posterior from prior in nats. error: mean squared error, pixels in "
         "[0, 1], of images predicted 5 actions ahead without seeing; repeating: of the last image seen")
ACTIONS = 5


def row(run: Run) -> dict[str, Any]:
    """Make the row of an evaluation, with None where the agent predicts nothing or the robot has no dock."""
    fixed = read_json(run.folder.path / "fixed.json")
    trained = fixed["trained"]
    unit, done = next((key, value) for key, value in trained.items() if key != "env")
    return {**run.row(), "trained_env": trained["env"], "trained_for": f"{done} {unit}",
            "training_seed": fixed["training seed"],
            "surprise": surprise(run), "open_loop": mean_of(run, f"open_loop_mse_{ACTIONS}"),
            "repeated": mean_of(run, f"repeat_mse_{ACTIONS}")}


def surprise(run: Run) -> float | None:
    """Mean KL in nats over the frames of all episodes that the agent filtered; None for an agent without a model."""
    kl = [Prediction.load_surprise(path).kl for path in run.predictions.values()]
    return float(np.mean(np.concatenate(kl), dtype=np.float64)) if kl else None


def mean_of(run: Run, key: str) -> float | None:
    """Mean of a metric over the episodes that have it."""
    values = [line[key] for line in run.folder.metrics() if key in line]
    return sum(values) / len(values) if values else None
