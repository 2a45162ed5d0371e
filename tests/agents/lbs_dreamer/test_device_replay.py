"""A batch is the same wherever its frames come from."""

import numpy as np
import pytest
import torch

from curionav_cli.agents.lbs_dreamer import agent as agent_module
from curionav_cli.agents.lbs_dreamer.device_replay import DeviceReplay
from curionav_cli.records import Episode
from curionav_cli.storage.replay import Replay

CPU = torch.device("cpu")
FRAME = 64 * 64 * 3


def episode(steps, seed):
    rng = np.random.default_rng(seed)
    image = rng.integers(0, 256, (steps + 1, 64, 64, 3), np.uint8)
    return Episode(image, rng.integers(0, 3, steps), rng.random((steps + 1, 3)), np.zeros(steps, bool))


def batches(frames, length, count):
    rng = np.random.default_rng(5)
    return [frames.windows(*frames.replay.draw(6, length, rng), length) for _ in range(count)]


@pytest.mark.parametrize("room", [0, 20 * FRAME, 45 * FRAME, 10**9], ids=["none", "one", "two", "all"])
def test_a_batch_is_what_the_host_samples(room):
    replay = Replay([episode(steps, steps) for steps in (19, 24, 9, 30)], memory=40 * FRAME)
    frames, rng = DeviceReplay(replay, CPU, room), np.random.default_rng(5)
    frames.follow()
    assert len(frames.episodes) == {0: 0, 20: 1, 45: 2}.get(room // FRAME, 4)
    for found in batches(frames, 7, 12):  # all are kept: no batch may be overwritten by a later one
        np.testing.assert_array_equal(found.transpose(0, 1), replay.sample(6, 7, rng)["image"])
    replay.close()


def test_new_episodes_follow_until_the_room_is_taken_and_that_is_said_once(caplog):
    replay = Replay([episode(9, 0)])
    frames = DeviceReplay(replay, CPU, 25 * FRAME)
    for count in (1, 2, 2, 2):
        frames.follow()
        assert len(frames.episodes) == count
        replay.add(episode(9, 1 + count))
    assert [record.getMessage() for record in caplog.records] == [
        "The GPU holds the first 2 episodes; frames of later ones are sent for every update, which is slower."]


def test_what_is_learned_does_not_depend_on_where_the_frames_are(agent, replay, monkeypatch):
    learned = []
    for room in (0, 30 * FRAME, 10**9):
        monkeypatch.setattr(agent_module, "room_on", lambda device, room=room: room)
        made, store = agent(), replay()
        learned.append([made.learn(store, 3, lambda done: None), made.learn(store, 2, lambda done: None)])
        made.learn(replay(episodes=1), 1, lambda done: None)  # another replay, none of the first one's frames
        learned[-1].append(made.learner.networks.state_dict()["world_model.decoder.dense.weight"].tolist())
    assert learned[0] == learned[1] == learned[2]
