"""Many runs read side by side, each once; a folder that nothing can be read of is a line of text instead."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from curionav_cli.errors import RunFolderError
from curionav_cli.results.comparison.run_summaries import RunSummary, folders, read

FEW = 8  # runs are read sooner than processes start


def read_all(paths: Sequence[Path], rule: str, denominator: str, but: Sequence[Path] = ()
             ) -> tuple[list[RunSummary], list[str]]:
    """Every run in these folders once, and a line for each folder that holds none, or none that can be read.

    but: folders that are passed over.
    """
    jobs, lost = jobs_in(paths)
    jobs = {whole: job for whole, job in jobs.items() if job not in but}
    read_one = partial(read_or_reason, rule=rule, denominator=denominator)
    if len(jobs) <= FEW:
        results = list(map(read_one, jobs.values()))
    else:
        with workers() as pool:
            results = list(pool.map(read_one, jobs.values()))
    return ([result for result in results if isinstance(result, RunSummary)],
            lost + [result for result in results if isinstance(result, str)])


def jobs_in(paths: Sequence[Path]) -> tuple[dict[Path, Path], list[str]]:
    """Every job in these folders once, by its whole path, and a line for each folder that holds none."""
    jobs: dict[Path, Path] = {}
    lost = []
    for path in paths:
        try:
            jobs |= {job.resolve(): job for job in folders(path)}
        except RunFolderError as error:
            lost.append(str(error))
    return jobs, lost


@contextmanager
def workers(most: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """Processes that leave Ctrl-C to this one, which then waits only for what they have begun."""
    pool = ProcessPoolExecutor(most, initializer=signal.signal, initargs=(signal.SIGINT, signal.SIG_IGN))
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def read_or_reason(job: Path, rule: str, denominator: str) -> RunSummary | str:
    """The run in `job`, or a line that says why it cannot be read."""
    try:
        return read(job, rule, denominator)
    except RunFolderError as error:
        return f"LEFT OUT: {error}"
