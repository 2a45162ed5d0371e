"""Random bytes in bags of every format: episodes or one line, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest
from altered import in_a_process
from drives import Drive, mcap, ros1, ros2
from rosbags.rosbag2 import StoragePlugin

from curionav_cli.bags import source
from curionav_cli.bags.export import Form, write


@pytest.fixture
def bags(tmp_path: Path, an_episode) -> list[tuple[Path, str]]:
    """A small bag of each format, with the file that is altered in it."""
    drive = Drive([(3.0, 0.2, 0.0)], odometry=20.0, images=5.0, side=8)
    (tmp_path / "made").mkdir()
    made = tmp_path / "made"
    write(made / "own", an_episode(steps=4), 0, Form(source.named("turtlebot4"), True, 10.0, 0.3), None, None, {})
    return [(mcap(made / "a", drive), ""), (ros1(made / "b.bag", drive), ""), (made / "own" / "own.mcap", ""),
            (ros2(made / "c", drive, StoragePlugin.SQLITE3), "c.db3"), (ros2(made / "d", drive), "metadata.yaml")]


def test_a_few_hundred_altered_bags(tmp_path: Path, bags) -> None:
    outcomes, wrong = in_a_process(bags, tmp_path, 0, 300)
    assert not wrong, "\n".join(wrong[:3])
    assert sum(outcomes.values()) == 300
    assert all(outcomes[f"{bag.name}: a line"] > 5 for bag, _ in bags), outcomes


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 9))
def test_thousands_of_altered_bags(tmp_path: Path, bags, seed: int) -> None:
    outcomes, wrong = in_a_process(bags, tmp_path, seed, 1500)
    assert not wrong, "\n".join(wrong[:3])
    assert sum(outcomes.values()) == 1500
