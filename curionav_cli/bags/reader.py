"""Anybody's bag: MCAP, a ROS 2 folder (MCAP or SQLite), ROS 1. Only messages of known standard types are decoded.

The types are those of rosbags; a definition that stands in the bag is never used, because code would be made of it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.interfaces import Connection, ConnectionExtRosbag2
from rosbags.rosbag1 import Reader as Ros1
from rosbags.rosbag2 import Reader as Ros2
from rosbags.typesys import Stores, get_typestore

from curionav_cli.bags.ours import NUMBERS, TEXT
from curionav_cli.errors import BagError
from curionav_cli.live.transport import Message

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
IMAGES = ("sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Image")
DEPTHS = "sensor_msgs/msg/Image"
ODOMETRY = ("nav_msgs/msg/Odometry",)
KNOWN = (*IMAGES, *ODOMETRY, NUMBERS, TEXT)
LARGEST = 1 << 28  # bytes of a message
SHOWN = 200  # characters of another library's words


class Received(NamedTuple):
    """A message as rosbridge would send it; recorded: seconds, when it was written to the bag."""

    topic: str
    kind: str
    message: Message
    recorded: float


class Bag:
    """An open bag. topics: name -> type."""

    def __init__(self, path: Path, reader: Ros1 | Ros2):
        self.path, self.reader = path, reader
        with readable(path):
            self.topics = {one.topic: one.msgtype for one in reader.connections}

    def messages(self, *topics: str) -> Iterator[Received]:
        """Yield the messages of these topics in the order in which they were recorded. Raises BagError."""
        wanted = [one for one in self.reader.connections if one.topic in topics]
        self._refuse_unknown(wanted)
        with readable(self.path):
            for connection, recorded, raw in self.reader.messages(wanted) if wanted else ():
                if len(raw) > LARGEST:
                    raise BagError(f"{self.path}: a message of {len(raw)} bytes on {connection.topic}; "
                                   f"the most is {LARGEST}.")
                yield Received(connection.topic, connection.msgtype, self._decoded(connection, raw), 1e-9 * recorded)

    def _refuse_unknown(self, wanted: Collection[Connection]) -> None:
        """Raises BagError for a type or an encoding that is not read."""
        for one in wanted:
            coded = one.ext.serialization_format if isinstance(one.ext, ConnectionExtRosbag2) else "ros1"
            if one.msgtype not in KNOWN or coded not in ("cdr", "ros1"):
                raise BagError(f"{self.path}: {one.topic} is of type {printable(one.msgtype)} ({printable(coded)}), "
                               f"and is read as one of {', '.join(KNOWN)} (cdr).")

    def _decoded(self, connection: Connection, raw: bytes) -> Message:
        if isinstance(self.reader, Ros1):
            return plain(ROS1.deserialize_ros1(raw, connection.msgtype))
        return plain(ROS2.deserialize_cdr(raw, connection.msgtype))


@contextmanager
def opened(path: Path) -> Iterator[Bag]:
    """The bag at `path`, open. Raises BagError where it cannot be read."""
    with readable(path):
        reader = Ros1(path) if path.suffix == ".bag" else Ros2(path)
        reader.open()
    try:
        yield Bag(path, reader)
    finally:
        reader.close()


@contextmanager
def readable(path: Path) -> Iterator[None]:
    """Turns whatever a library raises over a broken bag into a BagError of one line; MemoryError passes."""
    try:
        yield
    except (BagError, MemoryError):
        raise
    except Exception as error:  # of rosbags, struct, zstd, lz4, bz2, SQLite, YAML: a broken bag can raise any
        raise BagError(f"{path} cannot be read as a bag: it is broken, cut short, or none "
                       f"({type(error).__name__}: {printable(str(error))}).") from error


def printable(text: str) -> str:
    """Another's words as one line of a bounded length."""
    line = " ".join(text.split())
    return "".join(sign if sign.isprintable() else "?" for sign in line[:SHOWN])


def plain(found: Any) -> Any:
    """A message as dictionaries, lists, numbers, text and bytes, as rosbridge has them."""
    if hasattr(found, "__dataclass_fields__"):
        return {key: plain(getattr(found, key)) for key in found.__dataclass_fields__ if key != "__msgtype__"}
    if isinstance(found, np.ndarray):
        return found.tobytes() if found.dtype == np.uint8 else found
    return [plain(one) for one in found] if isinstance(found, list) else found
