"""Imports what runs need, then runs each command that it is asked for in a fork of itself (see warm.py).

Lines of JSON in: words, program, cwd, environment, files; lines of JSON out: the return code, negative for a signal.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import traceback
from typing import Any

from paint import unpainted

import curionav_cli.agents.lbs_dreamer.agent
import curionav_cli.agents.lbs_dreamer.open_loop
import curionav_cli.commands.dock
import curionav_cli.commands.resume
import curionav_cli.commands.summary
import curionav_cli.commands.train
import curionav_cli.results.beliefs
import curionav_cli.results.prediction.figures
import curionav_cli.robot.env  # noqa: F401
from curionav_cli import app


def child(order: dict[str, Any]) -> int:
    """The exit code of one command, in this process."""
    os.chdir(order["cwd"])
    os.environ.clear()
    os.environ.update(order["environment"])
    for number, path in enumerate(order["files"], 1):
        os.dup2(os.open(path, os.O_CREAT | os.O_WRONLY | os.O_TRUNC), number)
    sys.argv = ["-c" if order["program"] else "curionav", *order["words"]]
    try:
        with unpainted():
            if order["program"]:
                exec(compile(order["program"], "<program>", "exec"), {"__name__": "__main__"})
            else:
                app.main()
        code = 0
    except SystemExit as stop:
        code = int(stop.code or 0)
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    return code


def serve() -> None:
    for line in sys.stdin:
        pid = os.fork()
        if not pid:
            os._exit(child(json.loads(line)))
        print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), flush=True)


if __name__ == "__main__":
    gc.freeze()
    serve()
