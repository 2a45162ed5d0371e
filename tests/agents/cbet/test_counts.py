"""Counting, forgetting and C-BET's reward against what can be said without them."""

import json
from collections import Counter

import numpy as np
import pytest
from torch import nn

from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.reward_monitor import RewardMonitor
from curionav_cli.agents.cbet.rewards.cbet import CBET
from curionav_cli.agents.cbet.rewards.reward import RewardContext


def test_counts_are_a_counter_for_each_environment():
    rng = np.random.default_rng(0)
    keys = [bytes(row) for row in rng.integers(0, 4, (10_000, 4), np.uint8)]
    environment = rng.integers(0, 3, 10_000).tolist()
    own, shared, truth, all_of_them = Counts(3), Counts(1), [Counter() for _ in range(3)], Counter()
    for e, key in zip(environment, keys, strict=True):
        truth[e][key] += 1
        all_of_them[key] += 1
        assert own.add(e, key) == truth[e][key] and shared.add(e, key) == all_of_them[key]
    assert own.tables == truth and shared.tables == [all_of_them]
    again = Counts(3)
    again.load_state(own.state())
    assert again.tables == own.tables and [list(t) for t in again.tables] == [list(t) for t in own.tables]
    own.clear(1)
    assert [len(table) for table in own.tables] == [len(truth[0]), 0, len(truth[2])]
    empty = Counts(1)
    empty.load_state(Counts(1).state())
    assert empty.tables == [{}]


@pytest.fixture
def reward(tiny, small_room):
    """reward(**changes): C-BET's, of the own picture."""
    return lambda **changes: CBET(RewardContext(tiny(view="ego", **changes), small_room, "numpy", 0, 5),
                                  nn.ModuleDict())


@pytest.fixture
def met(reward, walk):
    """met(states, changes, **changes): the bonus of one episode with these keys."""
    def make(states, changes, made=None, environment=0, **settings):
        made = made or reward(**settings)
        made.state_keys = lambda image: [str(s).encode() for s in states]
        made.change_keys = lambda view, reached: [str(c).encode() for c in changes]
        return made.episode_bonus(walk([1] * len(states), environment=environment))[0]
    return make


def test_update_then_read(met):
    bonus = met("AAB", "0x0", reset="never")
    assert bonus == pytest.approx([1 / 2, 1 / 3, 1 / 3])


def test_a_bonus_is_at_most_a_half_and_never_nothing(met):
    rng = np.random.default_rng(0)
    bonus = met(rng.integers(0, 5, 300).tolist(), rng.integers(0, 5, 300).tolist(), reset="never")
    assert bonus[0] == 0.5 == bonus.max() and bonus.min() > 0


def test_environments_count_for_themselves_unless_they_share(met, reward):
    own, shared = reward(reset="never"), reward(reset="never", tables="shared")
    assert met("A", "x", own, 0) == met("A", "x", own, 1) == met("A", "x", own, 2) * 2 == 0.5
    assert [met("A", "x", shared, e)[0] for e in range(3)] == [1 / 2, 1 / 4, 1 / 6]


def test_forgetting_never_always_and_with_the_episode(met, reward):
    assert met("AAAA", "xxxx", reset="random", reset_prob=0.0) == pytest.approx([1 / 2, 1 / 4, 1 / 6, 1 / 8])
    assert met("AAAA", "xxxx", reset="random", reset_prob=1.0) == pytest.approx([1 / 2] * 4)
    for counted in (True, False):
        made = reward(reset="episode", count_teleport=counted)
        for _ in range(2):
            assert met("AAAAS", "xxxxz", made)[:4] == pytest.approx([1 / 2, 1 / 4, 1 / 6, 1 / 8])


def test_gaps_between_resets_are_geometric_and_the_two_tables_apart(reward):
    made = reward(reset_prob=0.001)
    drawn = np.concatenate([made.cleared(100_000, 0) for _ in range(20)])
    for table in drawn.T:
        gaps = np.diff(np.flatnonzero(table))
        assert abs(gaps.mean() - 1000) < 4 * 1000 / len(gaps) ** 0.5
        assert abs(gaps.std() / gaps.mean() - 1) < 0.1
    assert drawn.all(axis=1).sum() < 12  # by chance 2
    assert (made.cleared(5000, 0) != made.cleared(5000, 1)).any()


@pytest.mark.parametrize("counted", [True, False])
def test_the_respawn_counts_or_does_not(met, reward, counted):
    made = reward(reset="never", count_teleport=counted)
    bonus = met("ABS", "xyz", made)
    assert bonus.tolist() == [0.5, 0.5, 0.5 if counted else 0.0]
    assert (b"S" in made.counts["states"].tables[0]) == (b"z" in made.counts["changes"].tables[0]) == counted


def test_in_the_room_a_turn_is_soon_worth_little_and_a_move_half_a_point(tiny, small_room, walk):
    made = CBET(RewardContext(tiny(reset="never"), small_room, "numpy", 0, 5), nn.ModuleDict())
    transitions = walk([1, 2] * 20 + [0, 0, 0])
    bonus, watch = made.episode_bonus(transitions)
    assert bonus[40:42].tolist() == [0.5, 0.5] and bonus[38] < 0.05
    assert watch["unique_changes"] == 4 / 43 and watch["unique_of_new_poses"] == 1.0
    assert watch["count_of_change"] == pytest.approx((np.arange(1, 41).sum() + 3) / 43)


def test_the_monitor_warns_once_after_enough_steps():
    monitor = RewardMonitor(0.5)
    monitor.update(1999, 1999, np.full(1999, 0.5))
    with (pytest.warns(UserWarning, match=r"degenerate: 100\.0% of the poses .* agent.key=grey_16"),
          pytest.warns(UserWarning, match=r"ceiling: 0\.500 of 0\.5")):
        monitor.update(1, 1, np.full(1, 0.5))
    monitor.update(1, 1, np.full(1, 0.5))
    quiet = RewardMonitor(0.5)
    quiet.update(3000, 2800, np.full(3000, 0.47))
    assert not quiet.warned
    restored = RewardMonitor(0.5)
    restored.load_state(json.loads(json.dumps(monitor.state())))
    restored.update(5000, 5000, np.full(5000, 0.5))
    assert restored.state() != monitor.state() and restored.warned == monitor.warned, "not once more after a resume"
