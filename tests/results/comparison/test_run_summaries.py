"""Run folders as a comparison reads them: what is missing is named, what is there is counted."""

import json

import numpy as np
import pytest

from curionav_cli.errors import RunFolderError
from curionav_cli.results import integrity
from curionav_cli.results.comparison.run_summaries import folders, read
from curionav_cli.results.coverage import Coverage, cover
from curionav_cli.storage.run_folder import RunFolder


@pytest.fixture
def a_run(tmp_path, an_episode, a_plan):
    """Four episodes of five steps in a sweep's folder."""
    def make(name="0_room_random_0", state="done"):
        run = RunFolder(tmp_path / "sweep" / name)
        fixed = {"env": {"name": "room"}, "agent": {"name": "random"}, "loop": {"steps": 5}, "seed": 3}
        run.create("seed: 3\nenv: {name: room}\nagent: {name: random}\nrobot: {name: ideal}\nscale: cpu\n",
                   fixed, {}, a_plan(9, 9))
        for n in range(4):
            run.save_episode(n, an_episode(steps=5, seed=n))
            run.append_metrics({"episode": n, "seconds_acting": 1.0, "seconds_learning": 2.0, "updates": 10 * (n + 1)})
        run.set_status(state=state, error=None, episode=4)
        return run
    return make


def test_a_whole_run_is_read_as_coverage_counts_it(a_run):
    run = a_run()
    summary = read(run.path, "landing", "visitable")
    assert summary.whole and not summary.gaps and summary.ends.tolist() == [0, 5, 10, 15, 20]
    np.testing.assert_array_equal(summary.curve.found, cover(run.plan, run.poses()).curve().found)
    assert (summary.env["name"], summary.agent, summary.seed, summary.preset) == ("room", "random", 3, "cpu")
    assert summary.spent(20)["seconds"] == 12 and summary.spent(6)["updates"] == 20
    assert np.isnan(summary.spent(5)["cpu_seconds"]) and summary.arm["loop.steps"] == 5


def test_memory_is_the_most_of_all_parts_and_unknown_of_a_run_that_did_not_note_it(a_run):
    run = a_run()
    assert np.isnan(read(run.path, "landing", "visitable").spent(20)["memory"])
    noted = ({}, {"peak_memory": 2e9}, {"peak_memory": 3e9}, {"peak_memory": 1e9})  # resumed before the last
    run.write_metrics([row | more for row, more in zip(run.metrics(), noted)])
    summary = read(run.path, "landing", "visitable")
    assert [summary.spent(steps)["memory"] for steps in (10, 15, 20)] == [2.0, 3.0, 3.0]
    assert np.isnan(summary.spent(5)["memory"])


def note(run):
    """Rows of metrics that a run of today writes; what it counts by another rule is not in them."""
    coverage, rows = Coverage(run.plan), run.metrics()
    for row, pose in zip(rows, run.poses()):
        coverage.add(pose)
        row |= {"steps": coverage.steps, "visited": coverage.visited, "found": coverage.first[-1].tolist()}
    run.write_metrics(rows)


def test_a_run_that_noted_what_it_found_is_told_without_opening_an_episode(a_run, monkeypatch):
    run = a_run()
    counted = read(run.path, "landing", "visitable")
    note(run)
    by_floor = read(run.path, "landing", "floor")
    monkeypatch.setattr(integrity, "read_arrays", lambda *_: pytest.fail("an episode was opened"))
    summary = read(run.path, "landing", "visitable")
    np.testing.assert_array_equal(summary.curve.found, counted.curve.found)
    assert (summary.curve.steps, summary.curve.total) == (counted.curve.steps, counted.curve.total)
    assert summary.ends.tolist() == counted.ends.tolist() and summary.whole and not summary.gaps
    assert by_floor.curve.total == run.plan.floor.sum()


@pytest.mark.parametrize("change", [
    lambda rows: rows[2].update(found=[*rows[2]["found"], 12]), lambda rows: rows[2].pop("found"),
    lambda rows: rows[0].update(found=rows[0]["found"][::-1]), lambda rows: rows[1].update(steps=None),
    lambda rows: rows[1].update(found="7"), lambda rows: rows[3].update(episode=2), lambda rows: rows.pop(),
    lambda rows: rows[0].update(found=[2 ** 70] * rows[0]["visited"]), lambda rows: rows[3].update(steps=15),
])
def test_what_a_run_noted_and_cannot_be_is_counted_again(a_run, change):
    run = a_run()
    counted = read(run.path, "landing", "visitable")
    note(run)
    rows = run.metrics()
    change(rows)
    run.write_metrics(rows)
    again = read(run.path, "landing", "visitable")
    np.testing.assert_array_equal(again.curve.found, counted.curve.found)
    assert again.ends.tolist() == counted.ends.tolist()


