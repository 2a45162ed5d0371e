"""Kinds of furniture: default size, material, and the boxes that each is made of.

A kind is drawn at the origin, w along x, d along y, its back to the north; parts are
(x0, x1, y0, y1, z0, z1, material, fit) in metres from its south-west corner.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from curionav_cli.world.materials.tiled import COLOURS

Part = tuple[float, float, float, float, float, float, str, bool]
LEG = 0.05
BODIES = {  # patterns that are a front, and what the rest of the piece is made of
    "books": "wood_oak", "doors": "wood_pale", "drawers": "wood_oak", "kitchen": "wood_white",
    "fridge": "ceramic", "stove": "ceramic", "washer": "ceramic", "screen": "metal_black",
    "piano": "wood_dark", "goods": "metal", "radiator": "plaster_white", "aquarium": "metal_black",
}
BOTH_SIDES = ("goods", "aquarium")  # seen from the back as from the front


def faces(material: str, turn: int) -> tuple[tuple[str, str, str, str], str]:
    """The materials of a part's sides (west, east, south, north) and of its top."""
    pattern, _, variant = material.partition("_")
    if pattern not in BODIES:
        return (material,) * 4, material
    painted = BODIES[pattern].startswith("wood") and variant and variant in COLOURS
    body = f"wood_{variant}" if painted else BODIES[pattern]
    around = [material, body, material if pattern in BOTH_SIDES else body, body]  # south, then anticlockwise
    quarter = turn // 90
    south, east, north, west = around[-quarter:] + around[:-quarter] if quarter else around
    return (west, east, south, north), body


def block(w: float, d: float, h: float, material: str) -> list[Part]:
    return [(0, w, 0, d, 0, h, material, True)]


def pillar(w: float, d: float, h: float, material: str) -> list[Part]:
    return [(0, w, 0, d, 0, h, material, False)]


def _legs(w: float, d: float, h: float, material: str) -> list[Part]:
    corners = [(x, y) for x in (0.0, w - LEG) for y in (0.0, d - LEG)]
    return [(x, x + LEG, y, y + LEG, 0, h, material, False) for x, y in corners]


def table(w: float, d: float, h: float, material: str) -> list[Part]:
    return [(0, w, 0, d, h - 0.04, h, material, True), *_legs(w, d, h - 0.04, material)]


def desk(w: float, d: float, h: float, material: str) -> list[Part]:
    drawers = (w - 0.4, w, 0.05, d, 0, h - 0.04, "drawers", True)
    legs = [leg for leg in _legs(w, d, h - 0.04, "metal") if leg[0] == 0]
    screen = (0.3 * w, 0.3 * w + 0.5, d - 0.2, d - 0.16, h + 0.08, h + 0.4, "screen", True)
    return [(0, w, 0, d, h - 0.04, h, material, True), drawers, *legs, screen]


def chair(w: float, d: float, h: float, material: str) -> list[Part]:
    seat = 0.52 * h
    return [(0, w, 0, d, seat - 0.05, seat, material, True),
            (0, w, d - 0.05, d, seat, h, material, True), *_legs(w, d, seat - 0.05, "wood_dark")]


def stool(w: float, d: float, h: float, material: str) -> list[Part]:
    return [(0, w, 0, d, h - 0.06, h, material, True), *_legs(w, d, h - 0.06, "wood_dark")]


def bench(w: float, d: float, h: float, material: str) -> list[Part]:
    """A board on two panels: a bench, a workbench, a console."""
    panel = (0.03, d - 0.03, 0, h - 0.05, "wood_dark", False)
    return [(0, w, 0, d, h - 0.05, h, material, True), (0.04, 0.1, *panel), (w - 0.1, w - 0.04, *panel)]


def pedestal(w: float, d: float, h: float, material: str) -> list[Part]:
    """A board on one foot."""
    x, y = 0.5 * w, 0.5 * d
    return [(0, w, 0, d, h - 0.05, h, material, True),
            (x - 0.05, x + 0.05, y - 0.05, y + 0.05, 0.04, h - 0.05, "metal", False),
            (0.2 * w, 0.8 * w, 0.2 * d, 0.8 * d, 0, 0.04, "metal", False)]


def seat(w: float, d: float, h: float, material: str) -> list[Part]:
    """A chair on one foot: fewer boxes than a chair on four legs."""
    x, y, sit = 0.5 * w, 0.5 * d, 0.52 * h
    return [(x - 0.05, x + 0.05, y - 0.05, y + 0.05, 0, sit - 0.08, "metal", False),
            (0, w, 0, d, sit - 0.08, sit, material, True),
            (0.03, w - 0.03, d - 0.06, d, sit + 0.08, h, material, True)]


