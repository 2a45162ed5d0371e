"""Options: what is carried out is what an episode's primitive actions tell, and nothing else parses."""

from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.agents.baselines import Random
from curionav_cli.constants import FORWARD, LEFT, RIGHT, OptionSet
from curionav_cli.decisions import EACH_STEP, Steps
from curionav_cli.errors import RunFolderError
from curionav_cli.options import MOVES, SEVEN, Options, chosen
from curionav_cli.storage.replay import Replay

SHORT = {FORWARD: "F", LEFT: "L", RIGHT: "R"}


def carried_out(choices, steps, blocked):
    """Primitive actions and `collided` of `steps` steps, of which forward moves are cut short as `blocked(step)` says;
    choices: an iterator. Also what was begun, and where."""
    execution, info = Options().execution(), {"collided": False}
    action, collided, begun = [], [], []
    for step in range(steps):
        if execution.due(info):
            begun.append((step, next(choices)))
            execution.start(begun[-1][1])
        action.append(execution.step())
        info = {"collided": np.array(action[-1] == FORWARD and blocked(step), bool)}
        collided.append(bool(info["collided"]))
    return np.array(action), np.array(collided), begun


def written(action, collided):
    """F forward, f cut short, L, R."""
    return "".join(SHORT[move].lower() if cut else SHORT[move] for move, cut in zip(action, collided, strict=True))


def read(text):
    """The actions and `collided` of a text."""
    letters = {letter: move for move, letter in SHORT.items()}
    return np.array([letters[letter.upper()] for letter in text]), np.array([letter == "f" for letter in text])


def test_an_option_turns_and_then_drives_until_cut_short_or_eight_moves():
    free = [written(*carried_out(iter([option, 0, 0]), 18, lambda step: False)[:2]) for option in range(7)]
    for text, turns in zip(free, SEVEN, strict=True):
        assert text.startswith("LR"[turns < 0] * abs(turns) + "F" * MOVES)
    against_a_wall = carried_out(iter([0, 1, 2, 6]), 12, lambda step: step != 4)
    assert written(*against_a_wall[:2]) == "fLLLFfRRRfRR"
    assert against_a_wall[2] == [(0, 0), (1, 1), (6, 2), (10, 6)]
    assert Options.names == ("ahead", "left_30", "right_30", "left_60", "right_60", "left_90", "right_90")


@pytest.mark.parametrize("often", [0.0, 0.1, 0.5, 1.0])
def test_what_was_chosen_is_read_from_the_primitive_actions(often):
    rng = np.random.default_rng(int(10 * often))
    for steps in (1, 9, 17, 300):
        choices = iter(rng.integers(7, size=steps).tolist())
        action, collided, begun = carried_out(choices, steps, lambda step: rng.random() < often)
        found = Options().decisions(action, collided)
        whole = len(found.action)
        assert found.frame[0] == 0 and found.frame.dtype == found.action.dtype == np.int64
        assert list(zip(found.frame[:-1].tolist(), found.action.tolist())) == begun[:whole]
        assert [at for at, _ in begun[whole:]] in ([], [found.frame[-1]])  # at most the last one is cut off
        assert (found.frame[-1] == steps) == (whole == len(begun))


@pytest.mark.parametrize(("text", "step"), [
    ("L", 0), ("LR", 2), ("LF", 2), ("LLLFFFLLL", 7), ("LLLLLLLLLL", 10), ("FFFFFFFFLLLLF", 13), ("fRRRRRRRF", 9),
])
def test_actions_that_are_no_options_are_refused(text, step):
    action, collided = read(text)
    if not step:
        assert Options().decisions(action, collided).frame.tolist() == [0]  # an option that was cut off
        return
    with pytest.raises(RunFolderError, match=rf"^it was recorded without agent\.options=seven: its actions up to step "
                                             rf"{step} are no options\. Set agent\.options=none\.$"):
        Options().decisions(action, collided, "it")


def test_a_replay_of_options_keeps_the_frames_at_which_one_was_chosen(an_episode):
    action, collided = read("LLLFfFFFFFFFFRRRRRRfLL")
    episode = replace(an_episode(steps=len(action)), action=action, collided=collided)
    replay = Replay([episode], every=Options())
    kept = replay.episode(0)
    assert kept.action.tolist() == [1, 0, 4] and kept.collided.tolist() == [True, False, True]
    np.testing.assert_array_equal(kept.image, episode.image[[0, 5, 13, 20]])
    np.testing.assert_array_equal(kept.pose, episode.pose[[0, 5, 13, 20]])
    assert replay.steps == 20 and not np.shares_memory(kept.image, episode.image)
    batch = replay.sample(20, 3, np.random.default_rng(0))
    assert {tuple(row) for row in batch["action"].tolist()} == {(-1, 1, 0), (-1, 0, 4)}


def test_an_episode_shorter_than_an_option_keeps_its_first_frame(an_episode):
    episode = replace(an_episode(steps=2), action=np.array([LEFT, LEFT]), collided=np.zeros(2, bool))
    replay = Replay([episode], every=Options())
    assert len(replay.episode(0)) == 0 and len(replay.episode(0).image) == 1 and replay.steps == 0


def test_the_settings_choose():
    assert chosen({}) == chosen({"options": "none"}) == EACH_STEP == Steps(1)
    assert chosen({"options": OptionSet.none, "action_repeat": 4}) == Steps(4)
    both = [chosen({"options": name, "action_repeat": 4}) for name in ("seven", OptionSet.seven)]
    assert both == [Options(), Options()]


def test_random_options_are_uniform_and_an_episode_begins_with_a_new_one():
    agent, free = Random(0, Options()), {"collided": False}
    walks = []
    for _ in range(300):
        agent.begin()
        walks.append([agent.act({}, free) for _ in range(17)])
    firsts = [sum((action == LEFT) - (action == RIGHT) for action in walk[:walk.index(FORWARD)]) for walk in walks]
    assert np.bincount([SEVEN.index(turns) for turns in firsts], minlength=7).min() > 25
    other = Random(0)
    drawn = np.random.default_rng([0, 1]).integers(3, size=40).tolist()
    assert [other.act({}, free) for _ in range(40)] == drawn  # the three actions, drawn as they always were
