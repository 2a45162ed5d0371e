"""The last two weights that a robot imported: those it acts with after a restart, and the ones before.

The ones before are used where the newest are broken on the disk.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from curionav_cli.errors import WeightsRefused
from curionav_cli.files import write_bytes
from curionav_cli.remote.protocol import Pointer, parsed, sha256, written

KEPT = 2


class WeightCache:
    """A folder of weights: 000004-<sha>.safetensors, and its pointer 000004-<sha>.json, written after it."""

    def __init__(self, folder: Path):
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def keep(self, pointer: Pointer, raw: bytes) -> None:
        """Write weights and their pointer, and remove older ones."""
        write_bytes(self.folder / f"{pointer.name}.safetensors", raw)
        write_bytes(self.folder / f"{pointer.name}.json", written(pointer))
        for old in self.notes()[:-KEPT]:
            old.unlink()
            old.with_suffix(".safetensors").unlink(missing_ok=True)

    def notes(self) -> list[Path]:
        """Files of pointers, oldest first."""
        return sorted(self.folder.glob("*.json"))

    def newest(self, import_weights: Callable[[bytes], None], say: Callable[[str], None]) -> Pointer | None:
        """Import the newest weights that can be used; their pointer, None where there are none. Says which cannot."""
        for note in reversed(self.notes()):
            try:
                pointer = parsed(Pointer, note.read_bytes())
                raw = note.with_suffix(".safetensors").read_bytes()
                if sha256(raw) != pointer.sha256:
                    raise ValueError("its checksum is another one")
                import_weights(raw)
                return pointer
            except (OSError, ValueError, WeightsRefused) as error:
                say(f"kept weights {note.stem} cannot be used ({error})")
        return None
