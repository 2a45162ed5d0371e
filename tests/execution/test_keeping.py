"""loop.keep removes images that nothing needs any more, changes no result, and says what is gone."""

import signal
from types import SimpleNamespace

import numpy as np
import pytest
from deadly import DEADLY
from leftovers import leftovers
from tiny import LEARNER

from curionav_cli.config.schema import Keep
from curionav_cli.decisions import Steps
from curionav_cli.errors import ConfigError
from curionav_cli.execution.keeping import WHOLE, Keeping, newest_drawn
from curionav_cli.storage import pictures
from curionav_cli.storage.run_folder import RunFolder

HELD = Steps(4)  # of 8 steps the frames 0, 4 and 8 are drawn
RUN = [word for word in LEARNER if "action_repeat" not in word and "episodes" not in word and "loop.steps" not in word]
LIVED = (*RUN, "agent.action_repeat=2", "loop.steps=16", "loop.episodes=5")
PROGRAM = DEADLY + """
from curionav_cli.execution import keeping
from curionav_cli.storage import pictures
keeping.WHOLE = 1
calls = []
if moment == "thinning": at(pictures, "thin", lambda path, frame: calls.append(path) or len(calls) == 3)
if moment == "finishing": at(pictures, "thin", lambda path, frame: calls.append(path) or len(calls) == 7)
app.main()
"""


def held(run, episodes):
    """How many images each of the first episodes has; 9 are all of 8 steps."""
    found = [pictures.kept(run.episode_path(index)) for index in range(episodes)]
    return [9 if one is None else len(one) for one in found]


@pytest.mark.parametrize("drawn, images", [(None, [3, 3, 3, 3]), (0, [0] * 4), (1, [0] * 4), (4, [0, 0, 0, 3]),
                                           (9, [3, 3, 3, 3])], ids=str)
def test_what_is_drawn_no_more_goes_step_by_step_and_all_at_once(tmp_path, an_episode, drawn, images):
    runs = [RunFolder(tmp_path / name) for name in ("steadily", "late", "all")]
    for run, keep in zip(runs, (Keep.replay, Keep.replay, Keep.all), strict=True):
        run.create("", {}, {}, None)
        (run.path / "episodes").mkdir()
        kept = Keeping(run, keep, HELD, drawn)
        for index in range(9):
            episode = an_episode(steps=8, seed=index)
            episode.action[:] = index % 3
            run.save_episode(index, episode)
            if run is not runs[1]:
                kept.after(index + 1)
                kept.after(index + 1)  # after a kill
        kept.catch_up(9)
    assert held(runs[0], 9) == held(runs[1], 9) == images + [9] * WHOLE
    assert held(runs[2], 9) == [9] * 9
    Keeping(runs[0], Keep.poses, HELD, drawn).finish()
    assert held(runs[0], 9) == [0] * 9
    assert all(np.array_equal(*poses) for poses in zip(runs[0].poses(), runs[2].poses(), strict=True))


