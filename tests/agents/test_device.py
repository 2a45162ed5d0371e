"""device=auto, cpu, cuda; and freed memory that is used again without asking the kernel."""

import subprocess
import sys

import pytest
import torch

from curionav_cli.agents.device import resolve_device
from curionav_cli.errors import ConfigError


def test_devices(monkeypatch):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert resolve_device("auto") == resolve_device("cpu") == torch.device("cpu")
    with pytest.raises(ConfigError, match="device=cuda, but torch sees no CUDA device"):
        resolve_device("cuda")
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert resolve_device("auto") == torch.device("cuda")


PROGRAM = """
import resource, sys
import torch
from curionav_cli.agents.device import keep_freed_memory
if len(sys.argv) > 1:
    keep_freed_memory(*map(eval, sys.argv[1:]))
faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt
parts = [torch.ones(5_000_000) for _ in range(3)]
del parts
before = faults()
torch.ones(4_000_000)
print(faults() - before)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="only glibc has these settings")
@pytest.mark.parametrize("settings", [("-1", "None"), ("2**29", "2**25")], ids=["lbs_dreamer", "cbet"])
def test_what_fits_into_freed_memory_needs_no_new_pages(settings):
    kept, plain = (int(subprocess.run([sys.executable, "-c", PROGRAM, *words], capture_output=True, text=True,
                                      check=True).stdout) for words in (settings, ()))
    assert kept < 100 < plain
