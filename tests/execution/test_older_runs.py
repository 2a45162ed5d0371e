"""Run folders of commit 7cd86ae, before the package was laid out anew: resumed to what that commit makes of them."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from entry import Cli

from curionav_cli.records import Episode

pytestmark = pytest.mark.usefixtures("blank_figures")
RUNS = Path(__file__).resolve().parents[1] / "fixtures" / "runs_7cd86ae"
SECOND = {  # actions and poses of the second episode, as that commit's own resume made them
    "random": ([1, 0, 2], [[0.55, 0.45, 1.5707963267948966], [0.55, 0.45, 1.7453292519943295],
                           [0.5065879555832674, 0.696201938253052, 1.7453292519943295],
                           [0.5065879555832674, 0.696201938253052, 1.5707963267948966]]),
    "robot": ([0, 0, 0], [[0.5481512810285764, 0.4732875255969903, 1.562646067293173],
                          [0.5495603386586113, 0.7136633314908598, 1.5672229314481458],
                          [0.5485845679436476, 0.9704011290764508, 1.5819709871354437],
                          [0.5454761452465265, 1.216549273097417, 1.5848768434848568]]),
}


@pytest.mark.parametrize("name", SECOND)
def test_an_older_run_goes_on(cli: Cli, tmp_path: Path, name: str) -> None:
    run = Path(shutil.copytree(RUNS / name, tmp_path / name))
    first = (run / "episodes" / "000000.npz").read_bytes()
    answer = cli("resume", name, "loop.episodes=2")
    assert answer.code == 0, answer.error
    assert (run / "episodes" / "000000.npz").read_bytes() == first
    action, pose = SECOND[name]
    episode = Episode.load(run / "episodes" / "000001.npz")
    assert episode.action.tolist() == action
    np.testing.assert_allclose(episode.pose, pose, rtol=0, atol=1e-9)
    assert (run / "figures" / "heatmap.png").is_file() and (run / "checkpoint" / "000002" / "done").is_file()
    assert cli("coverage", name).code == 0 and f" {name} " in cli("runs", ".").out
