"""Peak memory: the process's where this run reached it, and not that of a run before it in the same process."""

import mmap
from pathlib import Path

from curionav_cli.execution import peak_memory
from curionav_cli.execution.peak_memory import PeakMemory, resident


def test_a_run_after_a_larger_one_in_a_process_has_its_own_peak(tmp_path: Path, monkeypatch) -> None:
    status = tmp_path / "status"
    monkeypatch.setattr(peak_memory, "STATUS", status)

    def now(megabytes: int, most: int) -> None:
        status.write_text(f"Name:\tpython\nVmHWM:\t{most * 1000:8d} kB\nVmRSS:\t{megabytes * 1000:8d} kB\n")

    now(20, 90)
    memory = PeakMemory()
    now(50, 90)
    assert memory.bytes() == 50 * 1024_000, "the 90 are of what ran before"
    now(60, 95)
    assert memory.bytes() == 95 * 1024_000


def test_both_ways_of_asking_the_system_count_bytes(monkeypatch) -> None:
    held = mmap.mmap(-1, 64 << 20)
    held.write(b"1" * len(held))
    now, most = resident()
    assert len(held) < now <= most + (1 << 20) < 2 ** 40
    monkeypatch.setattr(peak_memory, "STATUS", Path("/nowhere"))  # as where there is no /proc
    assert resident().now == resident().most > len(held)
