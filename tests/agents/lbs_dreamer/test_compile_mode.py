"""The setting compile: what it is on each device."""

import pytest
import torch

from curionav_cli.agents.lbs_dreamer import compile as compile_module
from curionav_cli.agents.lbs_dreamer.compile import compile_mode, recorder
from curionav_cli.agents.lbs_dreamer.kernels.cuda_graphs import as_it_is, cuda_graph
from curionav_cli.agents.lbs_dreamer.settings import Precision
from curionav_cli.errors import ConfigError


def test_what_compile_means(monkeypatch):
    cpu, cuda = torch.device("cpu"), torch.device("cuda")
    assert compile_mode("none", cpu) == compile_mode("none", cuda) == "none"
    for possible, on_gpu in ((True, "fused"), (False, "graph")):
        monkeypatch.setattr(compile_module, "can_fuse", lambda device, possible=possible: possible)
        assert compile_mode("auto", cuda) == on_gpu and compile_mode("auto", cpu) == "none"
    for compile in ("graph", "fused"):
        assert compile_mode(compile, cuda) == compile
        assert recorder(compile, cuda).args == (cuda_graph, cuda)
    assert recorder("none", cuda) is recorder("fused", cpu) is as_it_is


@pytest.mark.parametrize("compile, needs", [("graph", "a CUDA device"), ("fused", "numba, which is not installed")])
def test_what_is_not_possible_on_a_cpu_is_refused(monkeypatch, compile, needs):
    monkeypatch.setattr(compile_module, "find_spec", lambda name: None)
    with pytest.raises(ConfigError, match=f"compile={compile} .*needs {needs}"):
        compile_mode(compile, torch.device("cpu"))


def test_a_cpu_fuses_float32_alone():
    cpu = torch.device("cpu")
    assert compile_mode("fused", cpu, Precision.float32) == "fused"
    with pytest.raises(ConfigError, match="fuses float32 alone"):
        compile_mode("fused", cpu, Precision.bfloat16)
