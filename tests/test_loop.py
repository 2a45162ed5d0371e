"""The loop: the order of its calls, and what an episode holds."""

import gymnasium
import numpy as np
import pytest

from curionav_cli.agents.agent import Agent
from curionav_cli.loop import Callbacks, LocalLearner, NoLearning, run_episodes
from curionav_cli.records import Prediction, Surprise
from curionav_cli.storage.replay import Replay


class Line(gymnasium.Env):
    """An environment of one dimension that notes every call; its image is the number of steps since the start."""

    def __init__(self, calls):
        self.calls, self.episode, self.x = calls, -1, 0

    def observe(self, collided=False):
        info = {"pose": np.array([self.x, 0.0, 0.0]), "collided": collided, "episode_index": self.episode}
        return {"image": np.full((64, 64, 3), self.x, np.uint8)}, info

    def reset(self, *, seed=None, options=None):
        self.calls.append(("reset", seed, options))
        self.episode = options["episode"] if options else self.episode + 1
        self.x, self.events = 0, ({"episode": self.episode},)
        return self.observe()

    def step(self, action):
        self.x += action
        observation, info = self.observe(collided=action == 0)
        return observation, 0.0, False, False, info


PREDICTION = Prediction(np.array([1]), np.array([[3]]), np.zeros((1, 1, 64, 64, 3), np.uint8),
                     error=np.array([[0.25], [0.75]], np.float32), repeat=np.array([[1.0], [0.0]], np.float32),
                     surprise=Surprise(*np.zeros((3, 1, 1), np.float32)))


class Counter(Agent):
    """Acts 1, 0, 1, 0 ... and learns by noting what it was given."""

    learns = True

    def __init__(self, calls):
        super().__init__(0)
        self.calls, self.t = calls, 0

    def begin(self):
        self.calls.append("begin")
        self.t = 0

    def act(self, observation, info):
        self.t += 1
        return self.t % 2

    def predict(self, index, episode):
        self.calls.append(("predict", index, len(episode)))
        return PREDICTION if index == 1 else None

    def learn(self, replay, iterations, tick):
        self.calls.append(("learn", replay.steps, iterations))
        for i in range(iterations):
            tick(i + 1)
        return {"loss": 0.5}


class Notes(Callbacks):
    """Callbacks that keep everything."""

    def __init__(self):
        self.steps, self.iterations, self.episodes, self.predictions = [], [], [], []

    def acted(self, step):
        self.steps.append(step)

    def predicted(self, index, prediction):
        self.predictions.append((index, prediction))

    def learned(self, iteration):
        self.iterations.append(iteration)

    def episode_done(self, index, episode, metrics):
        self.episodes.append((index, episode, metrics))


@pytest.fixture
def looped():
    def run(first=0, episodes=3):
        calls, notes, stored = [], Notes(), []
        agent = Counter(calls)
        learn = LocalLearner(agent, Replay(), 2, notes, lambda index, episode: stored.append(index))
        run_episodes(Line(calls), agent, learn, episodes=episodes, steps=4, seed=7, watch=notes, first=first)
        return calls, notes, stored
    return run


def test_steps_then_iterations_then_return_to_dock(looped):
    calls, notes, stored = looped()
    reset, home = ("reset", 7, {"episode": 0}), ("reset", None, None)
    assert calls == [reset, "begin", ("predict", 0, 4), ("learn", 4, 2), home, "begin", ("predict", 1, 4),
                     ("learn", 8, 2), home, "begin", ("predict", 2, 4), ("learn", 12, 2)]
    assert notes.steps == [1, 2, 3, 4] * 3 and notes.iterations == [1, 2] * 3 and stored == [0, 1, 2]


def test_a_robot_may_end_on_its_dock() -> None:
    calls, began = [], []

    class Begun(Callbacks):
        def began(self, index, info):
            began.append((index, info["episode_index"]))

    run_episodes(Line(calls), Counter(calls), NoLearning(), episodes=4, steps=2, seed=7, watch=Begun(), first=2,
                 return_after_last=True)
    home = ("reset", None, None)
    assert calls == [("reset", 7, {"episode": 2}), "begin", home, "begin", home]
    assert began == [(2, 2), (3, 3), (4, 4)]


def test_an_episode_holds_the_observations_before_and_after_each_action(looped):
    _, notes, _ = looped()
    index, episode, metrics = notes.episodes[1]
    assert index == 1 and len(episode) == 4 and episode.events == ({"episode": 1},)
    assert episode.action.tolist() == [1, 0, 1, 0] and episode.collided.tolist() == [False, True, False, True]
    assert episode.image[:, 0, 0, 0].tolist() == [0, 1, 1, 2, 2] == episode.pose[:, 0].tolist()
    assert metrics["loss"] == 0.5
    assert all(metrics[f"{kind}seconds_{what}"] >= 0 for kind in ("", "cpu_") for what in ("acting", "learning"))


def test_an_episode_is_predicted_before_it_is_learned_and_its_errors_are_noted(looped):
    _, notes, _ = looped()
    assert notes.predictions == [(1, PREDICTION)]
    errors = [{k: v for k, v in metrics.items() if "mse" in k} for _, _, metrics in notes.episodes]
    assert errors == [{}, {"open_loop_mse_1": 0.5, "repeat_mse_1": 0.5}, {}]


def test_a_run_can_begin_at_a_later_episode(looped):
    calls, notes, _ = looped(first=2)
    assert calls[0] == ("reset", 7, {"episode": 2}) and [index for index, _, _ in notes.episodes] == [2]
