"""curionav paper figures and paper changes on run folders that go on, failed, or have not finished an episode."""

from __future__ import annotations

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from entry import Cli

from curionav_cli.results import paper_kept
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.page_blocks import block
from curionav_cli.storage.run_folder import RunFolder

SETTINGS = ("seed: 0\nenv: {{name: large_lab, changes: {changes}}}\nagent: {{name: {agent}}}\nrobot: {{name: ideal}}\n")


@pytest.fixture
def sweep(tmp_path, an_episode, a_plan):
    """Runs of two episodes, with changes and without, one that failed after them, and one that failed before."""
    moved = ({"what": "move", "item": "chair", "from": [0.3, 0.3], "to": [9.0, 9.0]},)
    for name, agent, changes, state, episodes in (
            ("0_a", "bounce", True, "done", 2), ("1_b", "bounce", False, "done", 2),
            ("2_c", "lbs_dreamer", True, "failed", 2), ("3_d", "random", True, "failed", 0)):
        run, fixed = RunFolder(tmp_path / "sweep" / name), {"agent": {"name": agent}, "env": {"changes": changes}}
        config = SETTINGS.format(agent=agent, changes=str(changes).lower())
        run.create(config, fixed, {"git_commit": "c" * 40}, a_plan())
        (run.path / "episodes").mkdir(exist_ok=True)
        for index in range(episodes):
            events = moved if changes and index else ()
            run.save_episode(index, replace(an_episode(steps=3), events=events))
        run.set_status(state=state, episode=episodes, error="out of memory" if state == "failed" else None)
    return tmp_path / "sweep"


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


@pytest.mark.slow
@pytest.mark.usefixtures("painted")
def test_every_run_stands_in_the_tables_and_every_figure_is_drawn(cli: Cli, sweep: Path, tmp_path: Path) -> None:
    marks = "\n".join(block("figures", name) for name in ("runs", "pictures", "against"))
    (tmp_path / "page.md").write_text(f"# Mine\n\n{marks}\n\nAnd mine.\n")
    answer = cli("paper", "figures", "sweep", "out=out", "page=page.md")
    assert answer.code == 0, answer.error
    page = (tmp_path / "page.md").read_text()
    assert page.startswith("# Mine\n") and page.endswith("\n\nAnd mine.\n") and "\n\n| env | arm | seed |" in page
    assert "](out/large_lab.png)" in page and str(tmp_path) not in page
    found = rows(tmp_path / "out" / "runs.csv")
    assert [(row["arm"], row["steps"], row["state"], row["error"], row["commit"]) for row in found] == [
        ("bounce", "6", "done", "", "ccccccc"), ("lbs_dreamer", "6", "failed", "out of memory", "ccccccc"),
        ("bounce", "6", "done", "", "ccccccc"),  # of the world without changes
        ("random", "0", "failed", "out of memory", "ccccccc")]
    assert "Not finished (failed): large_lab, random, seed 0, 0 steps" in answer.out
    verdicts = rows(tmp_path / "out" / "verdicts.csv")
    assert len(verdicts) == 8 and {row["verdict"] for row in verdicts} == {"not decided"}
    assert verdicts[0]["n"] == "1 of 2" and float(verdicts[0]["low"]) > 0
    assert [row["steps"] for row in rows(tmp_path / "out" / "against.csv")] == ["6"]
    for name in ("large_lab_arms.png", "large_lab.png", "best_large_lab_changes=true.png"):
        assert (tmp_path / "out" / name).stat().st_size > 1000, name


@pytest.mark.slow
@pytest.mark.usefixtures("painted")
def test_changes_on_less_off_stand_in_a_table_and_a_figure(cli: Cli, sweep: Path, tmp_path: Path) -> None:
    answer = cli("paper", "changes", "sweep", "out=out")
    assert answer.code == 0, answer.error
    [pair] = rows(tmp_path / "out" / "change_pairs.csv")
    assert (pair["agent"], pair["n"], pair["steps"], pair["cost"]) == ("bounce", "1", "6", "one pair: not decided")
    assert float(pair["near_on"]) == float(pair["near_off"]) == pytest.approx(0.5), "in the second episode"
    assert np.isfinite(float(pair["coverage"])) and (tmp_path / "out" / "changes_large_lab.png").stat().st_size > 1000


@pytest.mark.parametrize("what", ["figures", "changes"])
def test_no_run_is_one_clear_line(cli: Cli, tmp_path: Path, what: str) -> None:
    answer = cli("paper", what, "nowhere", "out=out")
    assert answer.code == 2 and f"curionav paper {what} outputs" in answer.error, answer.error
    assert "There is no folder nowhere." in answer.error
    assert not (tmp_path / "out").exists() and "Traceback" not in answer.error


