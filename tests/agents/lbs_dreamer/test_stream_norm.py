"""The reward normaliser against its formula."""

import torch

from curionav_cli.agents.lbs_dreamer.stream_norm import StreamNorm


def test_first_and_second_update():
    norm = StreamNorm(0.95, 0.0)
    reward = torch.tensor([1.0, -3.0, 4.0, 4.0])
    torch.testing.assert_close(norm(reward), reward / (0.95 * 1 + 0.05 * 3))
    magnitude = 0.95 * 1.1 + 0.05 * 6
    torch.testing.assert_close(norm(2 * reward), 2 * reward / magnitude)
    torch.testing.assert_close(norm.magnitude, torch.tensor(magnitude))


def test_momentum_one_is_off():
    reward = torch.tensor([5.0, 7.0])
    assert (StreamNorm(1.0, 0.0)(reward) == reward).all()


def test_centring_takes_the_running_mean_off():
    norm = StreamNorm(0.0, 1.0)
    torch.testing.assert_close(norm(torch.tensor([9.0, 11.0])), torch.tensor([-0.1, 0.1]))


def test_the_mean_is_right_from_the_first_update():
    assert not StreamNorm(0.95, 1.0)(torch.full((4,), 7.0)).any()


def test_a_signal_without_spread_stays_without():
    assert not StreamNorm(0.0, 1.0)(torch.full((4,), 7.0)).any()
