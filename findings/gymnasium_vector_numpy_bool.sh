#!/usr/bin/env bash
# Guess: a numpy bool in info becomes an array of bools in SyncVectorEnv, as Python's bool and numpy's numbers do.
# What happens: it becomes an array of objects, so that ~info["hit"] is no mask; an array of no dimension is batched well.
# gymnasium 1.4.0 (numpy 2.4.6), 2026-11-29.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check gymnasium==1.4.0 numpy==2.4.6
venv/bin/python - <<'PYTHON'
from importlib.metadata import version

import gymnasium
import numpy as np
from gymnasium.vector import SyncVectorEnv


class Told(gymnasium.Env):
    """Says the same in info in four types."""

    observation_space = gymnasium.spaces.Box(0.0, 1.0, (1,), np.float32)
    action_space = gymnasium.spaces.Discrete(2)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        said = {"bool": True, "np.bool_": np.bool_(True), "array": np.array(True), "np.int64": np.int64(1)}
        return np.zeros(1, np.float32), said


print("gymnasium", version("gymnasium"))
_, info = SyncVectorEnv([Told, Told]).reset(seed=0)
kinds = {key: value.dtype.name for key, value in info.items() if not key.startswith("_")}
print(kinds)
as_found = kinds == {"bool": "bool", "np.bool_": "object", "array": "bool", "np.int64": "int64"}
raise SystemExit(0 if as_found else "The behaviour has changed.")
PYTHON
