#!/usr/bin/env bash
# One would guess that a row is on the disk soon after trackio.log has returned, as the storage is a local SQLite file.
# Rows wait in a queue of the process: of ten rows, logged right before SIGKILL, none is in the file. trackio 0.43.0, 2026-11-30.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check trackio==0.43.0

export TRACKIO_DIR=$work/kept TRACKIO_STORAGE_MODE=sqlite
code=0
env/bin/python - <<'EOF' || code=$?
import os
import signal

import trackio

trackio.init(project="p", name="r", embed=False, auto_log_gpu=False, auto_log_cpu=False)
for n in range(10):
    trackio.log({"value": n})
os.kill(os.getpid(), signal.SIGKILL)
EOF
test $code -eq 137
env/bin/python - <<'EOF'
import glob
import sqlite3

rows = [row for path in glob.glob("kept/*.db") for row in sqlite3.connect(path).execute("SELECT * FROM metrics")]
print("rows in the file:", len(rows), "of 10")
assert len(rows) < 10
EOF
