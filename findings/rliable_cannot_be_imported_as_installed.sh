#!/usr/bin/env bash
# One would guess that `pip install rliable`, the usual statistics of RL papers, gives a library that can be imported.
# It holds arch below 8 but not pandas: arch 7.2.0 calls a decorator of pandas' that takes other arguments since pandas 3, so that
# the import ends in a TypeError about neither. pandas<3 beside it is the remedy. rliable 1.2.0, 2026-11-30.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
pip() { env/bin/pip install --quiet --disable-pip-version-check "$@"; }
pip rliable==1.2.0 arch==7.2.0 pandas==3.1.1 numpy==2.4.6 scipy==1.17.1  # what pip takes for rliable alone on this date

cat > read.py <<'EOF'
import importlib.metadata as installed

print("rliable wants", sorted(want for want in installed.requires("rliable") if want.startswith(("arch", "pandas"))),
      "arch wants", [want for want in installed.requires("arch") if want.startswith("pandas")])
print({name: installed.version(name) for name in ("rliable", "arch", "pandas")})
try:
    from rliable import library, metrics
except TypeError as error:
    print("import rliable.metrics, rliable.library: TypeError:", error)
    raise SystemExit(3)
import numpy as np

print("imported; interquartile mean of 0.1, 0.2, 0.3, 0.4:", metrics.aggregate_iqm(np.array([[0.1], [0.2], [0.3], [0.4]])))
EOF
code=0; env/bin/python read.py || code=$?
[ "$code" = 3 ]
pip 'pandas==2.3.3'
env/bin/python read.py
