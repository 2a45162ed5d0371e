"""A bag that is whole or absent: a folder with an MCAP file and metadata.yaml, like `ros2 bag record -s mcap`."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from curionav_cli.bags.messages import STORE, serialised

NEVER = QosTime(0x7FFFFFFFFFFFFFFF // 10**9, 0x7FFFFFFFFFFFFFFF % 10**9)


def quality(latched: bool) -> Qos:
    """The quality of service of a topic; latched: late subscribers get its last message, as those of a map need it."""
    durability = QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE
    return Qos(QosHistory.KEEP_LAST, 1 if latched else 10, QosReliability.RELIABLE, durability, NEVER, NEVER,
               QosLiveliness.AUTOMATIC, NEVER, False)


class BagWriter:
    """Writes a bag at `folder`. It is written beside and appears there when the `with` block ends without an error."""

    def __init__(self, folder: Path, latched: tuple[str, ...] = ()):
        self.folder, self.latched = folder, latched
        self.beside = folder.with_name(f".{os.getpid()}") / folder.name  # rosbags names the file after its folder
        self.topics: dict[str, Connection] = {}

    def __enter__(self) -> BagWriter:
        shutil.rmtree(self.beside.parent, ignore_errors=True)
        self.writer = Writer(self.beside, version=8, storage_plugin=StoragePlugin.MCAP)
        self.writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)  # of chunks
        self.writer.open()
        return self

    def __exit__(self, kind: type[BaseException] | None, *rest: object) -> None:
        try:
            self.writer.close()
            if kind is None:
                flush(self.beside)
                self.beside.rename(self.folder)
        finally:
            shutil.rmtree(self.beside.parent, ignore_errors=True)

    def write(self, topic: str, at: int, message: Any) -> None:
        """Write a message at a time, nanoseconds."""
        kind = message.__msgtype__
        if topic not in self.topics:
            self.topics[topic] = self.writer.add_connection(
                topic, kind, typestore=STORE, offered_qos_profiles=[quality(topic in self.latched)])
        self.writer.write(self.topics[topic], at, serialised(message))


def flush(folder: Path) -> None:
    """Have the files of a folder on the disk."""
    for path in folder.iterdir():
        with open(path, "rb") as file:
            os.fsync(file.fileno())
