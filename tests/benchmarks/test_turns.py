"""The parts of benchmarks/turns.py: its rows, and C-BET's pieces by this checkout."""

from pathlib import Path

import pytest

HOME = Path(__file__).resolve().parents[2]


@pytest.fixture
def turns(monkeypatch):
    monkeypatch.syspath_prepend(str(HOME / "benchmarks"))
    import turns

    return turns


def test_a_row_has_medians_quartiles_and_the_ratio_turn_by_turn(turns):
    numbers = {"old": [2.0, 4.0, 8.0], "new": [1.0, 1.0, 8.0], "old MB": [100.0] * 3, "new MB": [90.0] * 3}
    assert turns.row("a map", numbers) == (
        "| a map | 3 | 4.00 (3.00 to 6.00) | 1.00 (1.00 to 4.50) | 0.50 (0.38 to 0.75) | 100, 90 |")
    piece = turns.row("C-BET", {"old": [0.2], "new": [0.1]})
    assert piece.endswith("| 0.100 (0.100 to 0.100) | 0.50 (0.50 to 0.50) |  |")


def test_the_head_says_where_and_of_what(turns, tmp_path):
    said = turns.head({"old": tmp_path, "new": HOME}, 0.5)
    assert "cores" in said and f"old {tmp_path.name}" in said and "load average 0.5 before" in said


def test_only_named_rows_are_run_and_the_first_run_is_not_counted(turns, monkeypatch):
    ran = []
    monkeypatch.setattr(turns, "spent", lambda tree, words: ran.append((tree, words)) or (float(len(ran)), 7.0))
    trees = {"old": Path("a"), "new": Path("b")}
    [(name, numbers)] = turns.whole_processes(trees, "fused", 2)
    assert name == "the same, `compile=fused`"
    assert numbers == {"old": [3.0, 5.0], "new": [4.0, 6.0], "old MB": [7.0, 7.0], "new MB": [7.0, 7.0]}
    assert [("compile=fused" in words, str(tree)) for tree, words in ran[:2]] == [(False, "a"), (True, "b")]


@pytest.mark.slow
def test_cbet_by_this_checkout(turns):
    with turns.asked(HOME) as child:
        print("episode", file=child.stdin, flush=True)
        found = turns.json.loads(child.stdout.readline())
    assert found.keys() == {"acting", "learning", "acting and learning", "reward"}
    assert all(value > 0 for value in found.values())
