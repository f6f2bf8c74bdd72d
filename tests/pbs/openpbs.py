"""An OpenPBS of one node on a machine of its own: Linux namespaces with a name, an address, processes and a /etc/hosts."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from patience import until

EXEC = Path(os.environ.get("PBS_EXEC", "/opt/pbs"))
HOST, ADDRESS = "pbs1", "10.1.2.3"  # OpenPBS wants an address that is not 127.0.0.1
CONFIGURATION = """PBS_EXEC={exec}
PBS_SERVER={host}
PBS_START_SERVER=1
PBS_START_SCHED=1
PBS_START_COMM=1
PBS_START_MOM=1
PBS_HOME={folder}/home
PBS_CORE_LIMIT=unlimited
PBS_SCP=/usr/bin/scp
PBS_DATA_SERVICE_USER=postgres
"""
MACHINE = """
hostname {host}
ip link set lo up
ip addr add {address}/32 dev lo
mount --bind {folder}/hosts /etc/hosts
mount -t tmpfs none /etc/profile.d    # an installed PBS has a file there, which gives jobs its commands
echo 'export PATH=$PATH:{exec}/bin' > /etc/profile.d/pbs.sh
{exec}/libexec/pbs_habitat
echo PBS_CONF_FILE={folder}/pbs.conf >> {folder}/home/pbs_environment    # jobs ask this server too
{exec}/libexec/pbs_init.d start
touch {folder}/started
exec sleep infinity
"""


class OpenPBS:
    """Starts everything; `end` leaves no process and no file behind."""

    def __init__(self) -> None:
        if not (EXEC / "sbin" / "pbs_server.bin").is_file():
            pytest.skip(f"no OpenPBS in {EXEC} (see docs/cluster.md; another place: PBS_EXEC)")
        if os.geteuid():
            pytest.skip("OpenPBS is started by root only")
        self.folder = Path(tempfile.mkdtemp(prefix="pbs-", dir="/run"))  # it refuses homes below folders that all may write
        self.folder.chmod(0o755)
        names = {"exec": EXEC, "host": HOST, "address": ADDRESS, "folder": self.folder}
        (self.folder / "hosts").write_text(f"127.0.0.1 localhost\n{ADDRESS} {HOST}\n")
        (self.folder / "pbs.conf").write_text(CONFIGURATION.format(**names))
        self.environment = {**os.environ, "PBS_CONF_FILE": f"{self.folder}/pbs.conf",
                            "PATH": f"{os.environ['PATH']}:{EXEC}/bin:/usr/sbin:/sbin"}  # fmt: skip
        with open(self.folder / "said", "wb") as said:
            self.machine = subprocess.Popen(
                ["unshare", "--net", "--uts", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc", "bash", "-c",
                 MACHINE.format(**names)],
                env=self.environment, stdout=said, stderr=said, stdin=subprocess.DEVNULL, start_new_session=True,
            )  # fmt: skip
        try:
            until(lambda: (self.folder / "started").is_file() or self.machine.poll() is not None, "PBS is started")
            self.init = int(Path(f"/proc/{self.machine.pid}/task/{self.machine.pid}/children").read_text().split()[0])
            until(lambda: "state = free" in self.run("pbsnodes", "-a", check=False), "a node that is free")
        except (AssertionError, OSError, IndexError) as fault:
            words = (self.folder / "said").read_text(errors="replace")[-1500:]
            self.end()
            pytest.skip(f"OpenPBS does not start ({fault}): {words}")
        for setting in ("flatuid=true", "job_history_enable=true", "acl_roots=root"):
            self.run("qmgr", "-c", f"set server {setting}")

    def run(self, *words: str, cwd: Path | None = None, check: bool = True) -> str:
        """What a command prints on that machine."""
        inside = f"cd {shlex.quote(str(cwd or '/'))} && exec {shlex.join(words)}"
        done = subprocess.run(["nsenter", "-t", str(self.init), "-n", "-u", "-m", "-p", "bash", "-c", inside],
                              env=self.environment, capture_output=True, text=True, check=False)  # fmt: skip
        assert not check or done.returncode == 0, (words, done.stderr)
        return done.stdout if check else done.stdout + done.stderr

    def state(self, job: str) -> str:
        """State of a job: Q, R, F ..."""
        match = re.search(r"job_state = (\w)", self.run("qstat", "-x", "-f", job, check=False))
        return match[1] if match else ""

    def end(self) -> None:
        """Leave nothing."""
        self.machine.kill()
        self.machine.wait()
        shutil.rmtree(self.folder, ignore_errors=True)
