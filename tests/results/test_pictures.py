"""Pictures and tables from a run folder: the same bytes when drawn again, nothing left out."""

import csv
import io

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from curionav_cli.errors import RunFolderError
from curionav_cli.results import plots, tables
from curionav_cli.results.runs import Run, distinguish
from curionav_cli.storage.run_folder import RunFolder


@pytest.fixture
def a_run(tmp_path, an_episode, a_plan):
    """a_run("bounce"): a finished run of two episodes."""
    def make(agent="random", seed=0):
        run = RunFolder(tmp_path / f"{agent}_{seed}")
        run.create(f"seed: {seed}\nenv: {{name: small_room}}\nagent: {{name: {agent}}}\nrobot: {{name: ideal}}\n",
                   {}, {}, a_plan(9, 9))
        for n in range(2):
            run.save_episode(n, an_episode(steps=6, seed=n))
            run.append_metrics({"episode": n, "cancelled": 0.25 * n, "seconds_acting": 1.0, "seconds_learning": 2.0})
        run.set_status(state="done", error=None)
        return Run.open(run.path)
    return make


def test_a_picture_drawn_again_is_the_same_file(tmp_path, a_run):
    for turn in ("one", "two"):
        folder = tmp_path / turn
        folder.mkdir()
        run = a_run()
        plots.save(plots.heatmap(run.coverage, run.label), folder / "heatmap.png")
        plots.save(plots.curves([run, a_run("bounce")], "two runs"), folder / "coverage.png")
        plots.save(plots.heatmaps([run, a_run("bounce")]), folder / "heatmaps.png")
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert names == [f"{n}.{kind}" for n in ("coverage", "heatmap", "heatmaps") for kind in ("pdf", "png")]
    for name in names:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_the_heatmap_shows_visits_and_the_start(a_run):
    run = a_run()
    figure = plots.heatmap(run.coverage, "title")
    plan, visits, walls = figure.axes[0].images
    np.testing.assert_array_equal(visits.get_array().filled(0), run.coverage.visits)
    [square] = [line for line in figure.axes[0].lines if line.get_label() == "start and dock"]
    assert to_rgb(square.get_color()) == to_rgb("#1d4ed8") and square.get_marker() == "s"
    assert (square.get_xdata()[0], square.get_ydata()[0]) == run.plan.start[:2]
    assert plan.get_extent() == visits.get_extent() == walls.get_extent() == pytest.approx([0.0, 0.9, 0.0, 0.9])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["start and dock", "can be reached"]


def test_the_curve_ends_at_the_count_and_the_dotted_line_is_the_maximum(a_run):
    run = a_run()
    axes = plots.curves([run], "title").axes[0]
    line, maximum = axes.lines
    assert line.get_ydata()[-1] == run.coverage.visited and line.get_xdata()[-1] == 12
    assert set(maximum.get_ydata()) == {run.coverage.total} and maximum.get_linestyle() == ":"


def test_every_agent_has_a_look_of_its_own():
    every = [*plots.STYLES.values(), *plots.OTHERS]
    for part in ("color", "dashes", "marker"):
        assert len({str(getattr(look, part)) for look in every}) == len(every)


def test_a_row_counts_what_the_episodes_hold(a_run):
    run = a_run()
    row = run.row()
    actions, collided = (np.concatenate([np.load(path)[part] for path in run.folder.episode_paths()])
                         for part in ("action", "collided"))
    assert row["steps"] == 12 and row["visited"] == run.coverage.visited and row["cells"] == 81
    assert [row["forward"], row["left"], row["right"]] == [float((actions == a).mean()) for a in range(3)]
    assert row["cancelled"] == collided.sum() / (actions == 0).sum()
    assert row["seconds_learning"] == 4.0 and row["steps_to_90"] is None


def test_tables_name_rule_and_denominator_and_csv_keeps_every_number(a_run):
    rows = [a_run("random").row(), a_run("bounce").row()]
    text = tables.markdown(rows)
    assert "marked by landing, out of visitable cells" in text
    assert len([line for line in text.splitlines() if line.startswith("| small_room")]) == 2 and "| - |" in text
    back = list(csv.DictReader(io.StringIO(tables.comma_separated(rows))))
    assert [float(row["coverage"]) for row in back] == [row["coverage"] for row in rows]
    assert back[0]["steps_to_90"] == ""


def test_what_is_no_run_is_refused(tmp_path):
    with pytest.raises(RunFolderError, match="holds no run"):
        Run.open(tmp_path)


def test_variants_of_one_agent_are_distinguished(tmp_path, a_run):
    runs = [a_run("cbet", seed) for seed in range(3)] + [a_run("random", seed) for seed in (0, 1)]
    for run, view in zip(runs, ("pano", "ego", "ego"), strict=False):
        run.config["agent"] |= {"view": view, "lr": 0.1, "reward": "cbet"}
    distinguish(runs)
    names = ["cbet view=pano", "cbet view=ego", "cbet view=ego", "random", "random"]
    assert [run.agent for run in runs] == names and runs[1].row()["agent"] == "cbet view=ego"
    looks = plots.looks({run.agent: run.config["agent"]["name"] for run in runs})
    assert list(looks) == names[:1] + names[2:4] and len(set(looks.values())) == 3
    axes = plots.curves(runs, "title").axes[0]
    assert [line.get_label() for line in axes.lines if not line.get_label().startswith("_")] == list(looks)
    distinguish(runs[1:])
    assert runs[1].agent == "cbet"
