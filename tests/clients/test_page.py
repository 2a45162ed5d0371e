"""Every block of docs/gymnasium.md, as a program of its own."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.clients
PAGE = Path(__file__).parents[2] / "docs" / "gymnasium.md"
BLOCKS = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("block", BLOCKS, ids=range(len(BLOCKS)))
def test_a_block_runs(block: str, tmp_path: Path) -> None:
    for package in ("stable_baselines3", "torchrl", "minari"):
        if package in block:
            pytest.importorskip(package)
    (tmp_path / "block.py").write_text(block)
    done = subprocess.run([sys.executable, "block.py"], cwd=tmp_path, capture_output=True, text=True,
                          env={**os.environ, "MINARI_DATASETS_PATH": str(tmp_path / "sets")})
    assert done.returncode == 0, done.stderr


def test_the_page_has_blocks() -> None:
    assert len(BLOCKS) == 6
