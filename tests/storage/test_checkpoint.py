"""A checkpoint is whole or absent; other settings are refused by name."""

import pytest

from curionav_cli.errors import RunFolderError
from curionav_cli.storage import checkpoint

SETTINGS = {"env": {"name": "small_room", "radius": 0.18}, "agent": {"name": "random"}, "seed": 0}


def write(text):
    return lambda folder: (folder / "state").write_text(text)


def test_the_newest_whole_one_counts_and_two_are_kept(tmp_path):
    assert checkpoint.newest(tmp_path, SETTINGS) is None
    for n in (1, 2, 3):
        checkpoint.save(tmp_path, n, SETTINGS, write(str(n)))
    assert [folder.name for folder in checkpoint.finished(tmp_path)] == ["000002", "000003"]
    (tmp_path / "000004").mkdir()  # no `done`: a save that was cut short
    episodes, folder = checkpoint.newest(tmp_path, SETTINGS)
    assert episodes == 3 and (folder / "state").read_text() == "3"


def test_a_save_that_dies_leaves_the_one_before(tmp_path):
    checkpoint.save(tmp_path, 1, SETTINGS, write("1"))

    def dies(folder):
        (folder / "state").write_text("half")
        raise KeyboardInterrupt
    with pytest.raises(KeyboardInterrupt):
        checkpoint.save(tmp_path, 2, SETTINGS, dies)
    assert checkpoint.newest(tmp_path, SETTINGS)[0] == 1
    checkpoint.save(tmp_path, 2, SETTINGS, write("2"))
    assert (checkpoint.newest(tmp_path, SETTINGS)[1] / "state").read_text() == "2"


@pytest.mark.parametrize(("change", "said"), [
    ({"agent": {"name": "bounce"}}, 'agent.name was "random", now "bounce"'),
    ({"env": {"name": "small_room", "radius": 0.2}}, "env.radius was 0.18, now 0.2"),
    ({"seed": 1}, "seed was 0, now 1"),
])
def test_changed_settings_are_refused_by_name(tmp_path, change, said):
    checkpoint.save(tmp_path, 1, SETTINGS, write("1"))
    with pytest.raises(RunFolderError) as refused:
        checkpoint.newest(tmp_path, {**SETTINGS, **change})
    assert said in str(refused.value) and "\n" not in str(refused.value)