def test_an_episode_that_is_cut_is_named(cli: Cli, sweep: Path) -> None:
    episode = RunFolder(sweep / "0_a").episode_path(1)
    episode.write_bytes(episode.read_bytes()[:-30])
    drawn = cli("paper", "figures", "sweep/0_a", "out=out")
    assert drawn.code == 0 and f"GAP: {Path('sweep/0_a/episodes/000001.npz')}" in drawn.out, drawn
    refused = cli("paper", "changes", "sweep/0_a", "out=none")
    assert refused.code == 2 and "GAP: " in refused.error and "Nothing moved" in refused.error
    assert not Path("none").exists()
    alone = cli("paper", "changes", "sweep/2_c", "out=out")
    assert alone.code == 0 and "no two of these runs have the same agent and seed" in alone.out


def test_what_does_not_learn_is_no_run_of_the_papers_agent(cli: Cli, tmp_path: Path, an_episode, a_plan) -> None:
    """An evaluation of it, and a folder that is done without an episode, as a training and a test of docking are."""
    config = SETTINGS.format(agent="lbs_dreamer", changes="true")
    for name, more, episodes in (("learner", {}, 1), ("frozen", {"training seed": 0}, 1), ("trained", {}, 0)):
        run = RunFolder(tmp_path / name)
        run.create(config, {"agent": {"name": "lbs_dreamer"}, "env": {}, **more}, {}, a_plan())
        (run.path / "episodes").mkdir(exist_ok=True)
        for index in range(episodes):
            run.save_episode(index, an_episode(steps=3))
        run.set_status(state="done", episode=episodes)
    answer = cli("paper", "figures", "learner", "frozen", "trained", "out=out")
    assert answer.code == 0 and "LEFT OUT: frozen evaluates a trained agent" in answer.out, answer.error
    assert [row["folder"] for row in rows(tmp_path / "out" / "runs.csv")] == ["learner"]
    assert rows(tmp_path / "out" / "verdicts.csv")[0]["n"] == "1 of 2"


def test_summaries_of_runs_stand_for_their_folders(cli: Cli, sweep: Path, tmp_path: Path) -> None:
    """The tables are the same, but for the run without an episode, of which there is no summary."""
    exported = cli("export", "sweep", "--to", "summary", "out=kept")
    assert exported.code == 1 and "LEFT OUT: sweep/3_d has no finished episode" in exported.out, exported
    assert "curionav compare kept" in exported.out and len(list((tmp_path / "kept").iterdir())) == 3
    for name, given in (("of_folders", "sweep"), ("of_summaries", "kept")):
        answer = cli("paper", "figures", given, f"out={name}")
        assert answer.code == 0, answer.error
    for table in ("verdicts", "against", "arms", "coverage", "runs"):
        known = [[{key: value for key, value in row.items() if key not in ("folder", "seconds", "disk")}
                  for row in rows(tmp_path / name / f"{table}.csv") if row.get("steps") != "0"]
                 for name in ("of_folders", "of_summaries")]
        assert sorted(map(str, known[0])) == sorted(map(str, known[1])) and known[0], table
    made = [{path.name for path in (tmp_path / name).iterdir()} for name in ("of_folders", "of_summaries")]
    assert made[0] == made[1] and "best_large_lab_changes=true.png" in made[1]
    compared = cli("compare", "kept", "out=compared")
    assert compared.code == 0 and "heatmaps_large_lab_changes=true.png" in compared.out, compared.error
    assert "film and tables of the probe are made of run folders alone" in compared.out


def test_of_two_runs_with_the_same_settings_one_is_named_as_left_out(cli: Cli, sweep: Path, tmp_path: Path) -> None:
    shutil.copytree(sweep / "0_a", sweep / "4_a")
    answer = cli("export", "sweep/0_a", "sweep/4_a", "--to", "summary", "out=kept")
    assert answer.code == 1 and "LEFT OUT: sweep/0_a has the settings and seed of sweep/4_a" in answer.out, answer
    assert answer.out.count(".summary.npz") == 2 and len(list((tmp_path / "kept").iterdir())) == 1


def test_a_file_of_another_name_is_one_clear_line(cli: Cli, sweep: Path, tmp_path: Path) -> None:
    (tmp_path / "renamed.npz").write_bytes(b"")
    answer = cli("compare", "renamed.npz")
    assert answer.code == 2 and "the name of one ends in .summary.npz" in answer.error, answer


