"""One update of our learner beside one of its peers, and the machine's own limit beside both.

    .venv/bin/python benchmarks/learner.py --write                  # about an hour on one core
    .venv/bin/python benchmarks/learner.py --scale cpu --only curionav --repeats 3
    .venv/bin/python benchmarks/learner.py --device cuda --write

Every contender is a process of its own and stays alive; in each repeat every one updates and acts in its turn, on
one thread, so that a machine that is shared slows all alike. A peer that is not installed is left out, and named.
Each has a virtual environment of its own:

    python3.11 -m venv .venv/peers/sheeprl
    .venv/peers/sheeprl/bin/pip install -c constraints.txt torch==2.13.0 hydra-core gymnasium rich \\
        opencv-python-headless lightning torchmetrics tensorboard python-dotenv
    .venv/peers/sheeprl/bin/pip install --no-deps sheeprl==0.8.4
    python3.11 -m venv .venv/peers/dreamerv2
    .venv/peers/dreamerv2/bin/pip install 'numpy<2' tensorflow-cpu==2.15.1 tensorflow-probability==0.23.0 \\
        ruamel.yaml setuptools cloudpickle gym-notices
    .venv/peers/dreamerv2/bin/pip install --no-deps --no-build-isolation gym==0.26.2 dreamerv2==2.2.0
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from contextlib import ExitStack, suppress
from dataclasses import asdict
from datetime import date
from enum import Enum
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, NamedTuple

import numpy as np
from learner_contenders import CPU, CUDA, dense, settings
from simulator import HERE, machine, write

REPEATS = {"paper": 3, "cpu": 11}  # unless --repeats says otherwise
STEPS = {CPU: 100, CUDA: 1000}  # of acting, in one repeat
IN_A_ROW = 100  # updates in one repeat on a GPU
EPISODE = (500, 100)  # steps and updates
PEERS_WORK = (  # what scale=cpu leaves out and the peers do: DreamerV2's CNN, every frame, state, time and step
    "agent.encoder_channels=[8,16,32,64]", "agent.encoder_kernels=[4,4,4,4]", "agent.encoder_strides=[2,2,2,2]",
    "agent.decoder_channels=[32,16,8]", "agent.decoder_kernels=[5,5,6,6]", "agent.decoder_strides=[2,2,2,2]",
    "agent.decoded_share=1", "agent.imagination_starts=140", "agent.behaviour_interval=1", "agent.action_repeat=1",
)
WARM = 3  # updates before the first that is measured: until then memory is asked for that is kept afterwards


class Row(NamedTuple):
    """A line of the table."""

    contender: str
    precision: str
    overrides: tuple[str, ...] = ()
    what: str = ""  # the overrides are, in words

    def __str__(self) -> str:
        return ", ".join(filter(None, (self.contender, self.what, self.precision)))


PAPER = [Row(name, precision) for name in ("curionav", "sheeprl") for precision in ("float32", "bfloat16")]
ROWS = {
    "paper": [*PAPER[:2], Row("curionav", "bfloat16", ("agent.decoded_share=0.5",), "half of the frames drawn"),
              *PAPER[2:], Row("dreamerv2", "float32")],
    "cpu": [*PAPER[:2], Row("curionav", "float32", PEERS_WORK, "the same work"),
            *(row._replace(overrides=PEERS_WORK) for row in (*PAPER[2:], Row("dreamerv2", "float32")))],
}


class Gone(Exception):
    """A contender that does not run here, and why."""


class Process:
    """A contender in its Python, asked over a pipe."""

    def __init__(self, python: Path, name: str, job: dict[str, Any], errors: Any):
        if not python.exists():
            raise Gone("is not installed; the first lines of benchmarks/learner.py say how")
        self.errors = errors
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OMP_WAIT_POLICY": "PASSIVE"}
        self.child = subprocess.Popen([python, HERE / "learner_peers.py", name, json.dumps(job)], text=True, bufsize=1,
                                      stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, env=environment)

    def ask(self, *request: Any) -> Any:
        """Its answer. Raises Gone where it ended instead."""
        try:
            print(json.dumps(request), file=self.child.stdin, flush=True)
            return json.loads(self.child.stdout.readline())
        except (BrokenPipeError, json.JSONDecodeError) as error:
            self.errors.seek(0)
            said = self.errors.read().decode(errors="replace").strip().splitlines()
            raise Gone(f"ended: {said[-1] if said else 'without a word'}") from error

    def close(self) -> None:
        with suppress(BrokenPipeError):
            self.child.stdin.close()
        self.child.stdout.close()
        self.child.wait()


class Measured(NamedTuple):
    """One row's numbers: a list over repeats each."""

    update: np.ndarray  # seconds
    act: np.ndarray  # seconds
    peak: np.ndarray  # GFLOP/s of the machine beside the update, in the row's precision
    gflop: float  # of one update
    counted: bool  # or by the formula
    memory: float  # bytes
    versions: list[str]


