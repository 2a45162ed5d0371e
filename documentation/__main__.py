"""python -m documentation: write docs/reference/settings.md and docs/reference/commands.md."""

from __future__ import annotations

from documentation.pages import write

if __name__ == "__main__":
    for path in write():
        print(path)
