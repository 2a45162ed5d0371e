"""How long a run takes to end after SIGTERM, at a random moment of acting, learning, saving or docking.

    python benchmarks/stopping.py [--repeats 5]

Seconds on the wall, until the process is gone; every run must say that it was stopped and exit with 143.
"""

from __future__ import annotations

import argparse
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from curionav_cli.storage.run_folder import RunFolder

ROOM, FOREVER = "env=small_room", "loop.episodes=100000"
COMMANDS = {
    "random": ("explore", ROOM, "agent=random", FOREVER),
    "cbet": ("explore", ROOM, "agent=cbet", FOREVER),
    "lbs_dreamer": ("explore", ROOM, "agent=lbs_dreamer", FOREVER, "loop.steps=100"),
    "lbs_dreamer, scale=paper": ("explore", ROOM, "agent=lbs_dreamer", "scale=paper", FOREVER, "loop.steps=60",
                                 "loop.iterations=1", "device=cpu"),
    "dock": ("dock", "env=large_lab", "dock.requests=100000"),
}


def main() -> None:
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--repeats", type=int, default=5)
    repeats, rng = asked.parse_args().repeats, random.Random(0)
    print("| what | n | median, s | longest, s |\n|---|---|---|---|")
    for name, words in COMMANDS.items():
        took = sorted(stopped(words, rng.uniform(0, 10)) for _ in range(repeats))
        print(f"| {name} | {repeats} | {took[repeats // 2]:.2f} | {took[-1]:.2f} |", flush=True)


def stopped(words: tuple[str, ...], later: float) -> float:
    """Seconds from a SIGTERM to the end of a run that has had so many since its first episode (or request)."""
    with tempfile.TemporaryDirectory() as folder:
        run = RunFolder(Path(folder) / "run")
        process = subprocess.Popen([sys.executable, "-m", "curionav_cli", *words, f"hydra.run.dir={run.path}"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while not run.metrics():
            assert process.poll() is None, process.communicate()[1]
            time.sleep(0.1)
        time.sleep(later)
        began = time.perf_counter()
        process.send_signal(signal.SIGTERM)
        _, said = process.communicate()
        took = time.perf_counter() - began
        assert process.returncode == 143 and "Stopped by SIGTERM" in said, (process.returncode, said)
        return took


if __name__ == "__main__":
    main()
