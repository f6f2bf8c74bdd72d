"""A Slurm of one node in a temporary directory, with munge, configuration and state of its own."""

from __future__ import annotations

import contextlib
import os
import re
import secrets
import shutil
import signal
import socket
import subprocess
from pathlib import Path

import pytest
from patience import until

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo", "sdiag")
CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SlurmdParameters=config_overrides
SlurmdTimeout=30
KillWait=3
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def missing(why: str) -> None:
    """The test is skipped; in CI it fails."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"no Slurm: {why}")
    pytest.skip(f"no Slurm here: {why}")


class Slurm:
    """Starts everything; `end` leaves no process behind."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.host = folder, socket.gethostname().split(".")[0]
        absent = [name for name in PROGRAMS if not shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")]
        if absent:
            missing(f"{', '.join(absent)} not found (apt-get install slurm-wlm)")
        if os.geteuid():
            missing("its daemons are started by root only")
        for name in ("state", "spool"):
            (folder / name).mkdir()
        (folder / "munge.key").write_bytes(secrets.token_bytes(1024))
        (folder / "munge.key").chmod(0o400)
        self.configuration = folder / "slurm.conf"
        self.configuration.write_text(CONFIGURATION.format(folder=folder, host=self.host, ports=_free_ports(2)))
        self.environment = {
            **os.environ,
            "SLURM_CONF": str(self.configuration),
            "PATH": f"{os.environ['PATH']}:/usr/sbin:/sbin",
        }
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        self._start("munged", "--foreground", "--force", f"--socket={folder}/munge.socket", f"--key-file={folder}/munge.key",
                    f"--log-file={folder}/munge.log", f"--pid-file={folder}/munge.pid", f"--seed-file={folder}/munge.seed")  # fmt: skip
        self._start("slurmctld", "-D")
        self.start_node()
        try:
            until(lambda: "idle" in self.run("sinfo", "-h", "-o", "%T", check=False), "a node that is idle")
        except AssertionError as fault:
            logs = [path.read_text(errors="replace").splitlines()[-5:] for path in sorted(folder.glob("*.log"))]
            self.end()
            missing(f"it does not start ({fault}): {logs}")

    def _start(self, name: str, *words: str) -> None:
        with open(self.folder / f"{name}.said", "wb") as said:
            self.processes[name] = subprocess.Popen(
                [name, *words], env=self.environment, stdout=said, stderr=said, stdin=subprocess.DEVNULL, start_new_session=True
            )

    def start_node(self) -> None:
        """Switch the node on."""
        self._start("slurmd", "-D", "-N", self.host)

    def power_cut(self) -> None:
        """The node and everything on it vanish; the controller is told, rather than left to find out in minutes.

        It tells the dead node for ten or twenty seconds to end the job that was there.  No real node is back within them; one that is
        would end the same job, which has begun anew on it.
        """
        self.processes["slurmd"].kill()
        self.processes["slurmd"].wait()
        for pid in self.on_node():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        shutil.rmtree(self.folder / "spool")  # it has no disk
        (self.folder / "spool").mkdir()
        self.run("scontrol", "update", f"NodeName={self.host}", "State=DOWN", "Reason=power")
        until(lambda: re.search("Agent queue size: *0\nAgent count: *0\n", self.run("sdiag")), "it gives up telling the node")

    def on_node(self) -> list[int]:
        """Job steps, and what runs in them."""
        found = []
        for path in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                variables, command = (path / "environ").read_bytes().split(b"\0"), (path / "cmdline").read_bytes()
                ours = f"SLURM_CONF={self.configuration}".encode() in variables
                inside = any(variable.startswith(b"SLURM_JOB_ID=") for variable in variables)
                if ours and (inside or command.startswith(b"slurmstepd")):
                    found.append(int(path.name))
        return found

    def run(self, *words: str, check: bool = True) -> str:
        """What a command of Slurm prints."""
        done = subprocess.run(words, env=self.environment, capture_output=True, text=True, check=False)
        assert not check or done.returncode == 0, done.stderr
        return done.stdout

    def jobs(self) -> list[tuple[str, str, str]]:
        """Id, state, reason of all tasks, also those that ended."""
        rows = self.run("squeue", "-h", "-r", "-a", "-t", "all", "-o", "%i|%T|%r").splitlines()
        return [tuple(row.split("|")) for row in rows]  # type: ignore[misc]

    def state(self, task: str) -> str:
        """State of one task."""
        return next((state for number, state, _ in self.jobs() if number == task), "")

    def release(self, task: str) -> None:
        """Start now what Slurm queued again: it waits two minutes of its own."""
        self.run("scontrol", "update", f"JobId={task}", "StartTime=now")

    def end(self) -> None:
        """Leave nothing."""
        self.run("scancel", "--user", "root", check=False)
        for name in reversed(list(self.processes)):
            self.processes[name].terminate()
            try:
                self.processes[name].wait(timeout=20)
            except subprocess.TimeoutExpired:
                self.processes[name].kill()
                self.processes[name].wait()
        for pid in self.on_node():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


def _free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports
