#!/usr/bin/env bash
# One would guess that wandb.init(mode="offline") sends nothing: its documentation says that data is saved locally without uploading.
# In a network namespace without routes an offline run of three rows asks the kernel for a route, for telemetry (OpenTelemetry, to
# api.wandb.ai). Only WANDB_ERROR_REPORTING=false, set before the import, ends it; DO_NOT_TRACK does not. wandb 0.31.0, 2026-11-30.
# Needs unshare and the right to make a network namespace.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check wandb==0.31.0

cat > offline.py <<'EOF'
import wandb

run = wandb.init(mode="offline", project="p", settings=wandb.Settings(silent=True))
for n in range(3):
    run.log({"value": n})
run.finish()
EOF
cat > alone.sh <<'EOF'
ip link set lo up 2> /dev/null || true
refused() { awk '/^Ip:/ { if (!seen++) { for (n = 1; n <= NF; n++) if ($n == "OutNoRoutes") at = n } else print $at }' /proc/net/snmp; }
before=$(refused)
env/bin/python offline.py > /dev/null 2>&1
echo $(($(refused) - before))
EOF
plain=$(unshare -rn bash alone.sh)
polite=$(DO_NOT_TRACK=1 unshare -rn bash alone.sh)
quiet=$(WANDB_ERROR_REPORTING=false unshare -rn bash alone.sh)
echo "packets that found no route, offline: $plain; with DO_NOT_TRACK=1: $polite; with WANDB_ERROR_REPORTING=false: $quiet"
test "$plain" -gt 0
test "$polite" -gt 0
test "$quiet" -eq 0
