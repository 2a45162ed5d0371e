"""The table of runs: every run stands in it, with its commits, its last step and what it cost."""

import json

import pytest
from lengths import a_summary

from curionav_cli.results import paper_lengths
from curionav_cli.results.comparison.comparison import compare
from curionav_cli.storage import provenance
from curionav_cli.storage.run_folder import RunFolder

SETTINGS = "seed: {}\nenv: {{name: large_lab}}\nagent: {{name: bounce}}\nrobot: {{name: ideal}}\n"


@pytest.fixture
def a_run(tmp_path, a_plan):
    def make(seed=0, about=None, state="interrupted", rows=()):
        run = RunFolder(tmp_path / str(seed))
        run.create(SETTINGS.format(seed), {}, about or {}, a_plan())
        run.set_status(state=state, error="stopped by SIGTERM")
        run.write_metrics(list(rows))
        return run
    return make


def test_a_row_has_what_the_run_cost_and_where_it_is(a_run):
    seconds = {"cpu_seconds_acting": 600, "cpu_seconds_learning": 1200, "peak_memory": 5 * 10 ** 8}
    run = a_run(about={"git_commit": "6da19c9ee84f"}, rows=[seconds, seconds])
    [row] = paper_lengths.rows(paper_lengths.named(compare([a_summary("large_lab", steps=1000, folder=run.path)])))
    size = sum(path.stat().st_size for path in run.path.rglob("*") if path.is_file())
    assert row == {"env": "large_lab", "arm": "lbs_dreamer", "seed": 0, "steps": 1000, "planned": 600_000, "hours": 1.0,
                   "memory": 0.5, "state": "interrupted", "commit": "6da19c9", "disk": size / 1e9, "error": None,
                   "folder": str(run.path)}


def test_a_run_without_a_finished_episode_stands_there_too(a_run, tmp_path):
    (tmp_path / "nothing").mkdir()
    [row] = paper_lengths.begun_only([a_run(3, state="failed").path, tmp_path / "nothing"])
    assert (row["env"], row["arm"], row["seed"], row["steps"]) == ("large_lab", "bounce", 3, 0)
    assert (row["state"], row["error"], row["commit"]) == ("failed", "stopped by SIGTERM", None)
    (tmp_path / "3" / "run.json").write_text("{")
    assert paper_lengths.noted_commits(tmp_path / "3" / "run.json") == "unreadable"
    (tmp_path / "3" / "run.json").unlink()
    (tmp_path / "3" / "status.json").write_text("{")
    [row] = paper_lengths.rows(paper_lengths.named(compare([a_summary("large_lab", folder=tmp_path / "3")])))
    left = {key: row[key] for key in ("state", "commit", "hours", "memory")}
    assert left == {"state": "unknown", "commit": None, "hours": None, "memory": None}, "what is left of it"


def test_every_commit_that_went_on_is_named_and_from_where():
    about = {"git_commit": "a" * 40, "numpy": "1"}
    assert paper_lengths.commits(about) == "aaaaaaa" and paper_lengths.commits({}) is None
    for episode, commit in ((3, "a"), (255, "b"), (300, "b"), (400, None)):
        line = {"episode": episode, "git_commit": commit and commit * 40}
        about = {**about, "resumed": [*about.get("resumed", ()), line]}
    assert paper_lengths.commits(about) == "aaaaaaa, bbbbbbb from episode 255, unknown from episode 400"


def test_a_resume_is_noted_with_what_is_no_longer_the_same():
    about = {"git_commit": "a", "began": "then", **provenance.versions(), "numpy": "1"}
    once = provenance.resumed(about, "episode", 255)
    twice = json.loads(json.dumps(provenance.resumed(once, "episode", 300)))
    assert {**twice, "resumed": None} == {**about, "resumed": None} and twice["resumed"][0] == once["resumed"][0]
    assert [line["episode"] for line in twice["resumed"]] == [255, 300]
    assert all(line.keys() == {"episode", "at", "git_commit", "git_changed", "numpy"} for line in twice["resumed"])


def test_coverage_stands_at_the_reported_steps_that_a_run_reached():
    run = a_summary("large_lab", steps=40_000, found=(0, 20_000, 35_000))
    [row] = paper_lengths.coverages(paper_lengths.named(compare([run, a_summary("large_lab", steps=10)]))[:1])
    assert row == {"env": "large_lab", "arm": "lbs_dreamer", "seed": 0, "steps": 40_000, "coverage": 0.3,
                   "coverage_at_10000": 0.1, "coverage_at_30000": 0.2, "area_under_curve": pytest.approx(0.1625),
                   "cpu_seconds": 7200.0}


def test_runs_of_one_arm_and_seed_are_drawn_once_and_listed_both():
    comparison = compare([a_summary(steps=10), a_summary(steps=20)])
    assert [one.run.steps for one in paper_lengths.named(comparison)] == [10, 20]
    assert [one.run.steps for one in paper_lengths.drawn(comparison)] == [20]


def test_an_arm_has_the_mean_and_range_of_the_runs_that_went_so_far():
    runs = [a_summary("large_lab", seed=0, steps=40_000, found=(0, 20_000)),
            a_summary("large_lab", seed=1, steps=20_000, found=(0, 5, 6, 7))]
    [row] = paper_lengths.arm_coverages(paper_lengths.drawn(compare(runs)))
    assert row == {"env": "large_lab", "arm": "lbs_dreamer", "n": 2, "coverage_at_10000": "25.0% (10.0% to 40.0%)",
                   "coverage_at_30000": "20.0%, n = 1"}
