#!/usr/bin/env bash
# One would guess that the nearest hits of 360 rays, each of which hits, come back ray by ray whatever engine trimesh finds installed.
# With embreex they do; without it the same call gives the same hits in another order, so that a scan taken straight from
# `locations` is shuffled on the machine that lacks it; index_ray tells. trimesh 5.2.0, embreex 4.4.0.post1, 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check trimesh==5.2.0 rtree==1.4.1 scipy==1.16.3 numpy==2.4.6

cat > scan.py <<'EOF'
from importlib.metadata import version
from importlib.util import find_spec

import numpy as np
import trimesh

with_embree = find_spec("embreex") is not None
room = trimesh.creation.box(extents=(8, 6, 3))
angle = np.radians(np.arange(360))
way = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(360)])
start = np.tile([1.3, -0.7, 0.2], (360, 1))
locations, index_ray, _ = room.ray.intersects_location(start, way, multiple_hits=False)
print("trimesh", version("trimesh"), "embreex", version("embreex") if with_embree else "absent", type(room.ray).__module__)
assert sorted(index_ray) == list(range(360))
ranges = np.linalg.norm(locations - start, axis=1)
truth = np.min([np.abs((np.sign(d) * half - at) / d) for d, half, at in
                ((way[:, 0] + 1e-300, 4.0, 1.3), (way[:, 1] + 1e-300, 3.0, -0.7))], axis=0)
straight, sorted_ = np.abs(ranges - truth).max(), np.abs(ranges[np.argsort(index_ray)] - truth).max()
print(f"360 hits, first rays {index_ray[:6].tolist()}; error of ranges as they come {straight:.3f} m, by index_ray {sorted_:.6f} m")
assert sorted_ < 1e-4 and (straight < 1e-4) == with_embree
EOF
env/bin/python scan.py
env/bin/pip install --quiet --disable-pip-version-check embreex==4.4.0.post1
env/bin/python scan.py
