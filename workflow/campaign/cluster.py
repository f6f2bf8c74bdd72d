"""Clusters as data: what a job asks of Slurm, PBS or LSF, read from a profile and checked field by field.

A profile is a table in ``~/.config/workflow/clusters.toml`` (``$XDG_CONFIG_HOME``), named by ``--profile NAME``, or a TOML file
of its own, ``--profile FILE.toml``:

    [hunter]
    scheduler = "slurm"
    partition = "compute"
    account = "phys-0042"
    time = "24:00:00"
    modules = ["gcc/12.2", "lammps/22Jul2025"]
    launcher = "srun -n {ranks}"
    directives = ["--mem-per-cpu=2G", "--constraint=rome"]

Fields go into scheduler directives, which no shell reads, as single words of a few characters, and into the script as quoted
words: none can add a directive, an option or a command.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from workflow.errors import InputError
from workflow.scene.parameter import unknown_name
from workflow.scene.registry import read_toml

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.@+-]*")
_MODULE = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+/-]*")
# one option with at most one value: a letter or a long name, then = or one blank, then a word without quotes, $, ; and the like
_DIRECTIVE = re.compile(r"-(-[A-Za-z][A-Za-z0-9-]*|[A-Za-z])([= ][A-Za-z0-9_.,:/@%+=*\[\]-]+)?")
# what a profile may add, in full names: resources and priorities, nothing that names a file, a shell, a folder or a variable
_ALLOWED = {
    "slurm": {"begin", "clusters", "M", "comment", "constraint", "C", "contiguous", "cores-per-socket", "cpu-freq", "exclude",
              "x", "exclusive", "gpus", "G", "gres", "hint", "licenses", "L", "mail-type", "mail-user", "mem", "mem-bind",
              "mem-per-cpu", "mincpus", "nice", "nodelist", "w", "ntasks-per-core", "ntasks-per-node", "ntasks-per-socket",
              "priority", "qos", "q", "reservation", "sockets-per-node", "switches", "threads-per-core", "tmp"},
    "pbs": {"a", "l", "m", "M", "P", "p"},
    "lsf": {"B", "G", "M", "N", "R", "U", "b", "m", "u", "x"},
}  # fmt: skip


@dataclass(frozen=True)
class Cluster:
    """One scheduler: its directive, how a script is submitted, what it calls the folder of submission."""

    directive: str
    submit: str
    folder: str
    launcher: str


CLUSTERS = {
    "slurm": Cluster("#SBATCH", "sbatch job.sh", "SLURM_SUBMIT_DIR", "srun -n {ranks}"),
    "pbs": Cluster("#PBS", "qsub job.sh", "PBS_O_WORKDIR", "mpiexec -n {ranks}"),
    "lsf": Cluster("#BSUB", "bsub < job.sh", "LS_SUBCWD", "mpiexec -n {ranks}"),
}


@dataclass(frozen=True)
class Profile:
    """What a job asks for.  ``time`` and ``margin`` in seconds: its limit, and how long before it the deck is stopped.

    ``launcher``: command that starts the ranks, with ``{ranks}`` for their number; "" for the scheduler's own, which one rank
    does without.  ``lmp``, ``lammps_include``, ``compiler``: for the plugin's build.sh; ``cores_per_node``: PBS alone needs it.
    ``points_at_once``: points that a task of `wf sweep` computes side by side; ``most_tasks``: tasks in one array at most.
    Raises InputError for any field that is not allowed.
    """

    scheduler: str = "slurm"
    account: str = ""
    partition: str = ""
    time: int = 86_400
    margin: int = 0
    ranks: int = 1
    cores_per_node: int = 0
    modules: Sequence[str] = ()
    directives: Sequence[str] = ()
    launcher: str = ""
    lmp: str = "lmp"
    lammps_include: str = ""
    compiler: str = ""
    points_at_once: int = 1
    most_tasks: int = 1000

    def __post_init__(self) -> None:
        if not isinstance(self.scheduler, str) or self.scheduler not in CLUSTERS:
            raise InputError(f"scheduler = '{self.scheduler}' is not allowed: it must be one of {', '.join(CLUSTERS)}")
        object.__setattr__(self, "time", seconds("time", self.time))
        object.__setattr__(self, "margin", seconds("margin", self.margin) or min(max(self.time // 20, 30), 600))
        if not 0 < self.margin < self.time:
            raise InputError(f"margin = {self.margin} s is not allowed: it must be above 0 and below the limit, {self.time} s")
        for name, low in (("ranks", 1), ("cores_per_node", 0), ("points_at_once", 1), ("most_tasks", 1)):
            value = getattr(self, name)
            if type(value) is not int or not low <= value <= 10_000_000:
                raise InputError(f"{name} = {value!r} is not allowed: it must be a whole number not below {low}")
        for name in ("account", "partition"):
            _matching(name, getattr(self, name), _NAME, "letters, digits and _ . @ + -", empty=True)
        for name, pattern, words in (
            ("modules", _MODULE, "letters, digits and _ . + / -"),
            ("directives", _DIRECTIVE, "one option with at most one value, such as '--mem=4G', without quotes and $ ; & | < >"),
        ):
            values = getattr(self, name)
            if isinstance(values, str) or not isinstance(values, Sequence):
                raise InputError(f"{name} = {values!r} is not allowed: it must be a list of texts")
            for value in values:
                _matching(name, value, pattern, words)
        for directive in self.directives:
            dashes, name = re.match("(-+)([^= ]*)", directive).groups()  # type: ignore[union-attr]
            if name not in _ALLOWED[self.scheduler] or (len(dashes) == 1) != (len(name) == 1):
                known = ", ".join(sorted(("-" if len(word) == 1 else "--") + word for word in _ALLOWED[self.scheduler]))
                raise InputError(f"directives: '{directive}' is not allowed; a profile may add, by their full names: {known}")
        for name in ("launcher", "lmp", "lammps_include", "compiler"):
            value = getattr(self, name)
            if not isinstance(value, str) or not value.isprintable():
                raise InputError(f"{name} = {value!r} is not allowed: it must be a text on one line")
        if not self.lmp:
            raise InputError("lmp = '' is not allowed: name the LAMMPS program")
        self._launcher()
        if self.cores_per_node:
            self._nodes()

    def _launcher(self) -> list[str]:
        try:
            return shlex.split(self.launcher)
        except ValueError as fault:
            raise InputError(f"launcher = {self.launcher!r} is not allowed: {fault}; write it as in a shell") from fault

    @property
    def cluster(self) -> Cluster:
        """The scheduler of the job."""
        return CLUSTERS[self.scheduler]

    @property
    def launch(self) -> list[str]:
        """Words that start the ranks."""
        words = self._launcher() or (shlex.split(self.cluster.launcher) if self.ranks > 1 else [])
        return [word.replace("{ranks}", str(self.ranks)) for word in words]

    def head(self, name: str, output: str, *more: str) -> list[str]:
        """Directives of a job: ``name`` (letters, digits, -), file of its ``output``, what it asks for, and ``more``."""
        mark, limit = self.cluster.directive, f"{self.time // 3600:02d}:{self.time // 60 % 60:02d}"
        if self.scheduler == "slurm":
            own = [f"--job-name={name}", f"--output={output}", "--open-mode=append", "--requeue",
                   f"--time={limit}:{self.time % 60:02d}"]  # fmt: skip
            own += [f"--account={self.account}"] if self.account else []
            own += [f"--partition={self.partition}"] if self.partition else []
        elif self.scheduler == "pbs":
            own = [f"-N {name}", "-j oe", "-r y", f"-l {self._chunks()}", f"-l walltime={limit}:{self.time % 60:02d}"]
            own += [f"-A {self.account}"] if self.account else []
            own += [f"-q {self.partition}"] if self.partition else []
        else:
            minutes = -(-self.time // 60)
            own = [f"-J {name}", f"-o {output}", "-r", f"-n {self.ranks}", f"-W {minutes // 60:02d}:{minutes % 60:02d}"]
            own += [f"-P {self.account}"] if self.account else []
            own += [f"-q {self.partition}"] if self.partition else []
        return [f"{mark} {word}" for word in (*own, *more, *self.directives)]

    def loading(self) -> list[str]:
        """Lines of the script that load the modules; a batch shell may not know the command yet."""
        if not self.modules:
            return []
        return [
            "for file in /etc/profile.d/{modules,lmod,z00_lmod}.sh; do",
            '  type module > /dev/null 2>&1 || { [ -r "$file" ] && . "$file"; }',
            "done",
            *(f'module load {name} || {{ echo "module {name} does not load" >&2; exit 1; }}' for name in self.modules),
            "",
        ]

    def _nodes(self) -> int:
        """Number of nodes that the ranks fill evenly."""
        nodes = -(-self.ranks // self.cores_per_node)
        if self.ranks % nodes:
            raise InputError(
                f"ranks = {self.ranks} is not allowed: {nodes} nodes of {self.cores_per_node} must have equal shares"
            )
        return nodes

    def _chunks(self) -> str:
        """PBS: whole nodes where their size is known, single cores wherever they are else."""
        if not self.cores_per_node:
            return f"select={self.ranks}:ncpus=1:mpiprocs=1"
        nodes = self._nodes()
        return f"select={nodes}:ncpus={self.ranks // nodes}:mpiprocs={self.ranks // nodes}"


def profile_of(source: str | None, **given: Any) -> Profile:
    """The profile ``source`` (a name in the user's file, or a TOML file; None: none), with what is ``given`` on top."""
    values: Mapping[str, Any] = {}
    where = "options"
    if source is not None:
        path = Path(source) if source.endswith(".toml") else profiles_file()
        tables = read_toml(path, "profile file", "docs/cluster.md")
        where = f"'{path}'" if source.endswith(".toml") else f"profile '{source}' in '{path}'"
        if not source.endswith(".toml"):
            if not isinstance(tables.get(source), dict):
                raise InputError(f"'{path}' has no profile '{source}'; there are: {', '.join(tables) or 'none'}")
            tables = tables[source]
        values = tables
    known = {item.name for item in fields(Profile)}
    for name in values:
        if name not in known:
            raise InputError(f"{where}: {unknown_name(name, sorted(known), 'field')}")
    try:
        return Profile(**{**values, **{name: value for name, value in given.items() if value is not None}})
    except InputError as fault:
        raise InputError(f"{where}: {fault}" if values else str(fault)) from fault


def profiles_file() -> Path:
    """The user's profiles."""
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config") / "workflow" / "clusters.toml"


def seconds(name: str, value: Any) -> int:
    """A duration: seconds, or text HH:MM:SS or D-HH:MM:SS."""
    if type(value) is int and 0 <= value <= 10**8:
        return value
    match = re.fullmatch(r"(?:(\d{1,3})-)?(\d{1,4}):([0-5]\d):([0-5]\d)", value) if isinstance(value, str) else None
    if not match:
        raise InputError(f"{name} = {value!r} is not allowed: write HH:MM:SS or D-HH:MM:SS, for example 24:00:00")
    days, hours, minutes, rest = (int(part or 0) for part in match.groups())
    return ((24 * days + hours) * 60 + minutes) * 60 + rest


def _matching(name: str, value: Any, pattern: re.Pattern[str], words: str, *, empty: bool = False) -> None:
    if not isinstance(value, str) or not (pattern.fullmatch(value) or (empty and not value)):
        raise InputError(f"{name}: {value!r} is not allowed: it must be {words}")
