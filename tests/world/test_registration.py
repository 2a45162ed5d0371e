"""The scenes are registered with gymnasium whichever is imported first, and however gymnasium is looked for."""

from __future__ import annotations

import subprocess
import sys

import pytest


@pytest.mark.parametrize("first", [
    "import curionav_cli, gymnasium", "import gymnasium, curionav_cli",
    "import curionav_cli, importlib.util; importlib.util.find_spec('gymnasium'); import gymnasium",
])
def test_gymnasium_knows_our_worlds(first: str) -> None:
    """The last as torchrl does it: it asks for gymnasium before it imports it."""
    words = f"{first}; gymnasium.spec('curionav/SmallRoom-v0')"
    assert subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=False).stderr == ""