@pytest.mark.parametrize(("harm", "said", "steps"), [
    (lambda run: run.episode_path(1).unlink(), "000001.npz is missing. Shown up to there, 5 steps.", 5),
    (lambda run: run.episode_path(3).unlink(), "000003.npz is missing. Shown up to there, 15 steps.", 15),
    (lambda run: run.episode_path(2).write_bytes(b"PK"), "000002.npz is not whole", 10),
])
def test_a_missing_episode_ends_what_is_shown(a_run, harm, said, steps):
    run = a_run()
    if "missing" in said:
        note(run)
    harm(run)
    summary = read(run.path, "landing", "visitable")
    [gap] = summary.gaps
    assert said in gap and "\n" not in gap and summary.steps == summary.curve.steps == steps and not summary.whole


def test_a_torn_line_costs_the_budget_only(a_run):
    run = a_run()
    run.metrics_file.write_text(run.metrics_file.read_text()[:-20])
    summary = read(run.path, "landing", "visitable")
    assert summary.whole and summary.steps == 20 and "metrics.jsonl: line 4 is torn" in summary.gaps[0]
    assert summary.spent(15)["seconds"] == 9 and np.isnan(summary.spent(20)["seconds"])


def test_an_episode_that_a_run_adds_meanwhile_is_not_missing(a_run, an_episode, monkeypatch):
    run, listed = a_run(), RunFolder.episode_paths

    def then_saved(self):
        paths = listed(self)
        run.save_episode(4, an_episode(steps=5))
        return paths
    monkeypatch.setattr(RunFolder, "episode_paths", then_saved)
    summary = read(run.path, "swept", "visitable")
    assert (summary.steps, summary.gaps) == (20, ()), summary.gaps


def test_a_broken_status_is_named_and_the_rest_shown(a_run):
    run = a_run()
    (run.path / "status.json").write_text("{")
    summary = read(run.path, "landing", "visitable")
    assert summary.state == "unknown" and not summary.whole and "status.json cannot be read" in summary.gaps[0]
    assert summary.steps == 20


@pytest.mark.parametrize(("harm", "said"), [
    (lambda run: (run.path / "config.yaml").unlink(), "did not begin"),
    (lambda run: (run.path / "fixed.json").unlink(), "fixed.json cannot be read"),
    (lambda run: (run.path / "plan.npz").write_bytes(b""), "plan.npz is not whole"),
    (lambda run: run.episode_path(0).unlink(), "has no finished episode (done); .*000000.npz is missing"),
])
def test_of_what_is_left_nothing_can_be_shown(a_run, harm, said):
    run = a_run()
    harm(run)
    with pytest.raises(RunFolderError, match=said.replace("(done)", r"\(done\)")):
        read(run.path, "landing", "visitable")


def test_the_jobs_of_a_sweep_in_their_order_and_those_that_never_began(a_run, tmp_path):
    names = ["0_room_random_0", "2_room_random_2", "10_room_random_10"]
    for name in names:
        a_run(name)
    (tmp_path / "sweep" / "3_room_random_3" / ".hydra").mkdir(parents=True)
    (tmp_path / "sweep" / "figures").mkdir()
    assert [job.name for job in folders(tmp_path / "sweep")] == [*names[:2], "3_room_random_3", names[2]]
    assert folders(tmp_path / "sweep" / names[0]) == [tmp_path / "sweep" / names[0]]
    for path, said in ((tmp_path, "holds neither a run nor a sweep"), (tmp_path / "nowhere", "There is no folder")):
        with pytest.raises(RunFolderError, match=said):
            folders(path)


def test_an_array_that_is_not_row_by_row_is_read_as_it_was_written(a_run, an_episode, tmp_path):
    episode = an_episode(steps=6)
    turned = type(episode)(episode.image, episode.action, np.asfortranarray(episode.pose), episode.collided)
    turned.save(tmp_path / "turned.npz")
    back = type(episode).load(tmp_path / "turned.npz")
    np.testing.assert_array_equal(back.pose, episode.pose)
    assert back.image.flags.writeable and json.dumps(back.events) == "[]"
