#!/usr/bin/env bash
# Guess: `pip install tianshou` beside filelock 4 takes the newest tianshou, or says that the two do not go together.
# What happens: tianshou 1 and 2 ask for virtualenv<21, which they never import and whose filelock is older than 4; pip
# goes back to tianshou 0.5.1 of 2023, of another interface, without a warning.
# tianshou 2.0.1 with filelock 4.2.11, Python 3.11, 2026-11-30. Minutes, as pip tries every version in between.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --dry-run --quiet --disable-pip-version-check --report report.json filelock==4.2.11 torch==2.13.0 \
    tianshou 2> /dev/null
venv/bin/pip download --quiet --disable-pip-version-check --no-deps tianshou==2.0.1 2> /dev/null
venv/bin/python - <<'PYTHON'
import json
import zipfile
from pathlib import Path

chosen = {entry["metadata"]["name"].lower(): entry["metadata"]["version"]
          for entry in json.loads(Path("report.json").read_text())["install"]}
wheel = zipfile.ZipFile(next(Path().glob("tianshou-2.0.1-*.whl")))
metadata = next(wheel.read(name).decode() for name in wheel.namelist() if name.endswith("METADATA"))
asked = [line for line in metadata.splitlines() if line.startswith("Requires-Dist: virtualenv")]
imports = [name for name in wheel.namelist() if name.endswith(".py") and b"import virtualenv" in wheel.read(name)]
print("beside filelock", chosen["filelock"], "pip takes tianshou", chosen["tianshou"])
print("tianshou 2.0.1:", *asked, "imported in", imports)
as_found = chosen["tianshou"] == "0.5.1" and asked and not imports
raise SystemExit(0 if as_found else "The behaviour has changed.")
PYTHON