def test_a_reward_that_counts_all_episodes_refuses_a_bound():
    loop = SimpleNamespace(iterations=1, replay_episodes=3)
    agent = SimpleNamespace(learns=True, on_policy=False, counts=True)
    with pytest.raises(ConfigError, match=r"loop.replay_episodes=3 does not go with .* Set loop.replay_episodes=null"):
        newest_drawn(agent, loop)
    agent.counts = False
    assert newest_drawn(agent, loop) == 3


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_run_keeps_fewer_images_and_is_the_same_run_even_when_killed_while_they_go(tmp_path, warm):
    def run(name, *words, moment="", code=0):
        done = warm(moment, *words, program=PROGRAM)
        assert done.returncode == code, done.stderr
        return leftovers(tmp_path / name), done.stdout

    whole, _ = run("all", "explore", *LIVED, f"hydra.run.dir={tmp_path / 'all'}")
    thinned, said = run("thin", "explore", *LIVED, "loop.keep=replay", f"hydra.run.dir={tmp_path / 'thin'}")
    assert "images are kept of the newest 1 episodes" in said
    same = ("metrics", "status", "replay", *(name for name in whole if name.startswith("checkpoint/") and
                                             "weights" in name))
    assert all(whole[name] == thinned[name] for name in same)
    assert len(thinned["episodes/000000.npz"]) < 0.7 * len(whole["episodes/000000.npz"])
    assert thinned["episodes/000004.npz"] == whole["episodes/000004.npz"]

    killed = ("explore", *LIVED, "loop.keep=replay", f"hydra.run.dir={tmp_path / 'killed'}")
    run("killed", *killed, moment="thinning", code=-signal.SIGKILL)
    assert run("killed", "resume", str(tmp_path / "killed"))[0] == thinned

    left = run("all", "resume", str(tmp_path / "all"), "loop.keep=replay")[0]
    assert {name for name in left if left[name] != thinned[name] and "predictions." not in name} == set()
    run("all", "resume", str(tmp_path / "all"), "loop.keep=poses", moment="finishing", code=-signal.SIGKILL)
    said = run("all", "resume", str(tmp_path / "all"), "loop.keep=poses")[1]
    assert "no image is kept" in said and "the same run, longer" not in said
    assert held(RunFolder(tmp_path / "all"), 5) == [0] * 5

    refused = warm("", "resume", str(tmp_path / "all"), "loop.episodes=9", program=PROGRAM)
    assert refused.returncode == 2 and "holds no image any more (loop.keep)" in refused.stderr
    assert RunFolder(tmp_path / "all").status["state"] == "done"
    refused = warm("", "train", *RUN, "agent.action_repeat=2", f"data={tmp_path / 'all'}", program=PROGRAM)
    assert refused.returncode == 2 and "holds 0 of its 17 images" in refused.stderr
    for words in (("coverage", f"{tmp_path / 'all'}"), ("compare", f"{tmp_path / 'all'}", f"out={tmp_path / 'out'}"),
                  ("train", *RUN, "agent.action_repeat=2", f"data={tmp_path / 'thin'}",
                   f"hydra.run.dir={tmp_path / 'train'}"),
                  ("evaluate", f"{tmp_path / 'all'}", "loop.episodes=2", f"hydra.run.dir={tmp_path / 'evaluated'}")):
        done = warm("", *words, program=PROGRAM)
        assert done.returncode == 0, done.stderr
    for words in (("coverage", f"{tmp_path / 'all'}", "film=0"), ("export", f"{tmp_path / 'all'}", "--to", "mcap")):
        refused = warm("", *words, program=PROGRAM)
        assert refused.returncode == 2 and "holds 0 of its 17 images" in refused.stderr


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_bounded_replay_is_resumed_to_the_same_bytes(tmp_path, warm):
    words = ("explore", *LIVED, "loop.keep=poses", "loop.replay_episodes=1")
    done = warm("", *words, f"hydra.run.dir={tmp_path / 'run'}", program=PROGRAM)
    assert done.returncode == 0 and "the same run, longer" in done.stdout, done.stderr
    killed = warm("thinning", *words, f"hydra.run.dir={tmp_path / 'killed'}", program=PROGRAM)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    done = warm("", "resume", str(tmp_path / "killed"), program=PROGRAM)
    assert done.returncode == 0, done.stderr
    ours, theirs = leftovers(tmp_path / "run"), leftovers(tmp_path / "killed")
    assert [name for name in theirs if ours[name] != theirs[name]] == []
    assert (ours["replay"]["episodes"], ours["replay"]["steps"]) == (1, 16)
    longer = warm("", "resume", str(tmp_path / "run"), "loop.episodes=6", program=PROGRAM)  # no image is needed for it
    assert longer.returncode == 0, longer.stderr
    assert RunFolder(tmp_path / "run").status["episode"] == 6
    changed = warm("", "resume", str(tmp_path / "run"), "loop.replay_episodes=2", program=PROGRAM)
    assert changed.returncode == 2 and "loop.replay_episodes" in changed.stderr
    stored = warm("", *words, "learner=remote", f"storage=file://{tmp_path / 'store'}", program=PROGRAM)
    assert stored.returncode == 2 and "Leave loop.keep=all with a storage" in stored.stderr
