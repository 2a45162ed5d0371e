"""The last two weights that a robot took over: what it acts with after a restart, and the ones before, should those
be broken on its disk."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from curionav_cli.errors import WeightsRefused
from curionav_cli.files import write_whole
from curionav_cli.remote.protocol import Pointer, parsed, sha256, written

KEPT = 2


class WeightCache:
    """A folder: 000004-<sha>.safetensors, and 000004-<sha>.json, the pointer, written after them."""

    def __init__(self, folder: Path):
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def keep(self, pointer: Pointer, raw: bytes) -> None:
        write_whole(self.folder / f"{pointer.name}.safetensors", lambda file: file.write(raw))
        write_whole(self.folder / f"{pointer.name}.json", lambda file: file.write(written(pointer)))
        for old in self.notes()[:-KEPT]:
            old.unlink()
            old.with_suffix(".safetensors").unlink(missing_ok=True)

    def notes(self) -> list[Path]:
        """Oldest first."""
        return sorted(self.folder.glob("*.json"))

    def newest(self, adopt: Callable[[bytes], None], say: Callable[[str], None]) -> Pointer | None:
        """Adopt the newest that can be used; None: there are none. Says which could not."""
        for note in reversed(self.notes()):
            try:
                pointer = parsed(Pointer, note.read_bytes())
                raw = note.with_suffix(".safetensors").read_bytes()
                if sha256(raw) != pointer.sha256:
                    raise ValueError("its checksum is another one")
                adopt(raw)
                return pointer
            except (OSError, ValueError, WeightsRefused) as error:
                say(f"kept weights {note.stem} cannot be used ({error})")
        return None
