"""Bags with altered bytes: whatever stands in a file, reading it ends with episodes or with a BagError of one line.

It runs in a process of its own, bounded as the one that reads bags is, because its inputs are drawn at random.
"""

from __future__ import annotations

import multiprocessing
import resource
import shutil
import traceback
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

MEMORY = 2 << 30


def altered(raw: bytes, rng: np.random.Generator) -> bytes:
    """Some bytes flipped, a stretch lost, doubled or zeroed, or the end cut off."""
    data = bytearray(raw)
    kind = rng.integers(0, 6)
    first, second = sorted(rng.integers(0, len(data), 2).tolist())
    second = min(second, first + int(rng.integers(1, 64)))
    if kind <= 2:
        for place in rng.integers(0, len(data), int(rng.integers(1, 12))).tolist():
            data[place] ^= 1 << int(rng.integers(0, 8)) if kind else int(rng.integers(1, 256))
    elif kind == 3:
        data[first:second] = bytes(second - first) if rng.random() < 0.5 else b"\xff" * (second - first)
    elif kind == 4:
        data[first:first] = data[first:second]
    else:
        del data[first:second if rng.random() < 0.5 else len(data)]
    return bytes(data)


def tried(bags: Sequence[tuple[Path, str]], folder: Path, seed: int, count: int) -> tuple[Counter[str], list[str]]:
    """Outcomes of `count` altered bags, and what was wrong. bags: each with the name of the file to alter, or ''."""
    from curionav_cli.bags import source
    from curionav_cli.bags.intake import episodes
    from curionav_cli.errors import BagError

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    sources, outcomes, wrong = source.known(), Counter[str](), []
    for case in range(count):
        rng = np.random.default_rng([seed, case])
        bag, name = bags[case % len(bags)]
        copy = folder / f"{case}{bag.suffix}"
        (shutil.copytree if bag.is_dir() else shutil.copy)(bag, copy)
        file = copy / name if name else copy
        file.write_bytes(altered(file.read_bytes(), rng))
        try:
            found = list(episodes(copy, sources, {}))
            outcomes[f"{bag.name}: episodes"] += 1
            if not all(one.image.shape == (len(one) + 1, 64, 64, 3) and np.isfinite(one.pose).all() for one in found):
                wrong.append(f"{seed}, {case}: episodes of other shapes")
        except MemoryError:
            outcomes[f"{bag.name}: no memory"] += 1
        except BagError as error:
            outcomes[f"{bag.name}: a line"] += 1
            if "\n" in str(error) or not str(error).startswith(str(copy)):
                wrong.append(f"{seed}, {case}: {error}")
        except Exception:
            wrong.append(f"{seed}, {case}: {traceback.format_exc()}")
        (shutil.rmtree if copy.is_dir() else Path.unlink)(copy)
    return outcomes, wrong


def in_a_process(*arguments) -> tuple[Counter[str], list[str]]:
    """`tried` in a process of its own."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(tried, arguments)