def hyper(scale: str, overrides: tuple[str, ...]) -> tuple[list[str], dict[str, Any]]:
    """What to compose, and the shapes that come of it."""
    words = [f"scale={scale}", *overrides]
    shapes = asdict(settings(words).agent)
    return words, {key: value.value if isinstance(value, Enum) else value for key, value in shapes.items()}


class Stage:
    """The contenders of a scale, each alive, and the probe."""

    def __init__(self, scale: str, device: str, peers: Path, stack: ExitStack):
        self.scale, self.device, self.peers, self.stack = scale, device, peers, stack
        self.alive: dict[Row, Process] = {}
        self.times: dict[Row, int] = {}
        self.gflop: dict[Row, tuple[float, bool]] = {}  # of an update; counted, or by the formula
        self.left_out: dict[Row, str] = {}
        self.probe = self.process("probe", {})

    def process(self, name: str, job: dict[str, Any]) -> Process:
        own = Path(sys.executable)
        python = own if name in ("curionav", "probe") else self.peers / name / "bin" / "python"
        errors = self.stack.enter_context(TemporaryFile())  # noqa: SIM115 the stack closes it
        process = Process(python, name, {"device": self.device, **job}, errors)
        self.stack.callback(process.close)
        return process

    def enter(self, row: Row) -> None:
        """Start and warm up a contender; where it cannot, say so."""
        words, shapes = hyper(self.scale, row.overrides)
        self.times[row] = IN_A_ROW if self.device == CUDA else shapes["behaviour_interval"]
        try:
            process = self.process(row.contender, {"precision": row.precision, "times": self.times[row],
                                                   "hyper": shapes, "overrides": words})
            counted = process.ask("warm")
            process.ask("update", WARM)
            process.ask("act", STEPS[self.device] // 10)
            self.alive[row], self.gflop[row] = process, (counted or dense(shapes), counted is not None)
        except Gone as error:
            self.left_out[row] = str(error)
        print(f"{self.scale}: {row} {self.left_out.get(row, 'is ready')}", file=sys.stderr)

    def measure(self, repeats: int) -> tuple[dict[Row, Measured], list[dict[str, float]]]:
        """All rows, interleaved, and what the machine could do beside each update."""
        seconds: dict[Row, list[tuple[float, float, float]]] = {row: [] for row in self.alive}
        peaks = []
        for repeat in range(repeats):
            for row in list(self.alive):
                peaks.append(self.probe.ask("peaks"))
                try:
                    seconds[row].append((self.alive[row].ask("update", self.times[row]),
                                         self.alive[row].ask("act", STEPS[self.device]), peaks[-1][row.precision]))
                except Gone as error:
                    del self.alive[row]
                    self.left_out[row] = str(error)
            print(f"{self.scale}: repeat {repeat + 1} of {repeats} done", file=sys.stderr)
        return {row: Measured(*np.array(seconds[row]).T, *self.gflop[row], **process.ask("about"))
                for row, process in self.alive.items()}, peaks


def table(measured: dict[Row, Measured], device: str) -> str:
    """Markdown: what an update takes, how near to the limit that is, and how many times faster than each peer."""
    middle = {row: float(np.median(numbers.update)) for row, numbers in measured.items()}
    peers = [row for row in measured if row.contender != "curionav" and row.precision == "float32"]
    unit, many = ("ms", 1e3) if device == CUDA else ("CPU-s", 1.0)
    columns = ["learner", f"{unit} an update", "quartiles", "GFLOP", "GFLOP/s", "of the peak", "ms a step of acting",
               "steps a second", "s an episode", "GB", *(f"x {peer}" for peer in peers)]
    lines = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for row, numbers in measured.items():
        low, high = many * np.quantile(numbers.update, (0.25, 0.75))
        rate, act = numbers.gflop / numbers.update, float(np.median(numbers.act))
        cells = [str(row), f"{many * middle[row]:.3g}", f"{low:.3g} to {high:.3g}",
                 f"{numbers.gflop:.4g}" + ("" if numbers.counted else " by formula"), f"{np.median(rate):.3g}",
                 f"{np.median(rate / numbers.peak):.0%}", f"{1e3 * act:.2f}", f"{1 / act:.0f}",
                 f"{EPISODE[0] * act + EPISODE[1] * middle[row]:.3g}", f"{numbers.memory / 1e9:.2f}",
                 *(f"{middle[peer] / middle[row]:.2f}" for peer in peers)]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def section(scale: str, device: str, repeats: int, only: str, peers: Path) -> str:
    """What RESULTS.md says of a scale: where, when, with what, and the table."""
    before = os.getloadavg()[0]
    with ExitStack() as stack:
        stage = Stage(scale, device, peers, stack)
        for row in ROWS[scale]:
            if only in str(row):
                stage.enter(row)
        measured, peaks = stage.measure(repeats)
    left_out = [f"\nLeft out: {row}. It {why}." for row, why in stage.left_out.items()]
    if not measured:
        raise SystemExit("Nothing was measured." + "".join(left_out))
    versions = sorted({name for numbers in measured.values() for name in numbers.versions})
    lines = [f"scale={scale}, device={device}. {place(device)}, {date.today()}; {', '.join(versions)}; n = {repeats}; "
             f"load average {before:.1f} before and {os.getloadavg()[0]:.1f} after.\n"]
    work = dense(hyper(scale, ())[1], again=False)
    for precision in ("float32", "bfloat16"):
        low, middle, high = np.quantile([peak[precision] for peak in peaks], (0.25, 0.5, 0.75))
        lines.append(f"- Peak in {precision}: {middle:.4g} GFLOP/s, quartiles {low:.4g} to {high:.4g}. At it an update "
                     f"of ours, {work:.4g} GFLOP with every product done, takes {work / middle:.3g} s.")
    return "\n".join([*lines, "", table(measured, device), *left_out])


def place(device: str) -> str:
    """The machine, its GPU where that is what is measured, and the version of ours."""
    from curionav_cli.storage.provenance import commit

    made, where = commit(), machine()
    if device == CUDA:
        import torch

        where = f"{torch.cuda.get_device_name()}, {where}"
    return f"{where}; commit {(made['git_commit'] or 'unknown')[:8]}{' and changes' if made['git_changed'] else ''}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, help=f"default {REPEATS}")
    parser.add_argument("--scale", choices=list(ROWS), help="default: both")
    parser.add_argument("--device", choices=(CPU, CUDA), default=CPU)
    parser.add_argument("--only", default="", help="only learners whose line of the table contains this")
    parser.add_argument("--peers", type=Path, default=HERE.parent / ".venv" / "peers", help="where they are installed")
    parser.add_argument("--write", action="store_true", help="put the tables into benchmarks/RESULTS.md")
    options = parser.parse_args()
    for scale in [options.scale] if options.scale else ROWS:
        text = section(scale, options.device, options.repeats or REPEATS[scale], options.only, options.peers)
        print(text)
        if options.write:
            write(text, f"learner {scale} {options.device}")


if __name__ == "__main__":
    main()
