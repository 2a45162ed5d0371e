#!/usr/bin/env bash
# Guess: an algorithm of Stable-Baselines3 leaves the dictionary policy_kwargs as it is given.
# What happens: A2C and QRDQN write their own optimiser into it, so that a PPO made from the same dictionary afterwards
# trains with A2C's RMSprop instead of Adam, without a word.
# stable-baselines3 2.9.2 with sb3-contrib 2.9.2, torch 2.13.0, 2026-11-30.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check stable-baselines3==2.9.2 sb3-contrib==2.9.2 torch==2.13.0 \
    2> /dev/null
venv/bin/python - <<'PYTHON'
from importlib.metadata import version

from sb3_contrib import QRDQN
from stable_baselines3 import A2C, PPO

print("stable-baselines3", version("stable-baselines3"), "sb3-contrib", version("sb3-contrib"))
kwargs = {"net_arch": [8]}
before = type(PPO("MlpPolicy", "CartPole-v1", policy_kwargs=kwargs).policy.optimizer).__name__
A2C("MlpPolicy", "CartPole-v1", policy_kwargs=kwargs)
after = type(PPO("MlpPolicy", "CartPole-v1", policy_kwargs=kwargs).policy.optimizer).__name__
other = {"net_arch": [8]}
QRDQN("MlpPolicy", "CartPole-v1", policy_kwargs=other)
print("PPO's optimiser before an A2C with the same dictionary:", before)
print("and after:                                             ", after)
print("QRDQN left", sorted(other))
as_found = before == "Adam" and after == "RMSprop" and "optimizer_class" in other
raise SystemExit(0 if as_found else "The behaviour has changed.")
PYTHON
