"""Recorded updates are the same to the bit as eager ones; on a GPU, within rounding."""

from functools import partial

import pytest
import torch
from tape import tape

from curionav_cli.agents.lbs_dreamer.checkpoint import load_learner, save_learner
from curionav_cli.agents.lbs_dreamer.graphs import Recorded
from curionav_cli.agents.lbs_dreamer.learner import Learner
from curionav_cli.agents.lbs_dreamer.metrics import Meter

CPU = torch.device("cpu")


@pytest.fixture
def learner(tiny, networks):
    """learner(record, **changes)"""
    def make(*record, **changes):
        settings = tiny(**changes)
        return Learner(settings, networks(settings), torch.Generator().manual_seed(1), *record)
    return make


def everything(learner):
    """Weights, buffers, Adam's state and the generator's, by name."""
    moments = {f"{name}/{path}": tensor for name, optimiser in learner.optimisers.items()
               for path, tensor in optimiser.state().items()}
    found = {**learner.networks.state_dict(), **moments, "generator": learner.generator.get_state()}
    return {name: tensor.clone() for name, tensor in found.items()}


def train(learner, data, updates):
    meter = Meter()
    for _ in range(updates):
        meter.add(learner.update(data))
    return meter.read()


def assert_same(left, right):
    left, right = everything(left), everything(right)
    assert [name for name in left if not torch.equal(left[name], right[name])] == []


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
def test_recorded_updates_are_eager_ones_to_the_bit(learner, data, precision, tmp_path):
    eager = learner(precision=precision)
    recorded = learner(partial(Recorded, tape, CPU), precision=precision)
    assert train(eager, data, 13) == train(recorded, data, 13)
    save_learner(recorded, tmp_path)
    for made in (recorded, learner(partial(Recorded, tape, CPU), precision=precision)):
        train(made, data, 2)  # a load must reach what was recorded
        load_learner(made, tmp_path)
        meters = train(made, data, 14)
    assert meters == train(eager, data, 14)
    assert recorded.behaviour_updates == eager.behaviour_updates == 14
    assert_same(eager, recorded)
    assert_same(eager, made)
