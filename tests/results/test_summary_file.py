"""A summary file says of a run what its folder says: coverage, heatmap, arm, cost and provenance."""

import json

import numpy as np
import pytest

from curionav_cli.commands.export_summary import written
from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays, write_arrays
from curionav_cli.records import Episode
from curionav_cli.results import paper_lengths, unfinished
from curionav_cli.results.comparison.comparison import compare
from curionav_cli.results.comparison.run_summaries import read
from curionav_cli.results.summary_file import COUNTED, SummaryFile, opened
from curionav_cli.storage.run_folder import RunFolder

CONFIG = ("scale: cpu\nseed: 3\nenv: {name: large_lab, changes: true}\nrobot: {name: ideal}\n"
          "agent: {name: lbs_dreamer, curiosity: shuffled}\n")
FIXED = {"agent": {"name": "lbs_dreamer", "curiosity": "shuffled"}, "env": {"changes": True}, "seed": 3}
COST = {"seconds_acting": 1.0, "seconds_learning": 2.0, "cpu_seconds_acting": 0.5, "cpu_seconds_learning": 1.5,
        "updates": 100, "peak_memory": 3 * 10 ** 8}


@pytest.fixture
def a_run(tmp_path, a_plan):
    """a_run(episodes=2): the folder of a run whose episodes go once along a row of cells, each a row higher."""
    def make(episodes=2, about=None, name="run"):
        run = RunFolder(tmp_path / name)
        about = {"git_commit": "c" * 40, "torch": "2", "command": "curionav explore storage=s3://mine", **(about or {})}
        run.create(CONFIG, FIXED, about, a_plan(hole=True))
        for index in range(episodes):
            pose = np.stack([np.linspace(0.05, 0.55, 6), np.full(6, 0.05 + 0.1 * index), np.zeros(6)], axis=1)
            run.save_episode(index, Episode(np.zeros((6, 64, 64, 3), np.uint8), np.zeros(5, np.int64), pose,
                                            np.zeros(5, bool)))
        run.write_metrics([COST] * episodes)
        run.set_status(state="interrupted", episode=episodes, error="stopped by SIGTERM", explored_at=9)
        return run.path
    return make


def test_a_comparison_reads_the_same_of_it(a_run, tmp_path):
    folder = a_run(3)
    file = tmp_path / "out" / written(folder, tmp_path / "out")
    whole, short = read(folder, *COUNTED), read(file, *COUNTED)
    assert whole.steps == 15 and 0 < len(whole.curve.found) < whole.curve.cells
    for name in ("env", "agent", "seed", "preset", "arm", "world", "state", "error", "whole", "gaps", "explored"):
        assert getattr(short, name) == getattr(whole, name), name
    np.testing.assert_array_equal(short.curve.found, whole.curve.found)
    np.testing.assert_array_equal(short.ends, whole.ends)
    assert (short.curve.steps, short.curve.cells) == (whole.curve.steps, whole.curve.cells)
    assert short.spent(15) == pytest.approx(whole.spent(15), nan_ok=True) and short.spent(15)["cpu_seconds"] == 6.0
    assert np.isnan(short.spent(10)["cpu_seconds"]), "only what was spent by the end is known"
    np.testing.assert_array_equal(opened(file).coverage.visits, opened(folder).coverage.visits)
    assert unfinished.visits(short) == unfinished.visits(whole)
    [one], [other] = (paper_lengths.rows(paper_lengths.named(compare([run]))) for run in (short, whole))
    assert one == {**other, "folder": str(file)} and one["commit"] == "ccccccc" and one["disk"] > 0


def test_it_holds_no_command_and_no_folder_and_the_same_bytes_each_time(a_run, tmp_path):
    folder = a_run(about={"config_dirs": ["/home/somebody"], "question": "Why?"})
    file = tmp_path / "out" / written(folder, tmp_path / "out")
    about = SummaryFile.load(file).about
    assert about == {"git_commit": "c" * 40, "torch": "2", "question": "Why?"}
    before = file.read_bytes()
    assert file.name == written(folder, tmp_path / "out") and file.read_bytes() == before
    (folder / "episodes" / "000001.npz").write_bytes(b"cut")
    short = SummaryFile.load(tmp_path / "cut" / written(folder, tmp_path / "cut"))
    assert short.lost.startswith("run/episodes/000001.npz is not whole") and short.lost in short.gaps
    assert not any(str(tmp_path) in line for line in short.gaps)


def test_a_longer_file_of_the_same_run_is_not_overwritten(a_run, tmp_path):
    name = written(a_run(3), tmp_path / "out")
    with pytest.raises(RunFolderError, match=r"holds 15 steps of the same run, and .* has 10"):
        written(a_run(2, name="again"), tmp_path / "out")
    assert int(SummaryFile.load(tmp_path / "out" / name).ends[-1]) == 15
    assert written(a_run(4, name="further"), tmp_path / "out") == name
    assert int(SummaryFile.load(tmp_path / "out" / name).ends[-1]) == 20


def test_what_it_does_not_hold_is_refused_in_a_line(a_run, tmp_path):
    file = tmp_path / "out" / written(a_run(), tmp_path / "out")
    with pytest.raises(RunFolderError, match="visitable cells by landing alone"):
        read(file, "swept", "visitable")
    with pytest.raises(RunFolderError, match="without its episodes"):
        opened(file).poses()
    with pytest.raises(RunFolderError, match="is a summary already"):
        written(file, tmp_path / "other")


@pytest.mark.parametrize("change", [
    {"visits": np.zeros((2, 2), np.uint32)}, {"ends": np.zeros(0, np.int32)}, {"found": np.ones(2, np.int32)},
    {"run": np.array("[]")}, {"run": np.array(json.dumps({"settings": 1}))},
    {"run": np.array(json.dumps({key: {} for key in ("fixed", "about", "status", "spent")}
                                | {"settings": {"env": {}, "agent": {}}}))}])
def test_a_file_that_is_none_is_refused_in_a_line(a_run, tmp_path, change):
    file = tmp_path / "out" / written(a_run(), tmp_path / "out")
    arrays = read_arrays(file, ("found", "ends", "visits", "run", "visitable", "floor", "solid", "numbers"))
    write_arrays(file, arrays | change)
    with pytest.raises(RunFolderError, match="does not hold what it should"):
        read(file, *COUNTED)
    file.write_bytes(file.read_bytes()[:200])
    with pytest.raises(RunFolderError, match="is not whole"):
        read(file, *COUNTED)


def test_a_broken_file_in_its_place_is_not_overwritten_and_the_line_says_what_to_do(a_run, tmp_path):
    folder = a_run()
    file = tmp_path / "out" / written(folder, tmp_path / "out")
    file.write_bytes(b"cut")
    with pytest.raises(RunFolderError, match=r"is not whole .* Or remove it, and export .*run again"):
        written(folder, tmp_path / "out")
    assert file.read_bytes() == b"cut"


def test_a_test_of_docking_is_named_as_one(a_run):
    folder = a_run(0)
    RunFolder(folder).write_metrics([{"code": 1}])
    RunFolder(folder).set_status(state="done")
    with pytest.raises(RunFolderError, match=r"is a test of docking \(curionav dock\), which counts no coverage"):
        read(folder, *COUNTED)
