"""curionav watch RUN_OR_SWEEP: a page on this machine that shows runs as they go on."""

from __future__ import annotations

import errno
import shlex
from contextlib import closing
from pathlib import Path

from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.execution.watching.server import Server
from curionav_cli.execution.watching.watched import Watched
from curionav_cli.places import place
from curionav_cli.storage.run_folder import no_folder


def run(folder: Path, port: int) -> int:
    """Serve the page until Ctrl-C; returns the exit code. port 0: one that is free.

    Raises RunFolderError where there is no run, ConfigError where the port is taken.
    """
    folder = place(folder)
    if not folder.is_dir():
        raise RunFolderError(no_folder(folder))
    watched = Watched(folder)
    try:
        server = Server(watched, port)
    except OSError as error:
        raise ConfigError(unusable(folder, port, error)) from error
    with closing(server.socket):
        try:
            print(f"{watched.summary()}\n{server.url}   (Ctrl-C ends)", flush=True)
            server.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt:
            print()
    return 0


def unusable(folder: Path, port: int, error: OSError) -> str:
    """What to do about a port that cannot be used."""
    why = "is taken" if error.errno == errno.EADDRINUSE else f"cannot be used ({error.strerror})"
    return f"Port {port} {why}. Name another, or 0 for any: curionav watch {shlex.quote(str(folder))} --port 0"
