"""The setting compile: what it is on each device."""

import pytest
import torch

from curionav_cli.agents.lbs_dreamer import compile as compile_module
from curionav_cli.agents.lbs_dreamer.compile import compile_mode, recorder
from curionav_cli.agents.lbs_dreamer.kernels.cuda_graphs import as_it_is, cuda_graph
from curionav_cli.errors import ConfigError


def test_what_compile_means(monkeypatch):
    cpu, cuda = torch.device("cpu"), torch.device("cuda")
    assert compile_mode("auto", cpu) == compile_mode("none", cpu) == compile_mode("none", cuda) == "none"
    for possible, chosen in ((True, "fused"), (False, "graph")):
        monkeypatch.setattr(compile_module, "can_fuse", lambda device, possible=possible: possible)
        assert compile_mode("auto", cuda) == chosen
    for compile in ("graph", "fused"):
        assert compile_mode(compile, cuda) == compile
        assert recorder(compile, cuda).args == (cuda_graph, cuda)
        with pytest.raises(ConfigError, match=f"compile={compile} needs a CUDA device"):
            compile_mode(compile, cpu)
    assert recorder("none", cuda) is as_it_is
