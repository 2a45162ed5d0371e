"""A model card's folder: what `curionav card` writes, and evaluate, explore and train open (docs/card.md).

    README.md              what it is, in words
    card.json              what the program reads: for how long it was trained, where, the SHA-256 of its weights
    config.yaml            the settings, without the paths and hosts of the machine that it was trained on
    weights.safetensors    the networks
    metrics.jsonl, figures/
"""

from __future__ import annotations

import hashlib
import math
import shutil
from pathlib import Path
from typing import Any

from safetensors import safe_open

from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.files import CRC32, read_json
from curionav_cli.places import cache_dir

CARD, WEIGHTS = "card.json", "weights.safetensors"
RECIPES = {"apartments": "make pretrained"}  # how a checkout makes them


def is_card(folder: Path) -> bool:
    """Whether the folder is that of a card."""
    return (folder / CARD).is_file()


def read_card(folder: Path) -> dict[str, Any]:
    """The content of card.json. Raises RunFolderError where it is broken, or the weights are not those it names."""
    card = read_json(folder / CARD)
    try:
        digest = sha256(folder / WEIGHTS)
    except OSError as error:
        raise RunFolderError(f"{error.filename} cannot be read ({error.strerror}). Restore it from a copy.") from error
    if not isinstance(card, dict) or card.get("sha256") != digest:
        raise RunFolderError(f"{folder / WEIGHTS} is not whole (its checksum is another one). Restore it from a copy.")
    return card


def sha256(path: Path) -> str:
    """The SHA-256 of a file, in hexadecimal. Raises OSError."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def parameters(weights: Path) -> int:
    """How many numbers a safetensors file holds."""
    with safe_open(weights, "np") as tensors:
        return sum(math.prod(tensors.get_slice(name).get_shape()) for name in tensors.keys())  # noqa: SIM118


def write_card(folder: Path, card: dict[str, Any], texts: dict[str, str], files: dict[str, Path]) -> None:
    """Make the folder, whole or not at all: card.json, texts and copies of files, by name. Raises OSError."""
    beside = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(beside, ignore_errors=True)
    for name, source in files.items():
        (beside / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, beside / name)
    for name, text in {**texts, CARD: CRC32.sealed(card)}.items():
        (beside / name).write_text(text, encoding="utf-8")
    beside.replace(folder)


def cache() -> Path:
    """The user's folder of pretrained agents, by the XDG rules."""
    return cache_dir("pretrained")


def pretrained(name: str) -> Path:
    """The card of a pretrained agent in the user's cache. Raises ConfigError that says how to make it."""
    folder = cache() / name
    if folder.parent == cache() and is_card(folder):
        return folder
    there = sorted(path.name for path in cache().glob("*") if is_card(path))
    made = f"Make it in a checkout: {RECIPES[name]}" if name in RECIPES else \
        f"There {'is' if len(there) == 1 else 'are'} {', '.join(there) or 'none yet; make pretrained makes apartments'}"
    raise ConfigError(f"pretrained={name}: there is no such agent in {cache()}. {made}.")
