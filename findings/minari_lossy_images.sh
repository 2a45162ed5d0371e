#!/usr/bin/env bash
# Guess: a Minari dataset gives back the observations that went in, byte for byte, as those of any other type and shape.
# What happens: uint8 of 64 x 64 x 3 comes back as a JPEG of it, of 64 x 64 x 2 unchanged; jpeg_encoding=False keeps both.
# minari 0.5.4 (h5py 3.16.0, jax 0.10.2, gymnasium 1.4.0, numpy 2.4.6), 2026-11-29.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check minari==0.5.4 h5py==3.16.0 jax==0.10.2 jaxlib==0.10.2 \
    gymnasium==1.4.0 numpy==2.4.6 pillow==13.0.0
cat > noise.py <<'PYTHON'
import gymnasium
import numpy as np


class Noise(gymnasium.Env):
    """A picture of noise in every step, of so many channels; three steps."""

    action_space = gymnasium.spaces.Discrete(2)

    def __init__(self, channels):
        self.observation_space = gymnasium.spaces.Box(0, 255, (64, 64, channels), np.uint8)

    def picture(self):
        return self.np_random.integers(0, 256, self.observation_space.shape, np.uint8)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return self.picture(), {}

    def step(self, action):
        return self.picture(), 0.0, False, False, {}
PYTHON
MINARI_DATASETS_PATH="$folder/datasets" venv/bin/python -W ignore - <<'PYTHON'
from importlib.metadata import version

import gymnasium
import minari
import numpy as np

gymnasium.register("Noise-v0", "noise:Noise", max_episode_steps=3)


def apart(channels, **how):
    """The largest difference between what was seen and what is read."""
    env = minari.DataCollector(gymnasium.make("Noise-v0", channels=channels), **how)
    seen = [env.reset(seed=0)[0]] + [env.step(0)[0] for _ in range(3)]
    name = f"noise/try{channels}{len(how)}-v0"
    env.create_dataset(name, algorithm_name="none", author="none", author_email="none@example.com",
                       code_permalink="https://example.com", description="noise")
    read = next(iter(minari.load_dataset(name).iterate_episodes())).observations
    return int(np.abs(read.astype(int) - np.stack(seen)).max())


print("minari", version("minari"))
found = apart(3), apart(2), apart(3, jpeg_encoding=False)
print("largest difference of three channels, of two, of three with jpeg_encoding=False:", *found)
raise SystemExit(0 if found[0] > 0 and found[1:] == (0, 0) else "The behaviour has changed.")
PYTHON
