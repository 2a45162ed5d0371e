#!/usr/bin/env bash
# One would guess that saving the same tensors with the same metadata twice gives the same bytes, as it does without metadata.
# The order of metadata keys in the header is drawn anew for every save: ten saves in one process give many different files, of one
# content and size, so that a checksum cannot tell whether a checkpoint changed. safetensors 0.8.0, 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check safetensors==0.8.0 numpy==2.4.6

env/bin/python - <<'EOF'
import json

import numpy as np
import safetensors
from safetensors.numpy import save

tensors = {name: np.arange(4, dtype=np.float32) for name in ("b", "a")}
metadata = {f"key {number}": "value" for number in range(8)}


def header(saved):
    return json.loads(saved[8:8 + int.from_bytes(saved[:8], "little")])


print("safetensors", safetensors.__version__)
for text in (None, metadata):
    saves = [save(tensors, metadata=text) for _ in range(10)]
    print("with" if text else "without", "metadata: ten saves,", len(set(saves)), "different")
    assert all(header(saved) == header(saves[0]) and len(saved) == len(saves[0]) for saved in saves)
    assert (len(set(saves)) > 1) == bool(text)
for saved in sorted(set(saves))[:2]:
    print("  ", list(header(saved)["__metadata__"]))
EOF
