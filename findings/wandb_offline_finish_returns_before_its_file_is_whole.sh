#!/usr/bin/env bash
# One would guess that after run.finish() of an offline run its .wandb file is whole, so that it may be copied or counted.
# It grows for a moment after finish() has returned: the service writes on its own. wandb 0.31.0, 2026-11-30.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check wandb==0.31.0

export WANDB_ERROR_REPORTING=false
env/bin/python - <<'EOF'
import glob
import os
import time

import wandb

grew = 0
for attempt in range(5):
    run = wandb.init(mode="offline", project="p", settings=wandb.Settings(silent=True))
    for n in range(2000):
        run.log({"value": n})
    run.finish()
    (path,) = glob.glob(f"wandb/offline-run-*/run-{run.id}.wandb")
    after_finish = os.path.getsize(path)
    time.sleep(2)
    print("bytes after finish():", after_finish, "two seconds later:", os.path.getsize(path))
    grew += os.path.getsize(path) > after_finish
assert grew
EOF
