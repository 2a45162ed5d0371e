"""A run folder names what is missing, and is rewound to its last finished episode."""

import pytest

from curionav_cli.errors import RunFolderError
from curionav_cli.storage.run_folder import RunFolder


@pytest.fixture
def run(tmp_path, an_episode, a_plan):
    """A run of three finished episodes."""
    run = RunFolder(tmp_path / "run")
    run.create("seed: 0\n", {}, {"command": "test"}, a_plan())
    for n in range(3):
        run.save_episode(n, an_episode(steps=4))
        run.append_metrics({"episode": n, "steps": 4 * (n + 1)})
    return run


def test_what_is_written_is_read(run):
    run.set_status(state="running", episode=1)
    run.set_status(state="done")
    assert run.status == {"state": "done", "episode": 1}
    assert [row["steps"] for row in run.metrics()] == [4, 8, 12]
    assert [pose.shape for pose in run.poses()] == [(5, 3)] * 3
    assert RunFolder.existing(run.path).plan.cell == run.plan.cell


def test_rewind_removes_what_came_after(run):
    with open(run.metrics_file, "a") as file:
        file.write('{"episode": 3, "st')  # torn
    run.rewind(2)
    assert [path.name for path in run.episode_paths()] == ["000000.npz", "000001.npz"]
    assert run.metrics_file.read_text() == '{"episode": 0, "steps": 4}\n{"episode": 1, "steps": 8}\n'


def test_what_is_missing_is_named(run, tmp_path):
    run.episode_path(1).unlink()
    with pytest.raises(RunFolderError, match=r"000001\.npz is missing"):
        run.rewind(3)
    with pytest.raises(RunFolderError, match="There is no folder"):
        RunFolder.existing(tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    with pytest.raises(RunFolderError, match="holds no run: it has no config"):
        RunFolder.existing(tmp_path / "empty")
    (run.path / "status.json").write_text('{"sta')
    with pytest.raises(RunFolderError, match="cannot be read"):
        _ = run.status


def test_too_few_metrics_are_refused(run):
    run.metrics_file.write_text('{"episode": 0}\n')
    with pytest.raises(RunFolderError, match="ends after 1 of 3 episodes"):
        run.rewind(3)
