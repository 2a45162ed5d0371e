"""What our own map writer writes is read back as the same cells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from curionav_cli.records import Pose
from curionav_cli.world.scene.map_file import read_map_file
from curionav_cli.world.scene.map_writer import write_map
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, UNKNOWN, read_map

hypothesis = pytest.importorskip("hypothesis", reason="needs the extra dev")
from hypothesis import HealthCheck, given, settings  # noqa: E402
from hypothesis import strategies as st  # noqa: E402
from hypothesis.extra.numpy import array_shapes, arrays  # noqa: E402

CELLS = arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.sampled_from((-1, 0, 100)))
METRES = st.floats(-1e4, 1e4)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(CELLS, st.floats(0.01, 2.0), st.tuples(METRES, METRES, st.floats(-3.2, 3.2)))
def test_any_trinary_map_comes_back(tmp_path: Path, cells: np.ndarray, resolution: float, origin: tuple) -> None:
    write_map(tmp_path / "own map.yaml", cells, resolution, Pose(*origin))
    back = read_map(tmp_path / "own map.yaml")
    assert np.array_equal(back.cells, cells) and back.cells.dtype == np.int8
    assert back.resolution == resolution and back.origin == origin


def test_the_files_are_what_map_saver_writes(tmp_path: Path) -> None:
    path = tmp_path / "büro: 1.yaml"
    write_map(path, np.array([[FREE, OCCUPIED], [UNKNOWN, FREE], [OCCUPIED, OCCUPIED]]), 0.05)
    assert path.with_suffix(".pgm").read_bytes() == b"P5\n# 0.05 m/pix\n2 3\n255\n" + bytes([0, 0, 205, 254, 254, 0])
    assert read_map_file(path).image == path.with_suffix(".pgm")
    assert sorted(file.suffix for file in tmp_path.iterdir()) == [".pgm", ".yaml"]


def test_the_files_are_read_alike_by_the_rules_of_nav2_then_and_now(tmp_path: Path) -> None:
    """Every key that nav2_map_server's map_io.cpp asks for, of its type, and greys on the same side of both thresholds
    whether these are exclusive (until 1.3.7, in double) or inclusive (since, in float)."""
    write_map(tmp_path / "map.yaml", np.array([[FREE, OCCUPIED, UNKNOWN]]), 1e-5, Pose(-1e-7, 1e16, -0.5))
    text = (tmp_path / "map.yaml").read_text()
    held = dict(line.split(": ", 1) for line in text.splitlines())
    assert held == {"image": '"map.pgm"', "mode": "trinary", "resolution": "1e-05",
                    "origin": "[-1e-07, 1e+16, -0.5]", "negate": "0", "occupied_thresh": "0.65",
                    "free_thresh": "0.196"}
    grey = np.frombuffer((tmp_path / "map.pgm").read_bytes()[-3:], np.uint8)
    for kind in (np.float32, np.float64):
        free, occupied = kind(0.196), kind(0.65)
        share = 1 - grey.astype(kind) / kind(255)
        assert [*(share < free)] == [*(share <= free)] == [True, False, False]
        assert [*(share > occupied)] == [*(share >= occupied)] == [False, True, False]


def test_other_values_are_refused_and_nothing_is_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="one of 0, 100, -1"):
        write_map(tmp_path / "map.yaml", np.array([[0, 50]]), 0.05)
    assert not list(tmp_path.iterdir())
