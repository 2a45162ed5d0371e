"""Images of maps: every format, colours, transparency, 16 bits. Greys as GraphicsMagick 1.3.40 gives them to Nav2."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from mapmaking import HEAD, describe, drawn, write_map
from PIL import Image

from curionav_cli.errors import MapError
from curionav_cli.world.scene.map_image import read_image

GREYS = np.array([[0, 254, 205], [254, 0, 100]], np.uint8)
SAME = ["#.?", ".#?"]


def named(folder: Path, name: str, more: str = "") -> Path:
    return describe(folder, HEAD.format(image=name) + "negate: 0\n" + more)


def saved(folder: Path, pixels: np.ndarray, name: str, **how) -> Path:
    Image.fromarray(pixels).save(folder / name, **how)
    return named(folder, name)


@pytest.mark.parametrize(("name", "how"), [
    ("map.png", {}), ("map.bmp", {}), ("map.gif", {}), ("map.tif", {}), ("map.tiff", {"compression": "tiff_lzw"}),
    ("map.webp", {"lossless": True}), ("map.pgm", {}), ("map.pgm", {"format": "PNG"}), ("map.png", {"format": "TIFF"}),
    ("noname", {"format": "GIF"})])
@pytest.mark.parametrize("colour", [False, True])
def test_formats(tmp_path: Path, name: str, how: dict, colour: bool) -> None:
    pixels = np.repeat(GREYS[..., None], 3, axis=2) if colour else GREYS
    assert drawn(saved(tmp_path, pixels, name, **how)) == SAME


@pytest.mark.parametrize("grey", [0, 100, 205, 254])
def test_jpeg(tmp_path: Path, grey: int) -> None:
    saved(tmp_path, np.full((16, 16), grey, np.uint8), "map.jpg", quality=95)
    assert (read_image(tmp_path / "map.jpg").grey == grey).all()


ROWS = " ".join(map(str, GREYS.ravel())).encode()
COLOURS = " ".join(f"{grey} {grey} {grey}" for grey in GREYS.ravel()).encode()
BITS = ["#.#", ".#."]
NETPBM = {
    "P1": (b"P1 # plain\n3 # wide\n2\n101\n0 1 0", BITS),
    "P2": (b"P2\n3 2\n255\n" + ROWS, SAME),
    "P3": (b"P3\n3 2\n255\n" + COLOURS, SAME),
    "P4": (b"P4\n# packed\n3 2\n\xa0\x40", BITS),
    "P5": (b"P5\n3 2\n255\n" + GREYS.tobytes(), SAME),
    "P6": (b"P6 3 2 255\n" + GREYS.repeat(3).tobytes(), SAME),
    "P7 grey": (b"P7\nWIDTH 3\nHEIGHT 2\nDEPTH 1\nMAXVAL 255\nTUPLTYPE GRAYSCALE\nENDHDR\n" + GREYS.tobytes(), SAME),
    "P7 colours": (b"P7\n# c\nWIDTH 3\nHEIGHT 2\n\nDEPTH 3\nMAXVAL 255\nENDHDR\n" + GREYS.repeat(3).tobytes(), SAME),
    "P7 alpha": (b"P7\nWIDTH 3\nHEIGHT 2\nDEPTH 2\nMAXVAL 255\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n"
                 b"\x00\xff\xfe\xfe\xcd\x00\xfe\xff\x00\xff\x64\xff", ["#??", ".#?"]),
    "P5 of 16 bits": (b"P5\n3 2\n65535\n" + (GREYS.astype(">u2") * 257).tobytes(), SAME),
    "P2 of 4 bits": (b"P2\n3 2\n15\n0 15 12 15 0 6\n", SAME),
}


@pytest.mark.parametrize("kind", NETPBM)
@pytest.mark.parametrize("name", ["map.pgm", "map.png"])
def test_netpbm(tmp_path: Path, kind: str, name: str) -> None:
    raw, cells = NETPBM[kind]
    (tmp_path / name).write_bytes(raw)
    assert drawn(named(tmp_path, name)) == cells


@pytest.mark.parametrize(("most", "values", "greys"), [
    (1, [0, 1, 1], [0, 255, 255]), (100, [0, 50, 100], [0, 127, 255]), (15, [0, 7, 15], [0, 119, 255])])
def test_where_graphicsmagick_is_wrong_pgm_of_few_greys(tmp_path: Path, most: int, values: list[int],
                                                        greys: list[int]) -> None:
    """It takes a P5 with a largest value of 1 for all white, and of 15 for black or white."""
    (tmp_path / "map.pgm").write_bytes(b"P5\n3 1\n%d\n" % most + bytes(values))
    assert read_image(tmp_path / "map.pgm").grey.tolist() == [greys]


def bitmap(folder: Path, fourth: list[list[int]]) -> Path:
    """A BMP of 32 bits without masks, as many programs write it."""
    pixels = np.dstack([GREYS, GREYS, GREYS, np.array(fourth, np.uint8)])
    image = Image.frombytes("RGBA", (3, 2), pixels.tobytes())
    image.save(folder / "map.bmp")
    assert (folder / "map.bmp").read_bytes()[28:34] == b"\x20\x00\x00\x00\x00\x00"
    return named(folder, "map.bmp")


def test_where_graphicsmagick_is_wrong_bitmap_without_alpha(tmp_path: Path) -> None:
    """It takes a fourth byte of 0 everywhere for a picture that is clear everywhere."""
    assert drawn(bitmap(tmp_path, [[0, 0, 0], [0, 0, 0]])) == SAME


def test_the_fourth_byte_of_a_bitmap_is_alpha_elsewhere(tmp_path: Path) -> None:
    assert drawn(bitmap(tmp_path, [[0, 255, 255], [255, 128, 255]])) == ["?.?", ".??"]


@pytest.mark.parametrize(("alpha", "known"), [(255, True), (254, False), (128, False), (0, False)])
@pytest.mark.parametrize("name", ["map.png", "map.webp", "map.tiff"])
def test_what_shines_through_is_unknown(tmp_path: Path, alpha: int, known: bool, name: str) -> None:
    greys = np.where(GREYS == 205, 100, GREYS)
    pixels = np.dstack([greys, greys, greys, np.full_like(greys, 255)])
    pixels[0, :2, 3] = alpha
    how = {"lossless": True, "exact": True} if name.endswith("webp") else {}
    path = saved(tmp_path, pixels, name, **how)
    assert drawn(path) == (SAME if known else ["???", ".#?"])
    assert drawn(named(tmp_path, name, "mode: scale\n"))[0][:2] == ("#." if known else "??")
    assert drawn(named(tmp_path, name, "mode: raw\n"))[0] == ".?#", "raw looks at no alpha"


def test_grey_with_alpha_and_palettes(tmp_path: Path) -> None:
    alpha = np.array([[255, 0, 255], [128, 255, 255]], np.uint8)
    assert drawn(saved(tmp_path, np.dstack([GREYS, alpha]), "map.png")) == ["#??", "?#?"]
    assert drawn(saved(tmp_path, np.dstack([GREYS, 0 * alpha + 255]), "map.png")) == SAME
    for name in ("map.png", "map.gif"):
        palette = Image.fromarray(GREYS).convert("P")
        palette.save(tmp_path / name, transparency=254)
        assert drawn(named(tmp_path, name)) == ["#??", "?#?"]
    palette.save(tmp_path / "map.png", transparency=bytes([255] * 255))
    assert drawn(named(tmp_path, "map.png")) == SAME
    Image.fromarray(GREYS).save(tmp_path / "map.png", transparency=0)  # of a grey image without alpha
    assert drawn(named(tmp_path, "map.png")) == ["?.?", ".??"]


def test_an_opaque_export_keeps_its_rooms_shut(tmp_path: Path) -> None:
    """Alpha of 255 everywhere, averaged in as ROS 1 did, made the unknown around a building free."""
    grey = np.full((20, 20), 205, np.uint8)
    grey[5:15, 5:15], grey[6:14, 6:14] = 0, 254
    opaque = drawn(saved(tmp_path, np.dstack([grey, grey, grey, np.full_like(grey, 255)]), "map.png"))
    assert opaque == drawn(write_map(tmp_path, grey)) and sum(row.count(".") for row in opaque) == 64


@pytest.mark.parametrize(("colour", "grey", "cell"), [
    ((255, 255, 0), 225, "."), ((0, 255, 0), 149, "?"), ((255, 0, 0), 76, "#"), ((0, 0, 255), 29, "#"),
    ((0, 255, 255), 178, "?"), ((255, 0, 255), 105, "?"), ((205, 205, 205), 205, "?"), ((10, 200, 30), 123, "?")])
def test_colours_by_luma(tmp_path: Path, colour: tuple[int, ...], grey: int, cell: str) -> None:
    path = saved(tmp_path, np.array([[colour]], np.uint8), "map.png")
    assert read_image(tmp_path / "map.png").grey.tolist() == [[grey]] and drawn(path) == [cell]


WIDE = np.array([[0, 256, 257, 26317, 52684, 52685, 65534, 65535]], np.uint16)
NARROW = [0, 0, 1, 102, 204, 205, 254, 255]


@pytest.mark.parametrize("name", ["map.png", "map.tiff", "map.pgm"])
def test_16_bits_become_eight_first(tmp_path: Path, name: str) -> None:
    cv2.imwrite(str(tmp_path / name), WIDE)
    assert read_image(tmp_path / name).grey.tolist() == [NARROW]


def test_colours_of_16_bits(tmp_path: Path) -> None:
    colours = np.repeat(WIDE[..., None], 3, axis=2)
    cv2.imwrite(str(tmp_path / "map.png"), colours)
    assert read_image(tmp_path / "map.png").grey.tolist() == [NARROW]
    colours[0, 0] = [65535, 0, 1000]  # blue, green, red
    cv2.imwrite(str(tmp_path / "map.png"), np.dstack([colours, WIDE[:, ::-1]]))
    found = read_image(tmp_path / "map.png")
    assert found.grey[0, 0] == (299 * 1000 + 114 * 65535 + 500) // 1000 // 257
    assert found.clear is not None and found.clear.tolist() == [[False] + [True] * 7]


def test_exif_turns_no_jpeg(tmp_path: Path) -> None:
    exif = Image.Exif()
    exif[0x112] = 6
    saved(tmp_path, np.full((8, 24), 254, np.uint8), "map.jpg", exif=exif)
    assert read_image(tmp_path / "map.jpg").grey.shape == (8, 24)


@pytest.mark.parametrize("pixels", [np.zeros((2, 2), np.float32), np.zeros((2, 2), np.int32)])
def test_pixels_of_32_bits_are_refused(tmp_path: Path, pixels: np.ndarray) -> None:
    with pytest.raises(MapError, match="has pixels of 32 bits, whose black and white no map says"):
        drawn(saved(tmp_path, pixels, "map.tiff"))


@pytest.mark.parametrize("name", ["map.png", "map.gif", "map.tiff", "map.webp", "map.bmp", "map.jpg"])
def test_images_that_are_cut_off(tmp_path: Path, name: str) -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (40, 40), np.uint8)
    path = saved(tmp_path, pixels, name)
    raw = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(raw[:len(raw) // 2])
    with pytest.raises(MapError, match="is no image that can be read"):
        drawn(path)