@pytest.mark.parametrize(("words", "said"), [
    (("kept",), "Name the format"), (("nowhere", "--to", "summary"), "There is no folder nowhere"),
    (("--to", "summary"), "curionav export outputs/DATE/SWEEP --to summary"),
    (("sweep/0_a", "--to", "summary", "images=raw"), "export has no setting images"),
    (("sweep", "--to", "glb"), "--to glb writes a world, and sweep is no setting of one")])
def test_a_wrong_export_of_summaries_is_one_clear_line(cli: Cli, sweep: Path, words: tuple[str, ...], said: str
                                                       ) -> None:
    answer = cli("export", *words)
    assert answer.code == 2 and said in answer.error and "Traceback" not in answer.error, answer
    assert not Path("summaries").exists()


def test_what_is_there_of_other_worlds_stays_where_it_is_asked_for(cli: Cli, sweep: Path, tmp_path: Path, an_episode,
                                                                   a_plan) -> None:
    assert cli("paper", "figures", "sweep", "out=out").code == 0
    tables = ("verdicts", "against", "arms", "coverage", "runs")
    before = {name: rows(tmp_path / "out" / f"{name}.csv") for name in tables}
    run = RunFolder(tmp_path / "room")
    run.create(SETTINGS.format(agent="lbs_dreamer", changes="true").replace("large_lab", "small_room"),
               {"agent": {"name": "lbs_dreamer"}, "env": {}}, {}, a_plan())
    (run.path / "episodes").mkdir(exist_ok=True)
    run.save_episode(0, an_episode(steps=3))
    run.set_status(state="done", episode=1)
    page = tmp_path / "page.md"
    page.write_text(block("figures", "pictures") + "\n")
    answer = cli("paper", "figures", "room", "out=out", "keep=yes", "page=page.md")
    assert answer.code == 0, answer.error
    for name in tables:
        found = rows(tmp_path / "out" / f"{name}.csv")
        old = [row for row in before[name] if row["env"].startswith("large_lab")]
        assert [{key: row[key] for key in old[0]} for row in found if row["env"].startswith("large_lab")] == old, name
    verdicts = rows(tmp_path / "out" / "verdicts.csv")
    assert len(verdicts) == 8 and [row["n"] for row in verdicts if row["env"] == "small_room"] == ["1 of 2"]
    assert rows(tmp_path / "out" / "runs.csv")[0]["env"] == "small_room", "in the paper's order"
    assert "](out/small_room.png)" in page.read_text() and "](out/large_lab.png)" in page.read_text()
    assert cli("paper", "figures", "room", "out=out", "page=page.md").code == 0
    assert [row["env"] for row in rows(tmp_path / "out" / "runs.csv")] == ["small_room"]
    assert "large_lab" not in page.read_text()


@pytest.mark.parametrize("text", ["not a table\n1,2\n", "env,arm,seed,steps\nlarge_lab,bounce,0,many\n", "env\na,b\n"])
def test_a_table_that_is_none_is_one_clear_line(cli: Cli, sweep: Path, text: str) -> None:
    Path("out").mkdir()
    Path("out/runs.csv").write_text(text)
    answer = cli("paper", "figures", "sweep/2_c", "out=out", "keep=yes")
    assert answer.code == 2 and "runs.csv is not a table of curionav paper figures" in answer.error, answer
    assert Path("out/runs.csv").read_text() == text and [path.name for path in Path("out").iterdir()] == ["runs.csv"]
    wrong = cli("paper", "sizes", "keep=yes")
    assert wrong.code == 2 and "curionav paper sizes has no keep=" in wrong.error


def test_the_one_picture_of_all_apartments_stays_where_none_is_given(tmp_path: Path) -> None:
    """Where some are given it is drawn of them, and a line says which of the tables it lacks."""
    for name in ("apartments.png", "best_apartment_1.png", "small_room.png", "others.png"):
        (tmp_path / name).touch()
    assert paper_kept.pictures(tmp_path, ["small_room.png"], {"small_room"}) == [
        "small_room.png", "apartments.png", "best_apartment_1.png"]
    assert paper_kept.pictures(tmp_path, [], {"apartment_0"}) == ["best_apartment_1.png", "small_room.png"]
    runs = [Table("runs", "", (), [{"env": "apartment_0"}, {"env": "apartment_1 changes=true"}])]
    assert paper_kept.apartments_line(runs, {"small_room"}) == []
    [line] = paper_kept.apartments_line(runs, {"apartment_0"})
    assert line.startswith("apartments.png shows apartment_0 alone, and the tables have apartment_1 too")
