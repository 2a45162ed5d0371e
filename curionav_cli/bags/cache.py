"""Episodes of bags, kept in the user's cache folder under a checksum of the bags, and made anew where missing."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Sequence
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

from curionav_cli.bags import sandbox
from curionav_cli.bags.source import Source
from curionav_cli.errors import BagError
from curionav_cli.files import file_name, read_json, write_bytes
from curionav_cli.places import cache_dir

RULES = 2  # raised when the same bag makes other episodes
ENDINGS = (".mcap", ".bag", ".db3")
METADATA, REPORT = "metadata.yaml", "report.json"


def found(data: Path) -> list[Path]:
    """The bags at `data`: a file, a folder with metadata.yaml, or those in a folder; none where it holds episodes."""
    if is_bag(data):
        return [data]
    if not data.is_dir() or (data / "config.yaml").is_file() or any(data.glob("*/run.json")) or any(data.glob("*.npz")):
        return []
    return sorted(path for path in data.iterdir() if is_bag(path))


def is_bag(path: Path) -> bool:
    """Whether a path looks like a bag."""
    return path.suffix in ENDINGS if path.is_file() else (path / METADATA).is_file()


def converted(bags: Sequence[Path], sources: Sequence[Source]) -> Path:
    """The folder with the episodes of these bags. Raises BagError with a line for each bag that cannot be read."""
    told = json.dumps([RULES, [asdict(source) for source in sources], [[bag.name, checksum(bag)] for bag in bags]])
    folder = cache_dir("bags") / hashlib.sha256(told.encode()).hexdigest()[:20]
    if not (folder / REPORT).is_file():
        make(bags, sources, folder)
    return folder


def make(bags: Sequence[Path], sources: Sequence[Source], folder: Path) -> None:
    """Write the episodes of bags and REPORT into a new folder, which appears when it is whole."""
    beside = folder.with_name(f".{os.getpid()}_{folder.name}")
    shutil.rmtree(beside, ignore_errors=True)
    beside.mkdir(parents=True)
    try:
        reports, errors = [], []
        for number, bag in enumerate(bags):
            try:
                report = sandbox.convert(bag, sources, beside, f"{number:04d}_{file_name(bag.stem)}")
                reports.append({"bag": str(bag), **report})
            except BagError as error:
                errors.append(str(error))
        if errors:
            raise BagError("\n".join(errors))
        write_bytes(beside / REPORT, json.dumps(reports, indent=2).encode())
        if not (folder / REPORT).is_file():
            shutil.rmtree(folder, ignore_errors=True)
            beside.rename(folder)
    finally:
        shutil.rmtree(beside, ignore_errors=True)


def report(folder: Path) -> list[str]:
    """A line for each bag whose episodes are in `folder`: what became of it."""
    return [line(one) for one in read_json(folder / REPORT)]


def line(one: dict[str, Any]) -> str:
    """What became of a bag."""
    forward, left, right = one["moves"]
    many = "s" * (one["episodes"] != 1)
    made = (f"{one['bag']}: {one['episodes']} episode{many}, {forward + left + right} moves ({forward} forward, {left} "
            f"left, {right} right)")
    if one["profile"] == "curionav":
        return f"{made}, as curionav exported them"
    lost = ", ".join(f"{what}: {number}" for what, number in one["left_out"].items())
    return (f"{made} of {one['seconds'] / 60:.1f} min and {one['images']} images, topics of {one['profile']}. "
            f"Left out: {lost or 'nothing'}.")


def checksum(bag: Path) -> str:
    """SHA-256 of a bag's files, with their names. Raises BagError for what is no file."""
    whole = hashlib.sha256()
    for path in sorted(bag.iterdir()) if bag.is_dir() else [bag]:
        if not path.is_file():
            continue
        whole.update(f"{path.name}:{of_file(path, path.stat().st_mtime_ns)}\n".encode())
    return whole.hexdigest()


@lru_cache(1024)
def of_file(path: Path, changed: int) -> str:
    """SHA-256 of a file that was last changed at this time."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
