"""What C-BET learns in 20 k frames of an open room: fewer cancelled moves, more cells, because it is rewarded."""

import json

import pytest

pytestmark = pytest.mark.usefixtures("blank_figures")
BEGIN, SEEDS = 8, (0, 1)  # episodes that count as the beginning
ROOM = """defaults:
  - /schema/env
name: hall
size: [8.0, 8.0]
cell: 0.05
radius: 0.1
camera: 0.88
start: [4.0, 4.0, 0]
rooms:
  - {rect: [0, 0, 8, 8], floor: planks, wall: brick}
posters:
  - {at: [0, 3.6], face: east, art: window, width: 0.9, height: 1.1, z: 0.9}
  - {at: [5.0, 8.0], face: south, art: painting_1}
furniture:
  - {kind: sofa, x: 1.5, y: 6.0, material: fabric_red}
  - {kind: bookshelf, x: 6.0, y: 0.2, turn: 180}
"""
ARMS = {
    "random": ["agent=random"], "cbet": ["agent=cbet"], "motion": ["agent=cbet", "agent.reward=motion"],
    "nothing": ["agent=cbet", "agent.coefficient.cbet=0"],
}


@pytest.fixture
def explored(cli, tmp_path):
    """arm -> the metrics of 40 episodes, seed by seed."""
    (tmp_path / "own" / "env").mkdir(parents=True)
    (tmp_path / "own" / "env" / "hall.yaml").write_text(ROOM)

    def explore(arm):
        runs = []
        for seed in SEEDS:
            words = ["explore", "-cd", "own", "env=hall", "device=cpu", "loop.episodes=40", f"seed={seed}",
                     f"hydra.run.dir={arm}{seed}", *ARMS[arm]]
            assert cli(*words).code == 0
            lines = (tmp_path / f"{arm}{seed}" / "metrics.jsonl").read_text().splitlines()
            runs.append([json.loads(line) for line in lines])
        return runs
    return explore


def mean(runs, key, which):
    rows = [row[key] for run in runs for row in run[which]]
    return sum(rows) / len(rows)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.filterwarnings("ignore:the key of a picture is degenerate", "ignore:the reward sits at its ceiling")
def test_it_learns_to_move(explored):
    runs = {arm: explored(arm) for arm in ARMS}
    last = slice(-1, None)
    cells = {arm: mean(runs[arm], "visited", last) for arm in ARMS}
    blocked = [mean(runs["cbet"], "cancelled", which) for which in (slice(0, BEGIN), slice(-BEGIN, None))]
    print(cells, blocked)
    assert blocked[1] < blocked[0]
    assert cells["cbet"] > 1.2 * cells["random"]
    assert abs(cells["motion"] / cells["cbet"] - 1) < 0.15
    assert abs(cells["nothing"] / cells["random"] - 1) < 0.2
