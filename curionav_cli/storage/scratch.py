"""Raw arrays in an unnamed file, for what does not fit into memory: gone with its process, however that ends."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from typing import IO

import numpy as np


class Scratch:
    """A file to put arrays into and read them back from. folder: None is the system's.

    The file is made with the first array. Raises OSError (ENOSPC) where the disk is full. size: of the file in bytes;
    free: offsets of arrays that were removed, with their bytes.
    """

    def __init__(self, folder: Path | None = None):
        self.folder, self.size = folder, 0
        self.free: dict[int, int] = {}
        self._file: IO[bytes] | None = None

    def append(self, array: np.ndarray) -> int:
        """Write an array, where a removed one left room or at the end; its offset in the file in bytes."""
        if self._file is None:
            self._file = tempfile.TemporaryFile(dir=self.folder, buffering=0)  # noqa: SIM115  (close() closes it)
        left = bytes_of(np.ascontiguousarray(array))
        begin = place = next((at for at, room in self.free.items() if room >= len(left)), self.size)
        while left:
            written = os.pwrite(self._file.fileno(), left, place)
            left, place = left[written:], place + written
        self.size = max(self.size, place)
        self.free.pop(begin, None)
        return begin

    def remove(self, place: int, nbytes: int) -> None:
        """Free the room of the array of so many bytes at offset `place`."""
        self.free[place] = nbytes

    def read(self, place: int, out: np.ndarray) -> None:
        """Fill `out`, which is contiguous, with the bytes at offset `place`. Raises OSError where they end early."""
        if self._file is None:
            raise ValueError("nothing was ever written to this file")
        left = bytes_of(out)
        while left:
            got = os.preadv(self._file.fileno(), [left], place)
            if not got:
                raise OSError(f"the scratch file in {self.folder} ends at {place} of {self.size} bytes")
            left, place = left[got:], place + got

    def close(self) -> None:
        """Remove the file."""
        if self._file is not None:
            self._file.close()
            self._file = None


def bytes_of(array: np.ndarray) -> memoryview:
    """The memory of a contiguous array, not a copy."""
    return array.reshape(-1).data.cast("B")
