"""Counts of keys: one table for each environment, or one for all."""

from __future__ import annotations

import numpy as np

Table = dict[bytes, int]


class Counts:
    """Counts keys in `tables` dictionaries; environment e uses table e modulo their number."""

    def __init__(self, tables: int):
        self.tables: list[Table] = [{} for _ in range(tables)]

    def add(self, environment: int, key: bytes) -> int:
        """Count a key once more; returns its count, this time included."""
        table = self.tables[environment % len(self.tables)]
        count = table.get(key, 0) + 1
        table[key] = count
        return count

    def clear(self, environment: int) -> None:
        """Forget all counts of this environment's table."""
        self.tables[environment % len(self.tables)].clear()

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
