#!/usr/bin/env bash
# Guess: after pip install, `rosbridge-server-rs` starts, and beside PyPI's ROS 2 (Kilted) with ROS_DISTRO=kilted.
# What happens: its two programs come without the executable bit, so that the command ends in a PermissionError; kilted
# is refused, though the program for jazzy runs there. rosbridge-server-rs 0.1.6 (x86_64), 2026-11-30.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet --disable-pip-version-check rosbridge-server-rs==0.1.6

venv/bin/python - <<'PYTHON'
import os
import subprocess
from importlib.metadata import version
from pathlib import Path

import rosbridge_server_rs

print("rosbridge-server-rs", version("rosbridge-server-rs"))


def last_line(distro):
    answer = subprocess.run(["venv/bin/rosbridge-server-rs", "--help"], env={**os.environ, "ROS_DISTRO": distro},
                            capture_output=True, text=True, check=False)
    print(f"ROS_DISTRO={distro}: exit code {answer.returncode},", (answer.stderr + answer.stdout).splitlines()[-1][:90])
    return answer


jazzy, kilted = last_line("jazzy"), last_line("kilted")
assert jazzy.returncode == 1 and "PermissionError" in jazzy.stderr
assert kilted.returncode == 1 and "supported ROS_DISTRO values: humble, jazzy" in kilted.stderr
for program in sorted(Path(rosbridge_server_rs.__file__).parent.glob("rosbridge_server_rs_*")):
    print(program.name, oct(program.stat().st_mode & 0o777))
    assert not program.stat().st_mode & 0o111
    program.chmod(0o755)
after = last_line("jazzy")
assert "PermissionError" not in after.stderr
PYTHON
