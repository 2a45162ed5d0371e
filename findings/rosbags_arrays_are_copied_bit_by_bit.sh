#!/usr/bin/env bash
# One would guess that an array of another number type is converted to the field's type, or refused by name.
# rosbags copies its bytes where the item sizes agree: ranges of 1, 2, 3 metres as int32 are stored as 1e-45 metres, and big-endian
# floats as garbage; where the sizes differ it refuses, naming neither field nor type. rosbags 0.11.9, 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check rosbags==0.11.9 numpy==2.4.6

env/bin/python - <<'EOF'
from importlib.metadata import version

import numpy as np
from rosbags.typesys import Stores, get_typestore

store, name = get_typestore(Stores.ROS2_HUMBLE), "sensor_msgs/msg/LaserScan"
Header, Time, Scan = (store.types[kind] for kind in ("std_msgs/msg/Header", "builtin_interfaces/msg/Time", name))


def there_and_back(ranges):
    scan = Scan(Header(Time(0, 0), "laser"), 0.0, 1.0, 0.5, 0.0, 0.1, 0.1, 5.0, ranges, np.array([], np.float32))
    return store.deserialize_cdr(store.serialize_cdr(scan, name), name).ranges.copy()


print("rosbags", version("rosbags"), "numpy", np.__version__)
metres = np.array([1, 2, 3])
for kind in ("<f4", "<i4", ">f4"):
    back = there_and_back(metres.astype(kind))
    print(f"ranges given as {kind}: {metres.tolist()} read back as {back.tolist()}")
    assert (kind == "<f4") == bool((back == metres).all())
    if kind != "<f4":
        assert (back == metres.astype(kind).view("<f4")).all() and abs(back).max() < 1e-38
try:
    there_and_back(metres.astype("<f8"))
except ValueError as error:
    print("ranges given as <f8: ValueError:", error)
    assert "ranges" not in str(error) and "float32" not in str(error)
else:
    raise SystemExit("float64 is accepted now")
EOF
