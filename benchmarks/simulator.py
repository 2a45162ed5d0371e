"""Ours beside ViZDoom and Miniworld: environment steps a second of CPU time, on this machine, in one run.

    python benchmarks/simulator.py            about six minutes; needs Linux and a package index
    python benchmarks/simulator.py --write    also puts the table into benchmarks/RESULTS.md

Installs the versions below into a temporary virtual environment. Miniworld needs EGL: on Debian
`apt-get install libegl1 libgl1-mesa-dri libglu1-mesa`. Repeats are interleaved, so that a machine that is
shared slows all alike; the median and the quartiles over repeats are shown.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import venv
from datetime import date
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
PINNED = (
    "vizdoom==1.3.2", "miniworld==2.1.0", "pyglet==1.5.31", "gymnasium==1.4.0", "numpy==2.4.6", "scipy==1.17.1",
    "numba==0.68.1", "PyYAML==6.0.3", "opencv-python-headless==5.0.0.93",
)
RESULTS = HERE / "RESULTS.md"
DOOM, MINIWORLD = "ViZDoom, RGB and depth, resized to 64 x 64", "Miniworld, RGB and depth"


def install(folder: Path) -> Path:
    """A virtual environment with the pinned versions; returns its Python."""
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    subprocess.run([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PINNED], check=True)
    return python


def measure(python: Path, name: str, steps: int, folder: str) -> dict[str, float] | None:
    """One repeat of one contender; None where it does not run on this machine. ViZDoom writes into `folder`."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "SDL_AUDIODRIVER": "dummy"}
    done = subprocess.run([python, HERE / "contenders.py", name, str(steps)], capture_output=True, text=True,
                          env=environment, cwd=folder, check=False)
    if done.returncode:
        print(f"{name}: {(done.stderr.strip() or 'failed').splitlines()[-1]}", file=sys.stderr)
        return None
    return json.loads(done.stdout.strip().splitlines()[-1])


def table(seconds: dict[str, list[float]]) -> str:
    """Markdown: steps a CPU-second, quartiles, and how many times ViZDoom and Miniworld that is."""
    typical = {name: 1.0 / np.median(times) for name, times in seconds.items()}
    lines = ["| simulator | steps a CPU-second | quartiles | x ViZDoom | x Miniworld |", "|---|---|---|---|---|"]
    for name, times in seconds.items():
        low, high = 1.0 / np.quantile(times, (0.75, 0.25))
        ratios = [f"{typical[name] / typical[other]:.2f}" if other in typical else "-"
                  for other in (DOOM, MINIWORLD)]
        lines.append(f"| {name} | {typical[name]:.0f} | {low:.0f} to {high:.0f} | {ratios[0]} | {ratios[1]} |")
    return "\n".join(lines)


def machine() -> str:
    model = next((line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                  if line.startswith("model name")), platform.processor())
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}"


def write(text: str, section: str = "simulator") -> None:
    """Replaces what stands between the two marks of a section in RESULTS.md."""
    begin, end = f"<!-- {section} -->", f"<!-- /{section} -->"
    before, _, rest = RESULTS.read_text(encoding="utf-8").partition(begin)
    after = rest.partition(end)[2]
    RESULTS.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--steps", type=int, default=3000, help="environment steps of one repeat")
    parser.add_argument("--only", default="", help="only contenders whose name contains this")
    parser.add_argument("--python", type=Path, help="a Python that has the pinned packages; installs nothing")
    parser.add_argument("--write", action="store_true", help="put the table into benchmarks/RESULTS.md")
    chosen = parser.parse_args()
    sys.path.insert(0, str(HERE))
    from contenders import CONTENDERS

    with tempfile.TemporaryDirectory() as folder:
        python = chosen.python or install(Path(folder))
        names = [name for name in CONTENDERS if chosen.only in name]
        seconds: dict[str, list[float]] = {name: [] for name in names}
        for repeat in range(chosen.repeats):
            for name in names:
                measured = measure(python, name, chosen.steps, folder)
                if measured:
                    seconds[name].append(measured["seconds"])
            print(f"repeat {repeat + 1} of {chosen.repeats} done", file=sys.stderr)
        big = measure(python, "office", 0, folder)
    text = f"{machine()}, {date.today()}; {', '.join(PINNED)}; {chosen.repeats} repeats of {chosen.steps} steps.\n\n"
    text += table({name: times for name, times in seconds.items() if times})
    if big:
        text += (f"\n\nA map of 100 x 100 m at 5 cm ({big['boxes']:.0f} boxes) loads in {big['load']:.1f} CPU-seconds "
                 f"and takes {big['memory']:.0f} MB.")
    print(text)
    if chosen.write:
        write(text)


if __name__ == "__main__":
    main()
