"""The baselines do what their names say, from their own generator."""

import numpy as np
import pytest
from scipy.stats import chisquare

from curionav_cli.agents.baselines import Bounce, Random, Sticky
from curionav_cli.constants import FORWARD, LEFT, RIGHT

OPEN, BLOCKED = {"collided": False}, {"collided": True}


def actions(agent, count, info=OPEN):
    agent.begin()
    return np.array([agent.act({}, info) for _ in range(count)])


def test_random_is_uniform_and_belongs_to_its_seed():
    drawn = actions(Random(0), 6000)
    assert chisquare(np.bincount(drawn, minlength=3)).pvalue > 1e-3
    np.testing.assert_array_equal(drawn, actions(Random(0), 6000))
    assert (drawn != actions(Random(1), 6000)).mean() > 0.5


@pytest.mark.parametrize("repeat", [0.0, 0.75, 1.0])
def test_sticky_repeats_itself(repeat):
    drawn = actions(Sticky(0, repeat), 6000)
    same = (drawn[1:] == drawn[:-1]).mean()
    assert same == pytest.approx(repeat + (1 - repeat) / 3, abs=0.03)


def test_bounce_goes_forward_until_cut_short_then_turns_one_way():
    agent = Bounce(0, least=3, most=18)
    assert (actions(agent, 20) == FORWARD).all()
    turns = []
    for _ in range(400):
        turn = [agent.act({}, BLOCKED)]
        while (action := agent.act({}, OPEN)) != FORWARD:
            turn.append(action)
        assert len(set(turn)) == 1
        turns.append((len(turn), turn[0]))
    length, side = np.array(turns).T
    assert length.min() == 3 and length.max() == 18
    assert set(side) == {LEFT, RIGHT} and 0.4 < (side == LEFT).mean() < 0.6


@pytest.mark.parametrize("make", [lambda: Random(3), lambda: Sticky(3, 0.75), lambda: Bounce(3, 3, 18)])
def test_what_was_saved_goes_on_as_if_nothing_had_happened(tmp_path, make):
    agent, other = make(), make()
    actions(agent, 50, BLOCKED)
    agent.save(tmp_path)
    other.load(tmp_path)
    np.testing.assert_array_equal(actions(agent, 200, BLOCKED), actions(other, 200, BLOCKED))
