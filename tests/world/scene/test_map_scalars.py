"""The YAML file of a map, value by value as yaml-cpp 0.8.0 reads it, and the forms of YAML that editors write."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mapmaking import HEAD, describe, drawn, write_map

from curionav_cli.errors import MapError
from curionav_cli.world.scene.map_file import read_map_file
from curionav_cli.world.scene.map_scalars import as_bool, as_float, as_int
from curionav_cli.world.scene.ros_map import read_map

BLACK_AND_WHITE = np.array([[0, 254, 254]])
GOOD = HEAD.format(image="map.pgm") + "negate: 0\n"


@pytest.mark.parametrize(("text", "number"), [
    ("1e-05", 1e-05), ("-1e+03", -1000.0), ("5e-2", 0.05), ("5E-2", 0.05), ("010", 10.0), ("5.", 5.0), (".5", 0.5),
    ("+1", 1.0), ("-0", 0.0), ("0.05 ", 0.05), (".inf", float("inf")), ("-.INF", float("-inf"))])
def test_floats(text: str, number: float) -> None:
    assert as_float(text) == number


@pytest.mark.parametrize("text", ["", " 0.05", "0x10", "1_0", "1,0", "0.05f", "0.05 m", "1e", "1e400", "nan", "inf",
                                  ".", "++1", "\u0661", "+.nan", "1.2.3"])
def test_no_floats(text: str) -> None:
    with pytest.raises(ValueError, match="is no number"):
        as_float(text)


@pytest.mark.parametrize(("text", "number"), [
    ("0", 0), ("00", 0), ("010", 8), ("0x10", 16), ("0X0", 0), ("-1", -1), ("+2", 2), ("12 ", 12),
    ("2147483647", 2**31 - 1)])
def test_ints(text: str, number: int) -> None:
    assert as_int(text) == number


@pytest.mark.parametrize("text", ["", "08", "1.0", "1e0", "0b1", "0o1", "0x", "2147483648", "-2147483649", " 1", "one"])
def test_no_ints(text: str) -> None:
    with pytest.raises(ValueError, match=r"is no whole number|has more than 32 bits"):
        as_int(text)


def test_bools() -> None:
    assert all(as_bool(text) for text in ["y", "Y", "yes", "Yes", "YES", "true", "True", "TRUE", "on", "On", "ON"])
    assert not any(as_bool(text) for text in ["n", "N", "no", "No", "NO", "false", "False", "FALSE", "off", "OFF"])
    for text in ("", "yEs", "oN", "t", "1", "true "):
        with pytest.raises(ValueError, match="neither true nor false"):
            as_bool(text)


@pytest.mark.parametrize(("negate", "cells"), [
    (value, "#..") for value in ("0", '"0"', "'0'", "00", "0x0", "false", '"false"', "off", "n", "N", "No", "-0")
] + [(value, ".##") for value in ("1", '"1"', "yes", "Y", "ON", "true", "2", "-1", "010", "0x1")])
def test_negate(tmp_path: Path, negate: str, cells: str) -> None:
    """Python takes most of these for true: the robot would explore inside the walls."""
    write_map(tmp_path, BLACK_AND_WHITE)
    assert drawn(describe(tmp_path, GOOD.replace("negate: 0", f"negate: {negate}"))) == [cells]


def test_numbers_that_nav2s_savers_write(tmp_path: Path) -> None:
    write_map(tmp_path, BLACK_AND_WHITE)
    text = (GOOD.replace("resolution: 0.1", 'resolution: "0.05"').replace("0.196", "1.96e-1")
            .replace("[-1.0, 2.0, 0.3]", "[-1e+03, 010, 1e-05]"))
    found = read_map(describe(tmp_path, text))
    assert (found.resolution, *found.origin) == (0.05, -1000.0, 10.0, 1e-05)
    blocks = GOOD.replace("[-1.0, 2.0, 0.3]", "\n  - -1\n  - '2'")
    assert read_map_file(describe(tmp_path, blocks)).origin == (-1.0, 2.0, 0.0)


@pytest.mark.parametrize("name", ["0123", "1.10", "yes", "null", "1e3", "a b.pgm", "büro.pgm"])
def test_the_name_of_an_image_is_text(tmp_path: Path, name: str) -> None:
    write_map(tmp_path, BLACK_AND_WHITE).with_name("map.pgm").rename(tmp_path / name)
    quoted = f"'{name}'" if name == "null" else name
    assert drawn(describe(tmp_path, GOOD.replace("map.pgm", quoted))) == ["#.."]


JSON = ('{\n\t"image": "map.pgm",\n\t"resolution": 0.1,\n\t"origin": [0,\t0, 0],\n\t"negate": 0,\n'
        '\t"occupied_thresh": 0.65,\n\t"free_thresh": 0.196\n}\n')
FORMS = {
    "byte order mark": b"\xef\xbb\xbf" + GOOD.encode(),
    "CRLF": GOOD.replace("\n", "\r\n").encode(),
    "UTF-16": GOOD.encode("utf-16"),
    "Latin-1 comment": "# Büro\n".encode("latin-1") + GOOD.encode(),
    "Windows comment": b"# \x93office\x94 \x81\n" + GOOD.encode(),
    "tabs after values": GOOD.replace("\n", "\t\n").encode(),
    "tabs and comments after values": GOOD.replace("\n", "\t# what\tit is\n").encode(),
    "comments and blank lines led by tabs": GOOD.replace("\n", "\n\t# more\n\t\n \t \n").encode(),
    "tabs between key and value": GOOD.replace(": ", ":\t").encode(),
    "a control character in a comment": b"# \x1b[0m\x00\n" + GOOD.encode(),
    "a second document": (GOOD + "---\nresolution: [\n").encode(),
    "an end and what follows it": (GOOD + "...\n}{\n").encode(),
    "a directive": b"%YAML 1.2\n---\n" + GOOD.encode(),
    "JSON with tabs": JSON.encode(),
    "the first of two keys": (GOOD + "negate: 1\noccupied_thresh: 2\nimage: gone.pgm\n").encode(),
    "unknown keys": (GOOD + "map_type: occupancy\n? [a, b]\n: {c: [1, 2]}\n").encode(),
    "tags": GOOD.replace("0.65", "!!float 0.65").replace("map.pgm", "!!str map.pgm").encode(),
    "an anchor": GOOD.replace("0.65", "&edge 0.65").replace("0.196", "*edge").encode(),
}


@pytest.mark.parametrize("form", FORMS)
def test_forms_of_yaml(tmp_path: Path, form: str) -> None:
    write_map(tmp_path, BLACK_AND_WHITE)
    assert drawn(describe(tmp_path, FORMS[form])) == ["#.."]


@pytest.mark.parametrize("text", ["a: &a [*a]\n", "a: &a [x]\n" + "".join(
    f"b{n}: &b{n} [{', '.join(['*b' + str(n - 1) if n else '*a'] * 9)}]\n" for n in range(9))])
def test_yaml_that_unfolds_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(MapError, match=r"is not YAML, so it is no ROS map|lacks image"):
        read_map(describe(tmp_path, text))


@pytest.mark.parametrize("yaw", ["-nan", "nan", ".nan"])
def test_a_yaw_that_is_not_known_is_answered_with_what_to_write(tmp_path: Path, yaw: str) -> None:
    file = write_map(tmp_path, BLACK_AND_WHITE)
    file.write_text(file.read_text().replace("2.0, 0.3]", f"2.0, {yaw}]"))
    with pytest.raises(MapError, match=r"Write 0\.0 in its place"):
        read_map(file)