def counter(w: float, d: float, h: float, material: str) -> list[Part]:
    return [(0, w, 0.03, d, 0, h - 0.04, material, True), (0, w, 0, d, h - 0.04, h, "wood_brown", True)]


def media(w: float, d: float, h: float, material: str) -> list[Part]:
    """A low chest and the television on it."""
    low, half = 0.45 * h, 0.5 * d
    return [(0, w, 0, d, 0, low, material, True),
            (0.14 * w, 0.86 * w, half - 0.03, half + 0.03, low + 0.05, h, "screen", True)]


def vanity(w: float, d: float, h: float, material: str) -> list[Part]:
    return [(0, w, 0.03, d, 0, h - 0.12, material, True), (0, w, 0, d, h - 0.12, h, "ceramic", True)]


def bunk(w: float, d: float, h: float, material: str) -> list[Part]:
    """Two beds, one above the other, along y."""
    posts = [(x0, x1, y0, y1, 0, h, "wood_pale", False) for x0, x1, y0, y1, *_ in _legs(w, d, h, "")]
    return [*posts, (0, w, 0, d, 0.2 * h, 0.32 * h, material, True),
            (0, w, 0, d, 0.75 * h, 0.85 * h, material, True)]


def tank(w: float, d: float, h: float, material: str) -> list[Part]:
    """An aquarium on its cabinet."""
    return [(0, w, 0, d, 0, 0.55 * h, "doors", True), (0, w, 0, d, 0.55 * h, h, material, True)]


def pallet(w: float, d: float, h: float, material: str) -> list[Part]:
    """Goods on a pallet."""
    return [(0, w, 0, d, 0, 0.14, "crate", True), (0.06, w - 0.06, 0.06, d - 0.06, 0.14, h, material, True)]


def sofa(w: float, d: float, h: float, material: str) -> list[Part]:
    seat, arm = 0.5 * h, 0.16
    return [(0, w, 0, d, 0, seat, material, False), (0, w, d - 0.22, d, seat, h, material, False),
            (0, arm, 0, d, seat, 0.75 * h, material, False),
            (w - arm, w, 0, d, seat, 0.75 * h, material, False)]


def bed(w: float, d: float, h: float, material: str) -> list[Part]:
    return [(0, w, 0, d, 0, 0.6 * h, "wood_oak", False), (0, w, 0, d - 0.45, 0.6 * h, h, material, True),
            (0, w, d - 0.45, d - 0.06, 0.6 * h, h + 0.06, "linen", True),
            (0, w, d - 0.06, d, 0, 2.0 * h, "wood_oak", False)]


def shelf_rack(w: float, d: float, h: float, material: str) -> list[Part]:
    """An open rack: posts, and boards one can look between."""
    boards = [h * level / 4 for level in range(1, 5)]
    posts = [(x0, x1, y0, y1, 0, h, "metal", False) for x0, x1, y0, y1, *_ in _legs(w, d, h, "metal")]
    return posts + [(0, w, 0, d, z - 0.04, z, material, True) for z in boards]


def plant(w: float, d: float, h: float, material: str) -> list[Part]:
    inner = 0.2 * w
    return [(inner, w - inner, inner, d - inner, 0, 0.3 * h, "terracotta", False),
            (0, w, 0, d, 0.42 * h, 0.8 * h, material, True),
            (inner, w - inner, inner, d - inner, 0.3 * h, h, material, True)]


def lamp(w: float, d: float, h: float, material: str) -> list[Part]:
    x, y = 0.5 * w, 0.5 * d
    return [(x - 0.1, x + 0.1, y - 0.1, y + 0.1, 0, 0.04, "metal", False),
            (x - 0.02, x + 0.02, y - 0.02, y + 0.02, 0.04, 0.78 * h, "metal", False),
            (0, w, 0, d, 0.78 * h, h, material, True)]


def rug(w: float, d: float, h: float, material: str) -> list[Part]:
    """Painted on the floor, see layout.py."""
    return []


class Kind(NamedTuple):
    """A kind of furniture: default width, depth and height in metres, material, and its parts."""

    w: float
    d: float
    h: float
    material: str
    parts: Callable[[float, float, float, str], list[Part]]


