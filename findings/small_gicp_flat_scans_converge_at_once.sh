#!/usr/bin/env bash
# One would guess that small_gicp matches two planar LiDAR scans (points at z = 0) by each of its methods, or says that it cannot.
# PLANE_ICP ends after 0 iterations with the identity and converged=True: normals of flat points are vertical, so the error is 0;
# VGICP at its default voxels of 1 m converges 0.4 m and 8 degrees off. ICP and GICP are right. small_gicp 1.0.1, 2026-11-30.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check small_gicp==1.0.1 numpy==2.4.6

cat > flat.py <<'EOF'
import numpy as np
import small_gicp

along = np.linspace(0, 4, 200)
walls = np.concatenate([np.stack(wall, 1) for wall in (
    (along, 0 * along), (0 * along, along), (along[:100], 0 * along[:100] + 4), (0 * along[:60] + 4, along[:60]))])
angle, shift = np.radians(5), np.array([0.2, 0.1])
turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
noise = np.random.default_rng(0).normal(0, 0.005, (2, *walls.shape))
flat = lambda points: np.column_stack([points, np.zeros(len(points))])
target, source = flat(walls + noise[0]), flat((walls - shift) @ turn + noise[1])

normals = small_gicp.preprocess_points(target, downsampling_resolution=0.05)[0].normals()
print("true motion: 0.20 m, 0.10 m, 5.00 degrees; normals of the points, all of:", np.unique(abs(normals), axis=0))
assert (abs(normals[:, 2]) == 1).all()
for method in ("ICP", "GICP", "PLANE_ICP", "VGICP"):
    found = small_gicp.align(target, source, registration_type=method, downsampling_resolution=0.05,
                             max_correspondence_distance=0.5)
    pose = found.T_target_source
    degrees = np.degrees(np.arctan2(pose[1, 0], pose[0, 0]))
    off = np.hypot(*(pose[:2, 3] - shift))
    print(f"{method}: converged={found.converged} after {found.iterations} iterations, error {found.error:.4f}: "
          f"{pose[0, 3]:.3f} m, {pose[1, 3]:.3f} m, {degrees:.2f} degrees; {off:.3f} m off")
    assert found.converged
    if method == "PLANE_ICP":
        assert found.iterations == 0 and found.error == 0 and (pose == np.eye(4)).all()
    else:
        assert (off > 0.3) == (method == "VGICP")
EOF
env/bin/python flat.py
