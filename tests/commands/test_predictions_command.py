"""curionav coverage draws what a run predicted, alone and over seeds; a run without predictions is no error."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from entry import Cli
from tiny import LEARNER

from curionav_cli.errors import SoundnessWarning
from curionav_cli.results.prediction.stored_predictions import errors
from curionav_cli.results.runs import Run

FIGURES = ("predictions.png", "prediction_error.png")


@pytest.mark.slow
@pytest.mark.usefixtures("painted")
def test_a_learner_s_runs_are_drawn_alone_and_over_seeds(cli: Cli, tmp_path: Path) -> None:
    for seed in (0, 1):
        words = [word for word in LEARNER if not word.startswith("loop.episodes")]
        answer = cli("explore", *words, "loop.episodes=2", f"seed={seed}", f"hydra.run.dir=runs/{seed}")
        assert answer.code == 0 and "figures/predictions.png" in answer.out, answer.error
        for name in FIGURES:
            (tmp_path / "runs" / str(seed) / "figures" / name).unlink()
    answer = cli("coverage", "runs", "marking=landing", "denominator=visitable")
    assert answer.code == 0, answer.error
    for seed in (0, 1):
        run = Run.open(tmp_path / "runs" / str(seed))
        found = errors(run)
        line = next(line for line in answer.out.splitlines() if f"seed {seed}: open-loop error" in line)
        assert found and f"after 1, 5 steps {found.after(1)[0]:.4f}, {found.after(5)[0]:.4f}" in line
        assert found.after(5)[0] == pytest.approx(np.mean([row["open_loop_mse_5"] for row in run.folder.metrics()]))
        assert all((run.folder.figures / name).stat().st_size > 3000 for name in FIGURES)
    over_seeds = "runs/figures/prediction_error_small_room_lbs_dreamer.png"
    assert over_seeds in answer.out and (tmp_path / over_seeds).stat().st_size > 3000


def test_a_broken_prediction_is_named_and_nothing_hangs_on_it(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *LEARNER, "hydra.run.dir=run").code == 0
    (tmp_path / "run" / "predictions" / "000001.npz").write_bytes(b"PK")
    with pytest.warns(SoundnessWarning, match="predictions/000001.npz is not whole .* Left out"):
        answer = cli("coverage", "run", "marking=landing", "denominator=visitable")
    assert answer.code == 0 and "over the newest 3 episodes" in answer.out, answer.error
    with pytest.warns(SoundnessWarning, match="000001.npz"):
        assert cli("resume", "run", "loop.episodes=5").code == 0


@pytest.mark.usefixtures("painted")
@pytest.mark.slow  # six runs
def test_environments_stand_under_each_other_in_one_figure(cli: Cli, tmp_path: Path) -> None:
    short = [word for word in LEARNER if not word.startswith(("loop.episodes", "loop.iterations"))]
    for env in ("small_room", "large_lab"):
        assert cli("explore", *short, f"env={env}", "loop.episodes=1", "loop.iterations=0",
                   f"hydra.run.dir=runs/{env}").code == 0
    assert cli("explore", "env=apartment_0", "agent=bounce", "loop.steps=10", "loop.episodes=1",
               "hydra.run.dir=runs/bounce").code == 0
    answer = cli("coverage", "runs", "marking=landing", "denominator=visitable", "out=out")
    assert answer.code == 0 and "out/predictions.png" in answer.out, answer.error
    both = strip_rows(tmp_path / "out" / "predictions.png")
    assert both == 2 and strip_rows(tmp_path / "out" / "small_room" / "predictions.png") == 1


def strip_rows(path: Path) -> int:
    """How many rows of pictures, real above predicted, a figure has: its height less the margins."""
    high = cv2.imread(str(path)).shape[0]
    return round((high - 84 - 30 + 2 * 14) / (2 * (2 * 64 + 4 + 14)))


def test_an_agent_that_predicts_nothing_is_no_error(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", "agent=bounce", "loop.steps=10", "loop.episodes=1", "hydra.run.dir=run").code == 0
    answer = cli("coverage", "run")
    assert answer.code == 0 and "open-loop" not in answer.out and "predictions" not in answer.out
    assert not (tmp_path / "run" / "predictions").exists()


def test_runs_with_other_settings_are_no_seeds_of_each_other(cli: Cli, tmp_path: Path) -> None:
    short = [word for word in LEARNER if not word.startswith(("loop.episodes", "loop.iterations"))]
    for name, entropy in (("0", 0.6), ("1", 0.3)):
        assert cli("explore", *short, "loop.episodes=1", "loop.iterations=0", f"agent.entropy={entropy}",
                   f"hydra.run.dir=runs/{name}").code == 0
    answer = cli("coverage", "runs", "marking=landing", "denominator=visitable")
    assert answer.code == 0 and "lbs_dreamer entropy=0.3, seed 0: open-loop" in answer.out
    assert not (tmp_path / "runs" / "figures").exists()
