#!/usr/bin/env bash
# One would guess that safetensors.numpy stores a transposed or Fortran-ordered array as its values, or refuses it as safetensors.torch does.
# It writes the memory as it lies under the shape of the array: another array comes back, without an error. np.ascontiguousarray
# first is the remedy; 0.4.5 stored the values. safetensors 0.8.0 (and 0.4.5 beside it), 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check safetensors==0.8.0 numpy==2.2.6

cat > there_and_back.py <<'EOF'
import numpy as np
import safetensors
from safetensors.numpy import load, save

rows = np.arange(6, dtype=np.float32).reshape(2, 3)
given = {"as it is": rows, "transposed": rows.T, "Fortran order": np.asfortranarray(rows),
         "made contiguous": np.ascontiguousarray(rows.T)}
print("safetensors", safetensors.__version__, "numpy", np.__version__)
for name, array in given.items():
    back = load(save({"x": array}))["x"]
    right = np.array_equal(back, array)
    print(f"{name}: {array.tolist()} -> {back.tolist()} {'right' if right else 'WRONG'}")
    wrong = name in ("transposed", "Fortran order") and safetensors.__version__ == "0.8.0"
    assert right != wrong
    if wrong:
        assert (back.ravel() == array.ravel(order="K")).all()
EOF
env/bin/python there_and_back.py
env/bin/pip install --quiet --disable-pip-version-check safetensors==0.4.5
env/bin/python there_and_back.py
