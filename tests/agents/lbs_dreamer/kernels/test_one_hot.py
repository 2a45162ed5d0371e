"""Sums of columns against products with one-hots."""

import pytest
import torch
import torch.nn.functional as F

from curionav_cli.agents.lbs_dreamer.kernels import one_hot
from curionav_cli.agents.lbs_dreamer.kernels.one_hot import MANY

S, C, U = 3, 4, 6


@pytest.fixture
def stoch():
    """stoch(count): one-hots (count, S * C) float32."""
    generator = torch.Generator().manual_seed(0)
    return lambda count: F.one_hot(torch.randint(0, C, (count, S), generator=generator), C).flatten(1).float()


def test_indices_are_where_the_ones_are(stoch):
    given = stoch(MANY)
    ones = one_hot.indices(given, C)
    assert ones.shape == (MANY, S) and (torch.zeros_like(given).scatter(-1, ones, 1.0) == given).all()
    assert one_hot.pays(given) and not one_hot.pays(given[:-1])


def test_elu_of_dense_is_that_of_plain_layers(stoch):
    given, generator = stoch(MANY), torch.Generator().manual_seed(1)
    weight, rest = torch.randn(U, S * C, generator=generator), torch.randn(MANY, U, generator=generator)
    truth = F.elu(F.linear(given, weight) + rest)
    for ones in (None, one_hot.indices(given, C)):
        torch.testing.assert_close(one_hot.elu_of_dense(given, weight, rest, ones), truth)
