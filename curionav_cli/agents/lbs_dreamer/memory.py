"""What the learner frees, it keeps: every update frees and asks for the same hundreds of megabytes.

glibc hands large blocks back to the kernel, which clears each page anew when it is next asked for:
a fifth of an update's CPU seconds, now and then or always, depending on what happens to lie on top.
"""

from __future__ import annotations

import ctypes
import sys

# glibc's malloc.h: trim the heap when so much is free on top (-1: never); so many blocks outside the heap.
M_TRIM_THRESHOLD, NEVER = -1, -1
M_MMAP_MAX, NONE = -4, 0


def keep_freed_memory() -> None:
    """From here on this process does not shrink. Without effect where the C library is not glibc."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt:
        mallopt(M_TRIM_THRESHOLD, NEVER)
        mallopt(M_MMAP_MAX, NONE)
