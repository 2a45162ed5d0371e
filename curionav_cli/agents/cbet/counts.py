"""Counts of keys: one table for each environment, or one for all."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

Table = dict[bytes, int]


class Counts:
    """Counts keys in `tables` dictionaries; environment e uses table e modulo their number.

    lasting: they are hardly ever cleared, so that a checkpoint holds only what changed since the one before
    (count_log.py).
    """

    def __init__(self, tables: int, lasting: bool = False):
        self.tables: list[Table] = [{} for _ in range(tables)]
        self.lasting = lasting
        self.forget_news()

    def add(self, environment: int, key: bytes) -> int:
        """Count a key once more; returns its count, this time included."""
        number = environment % len(self.tables)
        count = self.tables[number].get(key, 0) + 1
        self.tables[number][key] = count
        if self.lasting:
            self.changed[number][key] = count
        return count

    def clear(self, environment: int) -> None:
        """Forget all counts of this environment's table."""
        number = environment % len(self.tables)
        self.tables[number].clear()
        self.changed[number].clear()
        self.cleared[number] = True

    def forget_news(self) -> None:
        """Begin to note what changes."""
        self.changed: list[Table] = [{} for _ in self.tables]
        self.cleared = [False] * len(self.tables)

    def news(self, everything: bool) -> Iterator[tuple[bool, Table]]:
        """Of each table whether it was cleared since the last time, and the counts that changed since, or all of them.
        """
        yield from zip(self.cleared, self.tables if everything else self.changed)
        self.forget_news()

    def state(self) -> dict[str, np.ndarray]:
        """Return keys (n, bytes) uint8 and counts (n,) int64 of each table, in the order of insertion."""
        arrays = {}
        for number, table in enumerate(self.tables):
            keys = np.array(bytearray(b"".join(table)), np.uint8)
            arrays[f"{number}/keys"] = keys.reshape(len(table), -1) if table else keys.reshape(0, 0)
            arrays[f"{number}/counts"] = np.fromiter(table.values(), np.int64, len(table))
        return arrays

    def load_state(self, arrays: dict[str, np.ndarray]) -> None:
        """Replace the tables by what `state` returned."""
        for number in range(len(self.tables)):
            keys, counts = arrays[f"{number}/keys"], arrays[f"{number}/counts"]
            self.tables[number] = {key.tobytes(): count for key, count in zip(keys, counts.tolist(), strict=True)}