KINDS = {
    "table": Kind(1.2, 0.8, 0.74, "wood_oak", table),
    "coffee_table": Kind(0.9, 0.5, 0.4, "wood_dark", table),
    "desk": Kind(1.3, 0.65, 0.74, "wood_pale", desk),
    "chair": Kind(0.42, 0.42, 0.85, "wood_oak", chair),
    "stool": Kind(0.34, 0.34, 0.46, "fabric_red", stool),
    "sofa": Kind(1.9, 0.85, 0.8, "fabric_blue", sofa),
    "armchair": Kind(0.85, 0.85, 0.8, "fabric_green", sofa),
    "bed": Kind(1.5, 2.05, 0.5, "quilt", bed),
    "bench": Kind(1.2, 0.36, 0.45, "wood_pale", bench),
    "workbench": Kind(1.6, 0.75, 0.85, "wood_pale", bench),
    "side_table": Kind(0.5, 0.5, 0.55, "wood_dark", pedestal),
    "bistro": Kind(0.8, 0.8, 0.74, "wood_pale", pedestal),
    "seat": Kind(0.46, 0.46, 0.86, "fabric_blue", seat),
    "pouf": Kind(0.5, 0.5, 0.4, "fabric_ochre", pillar),
    "media": Kind(1.8, 0.42, 1.15, "doors", media),
    "bunk": Kind(0.95, 2.0, 1.7, "quilt", bunk),
    "aquarium": Kind(1.0, 0.4, 1.25, "aquarium", tank),
    "piano": Kind(1.45, 0.6, 1.2, "piano", block),
    "radiator": Kind(1.0, 0.12, 0.6, "radiator", block),
    "washer": Kind(0.6, 0.6, 0.85, "washer", block),
    "vanity": Kind(0.8, 0.48, 0.85, "doors_white", vanity),
    "nightstand": Kind(0.45, 0.4, 0.5, "drawers", block),
    "door_leaf": Kind(0.85, 0.04, 2.0, "door", block),
    "pallet": Kind(1.2, 0.8, 0.9, "cardboard", pallet),
    "bookshelf": Kind(1.0, 0.32, 1.9, "books", block),
    "shelf": Kind(2.0, 0.5, 2.0, "goods", block),
    "rack": Kind(1.2, 0.45, 1.8, "wood_pale", shelf_rack),
    "cabinet": Kind(0.9, 0.45, 0.9, "doors", block),
    "wardrobe": Kind(1.2, 0.6, 2.1, "doors_tall", block),
    "drawers": Kind(0.8, 0.45, 0.8, "drawers", block),
    "counter": Kind(1.8, 0.6, 0.9, "kitchen", counter),
    "fridge": Kind(0.6, 0.62, 1.8, "fridge", block),
    "stove": Kind(0.6, 0.6, 0.9, "stove", block),
    "toilet": Kind(0.38, 0.65, 0.42, "ceramic", block),
    "bath": Kind(1.6, 0.75, 0.55, "ceramic", block),
    "basin": Kind(0.6, 0.45, 0.85, "ceramic", block),
    "tv": Kind(1.2, 0.08, 0.7, "screen", block),
    "box": Kind(0.4, 0.35, 0.32, "cardboard", block),
    "crate": Kind(0.4, 0.3, 0.3, "crate", block),
    "toolbox": Kind(0.42, 0.22, 0.24, "toolbox", block),
    "tyre": Kind(0.6, 0.2, 0.6, "tyre", block),
    "bin": Kind(0.28, 0.28, 0.4, "metal_green", block),
    "block": Kind(0.5, 0.5, 1.0, "plaster_grey", block),
    "partition": Kind(1.0, 0.05, 1.2, "panel", block),
    "pillar": Kind(0.35, 0.35, 2.5, "concrete", pillar),
    "plant": Kind(0.45, 0.45, 1.0, "leaves", plant),
    "lamp": Kind(0.4, 0.4, 1.6, "shade", lamp),
    "rug": Kind(1.6, 1.1, 0.0, "rug_red", rug),
}


def turned(part: Part, w: float, d: float, turn: int) -> tuple[float, float, float, float]:
    """The part's (x0, x1, y0, y1) from the piece's centre after turning it by 0, 90, 180, 270 degrees."""
    x0, x1, y0, y1 = part[0] - w / 2, part[1] - w / 2, part[2] - d / 2, part[3] - d / 2
    for _ in range(turn // 90):
        x0, x1, y0, y1 = -y1, -y0, x0, x1
    return x0, x1, y0, y1
