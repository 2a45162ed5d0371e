"""agent.precision=auto: by what a processor says of itself and by how fast it multiplies, both given here."""

import pytest
import torch

from curionav_cli.agents import arithmetic
from curionav_cli.agents.arithmetic import Rates, faster, native, quick, rate
from curionav_cli.agents.lbs_dreamer.settings import Precision

EPYC = "processor : 0\nflags : fpu avx2 fma\n\n"
XEON = "processor : 0\nflags : fpu avx2 avx512f avx512_bf16 amx_bf16 amx_tile\n\n"
ARM = "processor : 0\nBogoMIPS : 50.00\nFeatures : fp asimd i8mm bf16\n\n"


@pytest.fixture
def processor(monkeypatch, tmp_path):
    """processor(cpuinfo, rates)"""
    def make(text, rates):
        monkeypatch.setattr(arithmetic, "CPUINFO", tmp_path / "cpuinfo")
        arithmetic.CPUINFO.write_text(text)
        monkeypatch.setattr(arithmetic, "rates", lambda: rates)
    return make


@pytest.mark.parametrize("text, rates, chosen", [
    (XEON, Rates(78, 900), "bfloat16"),
    (ARM, Rates(40, 110), "bfloat16"),
    (EPYC, Rates(70, 0.92), "float32"),
    (EPYC, Rates(70, 900), "float32"),  # not believed without instructions for it
    (XEON, Rates(78, 0.9), "float32"),  # nor those, where the library does not use them
    (XEON, Rates(78, 80), "float32"),  # a tie must not be decided by chance
    (XEON + EPYC, Rates(78, 900), "float32"),  # cores of two kinds
])
def test_a_processor_must_have_it_and_be_clearly_faster_in_it(processor, text, rates, chosen):
    processor(text, rates)
    assert quick("cpu").value == chosen and quick("cuda") is Precision.bfloat16


def test_the_slow_one_is_slow_by_the_same_margin():
    assert faster(Rates(70, 0.9), Precision.float32) and not faster(Rates(70, 0.9), Precision.bfloat16)
    assert not faster(Rates(78, 80), Precision.float32) and not faster(Rates(78, 80), Precision.bfloat16)


def test_a_system_that_does_not_tell_has_none(monkeypatch, tmp_path):
    monkeypatch.setattr(arithmetic, "CPUINFO", tmp_path / "nothing")
    assert native() == []


def test_a_product_is_measured_and_no_random_number_drawn():
    state = torch.get_rng_state()
    assert rate(torch.float32) > 0 and torch.equal(torch.get_rng_state(), state)
