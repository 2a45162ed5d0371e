"""Gymnasium's own wrappers, those that need other packages too."""

from __future__ import annotations

import pytest

pytestmark = [pytest.mark.clients, pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::SyntaxWarning")]
ROOM = "curionav/SmallRoom-v0"


def test_a_film(made, tmp_path) -> None:
    pytest.importorskip("moviepy")
    import cv2
    from gymnasium.wrappers import RecordVideo

    env = RecordVideo(made(ROOM, render_mode="rgb_array", max_episode_steps=5), str(tmp_path / "film"), lambda _: True)
    env.reset(seed=0)
    for _ in range(5):
        env.step(1)
    env.close()
    film = cv2.VideoCapture(str(next(tmp_path.glob("film/*.mp4"))))
    assert [film.get(key) for key in (cv2.CAP_PROP_FRAME_COUNT, cv2.CAP_PROP_FRAME_WIDTH)] == [6, 64]


def test_tensors(made) -> None:
    """Info too: no string and no numpy bool is in it, which gymnasium cannot convert."""
    pytest.importorskip("array_api_compat")
    import torch
    from gymnasium.wrappers import NumpyToTorch

    env = NumpyToTorch(made(ROOM))
    _, told = env.reset(seed=0)
    _, _, _, _, info = env.step(torch.tensor(0))
    assert {key: value.dtype for key, value in info.items()} == {key: value.dtype for key, value in told.items()} == {
        "pose": torch.float64, "collided": torch.bool, "episode_index": torch.int64}
