"""logger=tensorboard: its events hold what metrics.jsonl holds, each value once, also after an interruption."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from curionav_cli.app import main
from curionav_cli.storage.loggers import LOGGERS, TensorBoard
from curionav_cli.storage.run_folder import RunFolder

pytest.importorskip("tensorboard", reason="needs the extra tensorboard")

ROWS = [{"episode": n, "steps": 40 * (n + 1), "coverage": 0.125 * (n + 1), "loss": [3.5, math.nan, -1.25][n],
         "docked": n == 1, "question": "which?"} for n in range(3)]


def events(run: RunFolder) -> dict[str, list[tuple[int, float]]]:
    """(step, value) of every scalar, in the order written, as TensorBoard itself reads them."""
    from tensorboard.backend.event_processing.event_file_loader import EventFileLoader

    found: dict[str, list[tuple[int, float]]] = {}
    for path in sorted((run.path / "tensorboard").iterdir()):
        for event in EventFileLoader(str(path)).Load():
            for value in event.summary.value:
                if value.tag.startswith("figures/"):
                    continue
                found.setdefault(value.tag, []).append((event.step, value.tensor.float_val[0]))
    return found


def figures(run: RunFolder) -> set[str]:
    """The tags of the images that TensorBoard's own reader finds."""
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    reader = EventAccumulator(str(run.path / "tensorboard"), size_guidance={"images": 0})
    reader.Reload()
    return set(reader.Tags()["images"])


def log(run: RunFolder, rows: list[dict]) -> None:
    logger = LOGGERS["tensorboard"](run)
    for row in rows:
        run.append_metrics(row)
        logger.add(row)
    logger.close()


def test_every_number_of_every_row_once_at_its_step(tmp_path: Path) -> None:
    run = RunFolder(tmp_path)
    log(run, ROWS[:2])
    log(run, ROWS[2:])  # the run went on, in another process
    seen = events(run)
    assert seen["coverage"] == [(40, 0.125), (80, 0.25), (120, 0.375)]
    assert seen["loss"] == [(40, 3.5), (120, -1.25)], "what is not finite is left out"
    assert seen["docked"] == [(40, 0.0), (80, 1.0), (120, 0.0)]
    assert "question" not in seen


def test_a_rewound_run_has_no_later_events(tmp_path: Path) -> None:
    run = RunFolder(tmp_path)
    log(run, ROWS)
    run.write_metrics(ROWS[:1])
    TensorBoard(run).close()
    assert events(run)["coverage"] == [(40, 0.125)]


def test_the_command_logs_its_episodes(tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    words = ["explore", "agent=random", "loop.steps=5", "loop.episodes=2", "logger=tensorboard",
             f"hydra.run.dir={run.path}"]
    with pytest.raises(SystemExit, match="0"):
        main(words)
    assert events(run)["coverage"] == [(row["steps"], pytest.approx(row["coverage"])) for row in run.metrics()]
    assert figures(run) == {"figures/heatmap", "figures/coverage"}


def test_training_counts_its_iterations(tmp_path: Path) -> None:
    run = RunFolder(tmp_path)
    log(run, [{"iterations": 100, "loss": 0.5}])
    assert events(run)["loss"] == [(100, 0.5)]


def test_local_is_metrics_jsonl_alone(tmp_path: Path) -> None:
    run = RunFolder(tmp_path)
    logger = LOGGERS["local"](run)
    logger.add(ROWS[0])
    logger.close()
    assert not list(tmp_path.iterdir())
    run.append_metrics(ROWS[0])
    assert json.loads(run.metrics_file.read_text()) == ROWS[0]
