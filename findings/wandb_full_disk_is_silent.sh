#!/usr/bin/env bash
# One would guess that run.log or run.finish raises where the disk is full, or that at least a warning is printed.
# Of sixty rows on a disk of 700 kB about twelve are in the file, which lacks its end; log and finish return as always, exit code 0,
# and nothing is printed. wandb 0.31.0, 2026-11-30. Needs unshare and the right to mount a tmpfs in a namespace.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check wandb==0.31.0

cat > fill.py <<'EOF'
import os
import time

import wandb

run = wandb.init(mode="offline", project="p", dir="tiny")
for n in range(60):
    run.log({"value": n, "list": list(range(n * 5000, n * 5000 + 5000))})
run.finish()
time.sleep(3)
space = os.statvfs("tiny")
print("finish returned; bytes free:", space.f_bavail * space.f_frsize)
EOF
cat > alone.sh <<'EOF'
mkdir tiny
mount -t tmpfs -o size=700k tmpfs tiny
env/bin/python fill.py > out.txt 2> error.txt
echo "exit code $?"
ls -l tiny/wandb/offline-run-*/*.wandb
cat out.txt
EOF
export WANDB_ERROR_REPORTING=false
unshare -rm bash alone.sh | tee seen.txt
grep -q "exit code 0" seen.txt
grep -q "bytes free: 0" seen.txt
if grep -qi "space\|full\|disk" error.txt; then cat error.txt; exit 1; fi
echo "nothing was said of a full disk"
