"""Made-up runs of any length, as figures and verdicts read them."""

from pathlib import Path

import numpy as np

from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.coverage import Curve


def a_summary(env="apartment_0", agent="lbs_dreamer", seed=0, steps=2_000_000, found=(0, 5), changes=True, cells=10,
              folder=None, **arm):
    budget = {"cpu_seconds": np.array([0.0, 7200.0])}
    return RunSummary(folder or Path(f"{env}_{agent}_{seed}_{steps}"), {"name": env, "changes": changes}, agent, seed,
                      "cpu", arm, {"env.changes": changes}, Curve(np.array(found), steps, cells), np.array([0, steps]),
                      budget, "done", "", True, ())
