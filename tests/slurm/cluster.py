"""A Slurm of our own on this machine: two processors, partition `main`, and `urgent`, which takes them from it."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

NEEDED = ("munged", "slurmctld", "slurmd", "sbatch", "runuser")
SETTINGS = """ClusterName=here
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket,cred_expire=20
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
KillWait=5
SchedulerParameters=sched_min_interval=100000,sched_interval=2,bf_interval=1
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=8000
PartitionName=main Nodes=ALL Default=YES PriorityTier=1
PartitionName=urgent Nodes=ALL PriorityTier=2
"""


def available() -> bool:
    """Whether the programs are here and may be started: apt-get install slurmctld slurmd slurm-client munge."""
    return os.geteuid() == 0 and all(shutil.which(program) for program in NEEDED)


@contextmanager
def cluster() -> Iterator[dict[str, str]]:
    """Its files in a folder that the user munge can enter; the environment in which sbatch finds it."""
    with tempfile.TemporaryDirectory(prefix="slurm") as name:
        Path(name).chmod(0o755)
        with daemons(Path(name)) as environment:
            yield environment


@contextmanager
def daemons(folder: Path) -> Iterator[dict[str, str]]:
    host = platform.node()
    for name in ("state", "spool", "munge"):
        (folder / name).mkdir()
    (folder / "munge" / "key").write_bytes(os.urandom(1024))
    (folder / "munge" / "key").chmod(0o400)
    for path in (folder / "munge", folder / "munge" / "key"):
        shutil.chown(path, "munge", "munge")
    (folder / "slurm.conf").write_text(SETTINGS.format(host=host, folder=folder))
    environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf")}
    within = folder / "munge"
    munged = ["runuser", "-u", "munge", "--", shutil.which("munged"), "--foreground", "--force",
              f"--key-file={within}/key", f"--socket={within}/socket", f"--pid-file={within}/pid",
              f"--log-file={within}/log", f"--seed-file={within}/seed"]
    ready = (
        (munged, (within / "socket").exists),
        (["slurmctld", "-D"], lambda: " UP" in answer(["scontrol", "ping"], environment)),
        (["slurmd", "-D"], lambda: "idle" in answer(["sinfo", "-h", "-o", "%t"], environment)))
    with ExitStack() as stack:
        for command, is_ready in ready:
            stack.enter_context(running(command, environment, folder / "daemons.log"))
            until(is_ready, f"{command[0]} is not ready: {folder / 'daemons.log'}")
        try:
            yield environment
        finally:
            subprocess.run(["scancel", "--user", "root"], env=environment, capture_output=True)  # of a test that failed
            until(lambda: not answer(["squeue", "-h"], environment).strip(), "jobs were not stopped")


@contextmanager
def running(command: list[str], environment: dict[str, str], log: Path) -> Iterator[None]:
    """A daemon, stopped by its own process id."""
    with open(log, "ab") as file, subprocess.Popen(command, env=environment, stdout=file, stderr=file) as daemon:
        try:
            yield
        finally:
            daemon.terminate()


def answer(command: list[str], environment: dict[str, str]) -> str:
    return subprocess.run(command, env=environment, capture_output=True, text=True).stdout


def until(true, otherwise: str, seconds: float = 300.0) -> None:
    """Waits for it. Raises TimeoutError with the words of `otherwise`."""
    end = time.monotonic() + seconds
    while not true():
        if time.monotonic() > end:
            raise TimeoutError(otherwise)
        time.sleep(0.2)
