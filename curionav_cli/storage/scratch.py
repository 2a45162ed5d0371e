"""Arrays that do not fit into memory, raw, in a file without a name: gone with its process, however that ends."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import IO

import numpy as np


class Scratch:
    """Append and read back. The file is made in `folder` (none: the system's) when something comes.

    A full disk raises OSError (ENOSPC), as for any other file of a run.
    """

    def __init__(self, folder: Path | None = None):
        self.folder, self.size = folder, 0
        self._file: IO[bytes] | None = None

    def append(self, array: np.ndarray) -> int:
        """Where it begins, in bytes."""
        if self._file is None:
            self._file = tempfile.TemporaryFile(dir=self.folder, buffering=0)  # noqa: SIM115  (close() closes it)
        begin = place = self.size
        left = bytes_of(np.ascontiguousarray(array))
        while left:
            written = os.pwrite(self._file.fileno(), left, place)
            left, place = left[written:], place + written
        self.size = place
        return begin

    def read(self, place: int, out: np.ndarray) -> None:
        """Fill `out`, which is contiguous, with the bytes at `place`."""
        if self._file is None:
            raise ValueError("nothing was ever written to this file")
        left = bytes_of(out)
        while left:
            got = os.preadv(self._file.fileno(), [left], place)
            if not got:
                raise OSError(f"the scratch file in {self.folder} ends at {place} of {self.size} bytes")
            left, place = left[got:], place + got

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
            self._file = None


def bytes_of(array: np.ndarray) -> memoryview:
    """The memory of a contiguous array itself, no copy of it."""
    return array.reshape(-1).data.cast("B")
