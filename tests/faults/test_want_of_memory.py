"""Out of memory is reported as such, from Python, numpy and torch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from curionav_cli.errors import RunFailed
from curionav_cli.execution.interrupts import ended, out_of_memory
from curionav_cli.storage.run_folder import RunFolder

HUGE = 2**46


def caught(ask) -> BaseException:
    with pytest.raises((MemoryError, RuntimeError)) as error:
        ask()
    return error.value


@pytest.mark.parametrize("ask", [
    lambda: bytearray(HUGE), lambda: np.empty(HUGE, np.uint8), lambda: torch.empty(HUGE, dtype=torch.uint8),
])
def test_it_is_recognised_from_each_library(tmp_path: Path, ask) -> None:
    error = caught(ask)
    assert out_of_memory(error)
    run = RunFolder(tmp_path)
    failure = ended(run, error)
    assert isinstance(failure, RunFailed) and str(failure).startswith("Out of memory (")
    assert "Lower loop.replay_memory" in str(failure) and run.status["error"] == str(failure)
    assert run.status["state"] == "failed"


def test_of_a_gpu_too_and_of_nothing_else() -> None:
    assert out_of_memory(torch.OutOfMemoryError("CUDA out of memory. Tried to allocate 2.00 GiB"))
    for other in (ValueError("memory"), OSError(28, "No space left on device"), KeyboardInterrupt()):
        assert not out_of_memory(other)
