"""Memory that was freed is used again without a visit to the kernel."""

import subprocess
import sys

import pytest

PROGRAM = """
import resource, sys
import torch
from curionav_cli.agents.device import keep_freed_memory
if sys.argv[1] == "keep":
    keep_freed_memory()
faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt
parts = [torch.ones(5_000_000) for _ in range(3)]
del parts
before = faults()
torch.ones(4_000_000)
print(faults() - before)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="it is glibc's allocator that is told")
def test_what_fits_into_freed_memory_needs_no_new_pages():
    kept, plain = (int(subprocess.run([sys.executable, "-c", PROGRAM, word], capture_output=True, text=True,
                                      check=True).stdout) for word in ("keep", "plain"))
    assert kept < 100 < plain
