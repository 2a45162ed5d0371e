#!/usr/bin/env bash
# Guess: ArrayConversion (and with it NumpyToTorch) leaves a string in info as it is, or refuses it.
# What happens: the string becomes the text "<generator object ...>", without a word; numpy's bool is refused.
# gymnasium 1.4.0 (array-api-compat 1.16.0, numpy 2.4.6, packaging 26.3), 2026-11-29.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check gymnasium==1.4.0 array-api-compat==1.16.0 numpy==2.4.6 \
    packaging==26.3  # which this wrapper imports and gymnasium does not declare
venv/bin/python - <<'PYTHON'
from importlib.metadata import version

import gymnasium
import numpy as np
from gymnasium.wrappers import ArrayConversion


class Told(gymnasium.Env):
    """Says one thing in info and nothing else."""

    observation_space = gymnasium.spaces.Box(0.0, 1.0, (1,), np.float32)
    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self, said):
        self.said = said

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return np.zeros(1, np.float32), {"said": self.said}


def converted(said):
    try:
        return ArrayConversion(Told(said), env_xp=np, target_xp=np).reset(seed=0)[1]["said"]
    except Exception as error:
        return error


print("gymnasium", version("gymnasium"))
text, numpys, pythons = converted("door"), converted(np.bool_(True)), converted(True)
print("'door'         ->", repr(text))
print("np.bool_(True) ->", type(numpys).__name__, str(numpys)[:60])
print("True           ->", repr(pythons))
as_found = str(text).startswith("<generator object") and "No known conversion" in str(numpys) and bool(pythons)
raise SystemExit(0 if as_found else "The behaviour has changed.")
PYTHON
