"""Two discs meet: the plugin's trajectory against the independent reference integrator of the same law."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np

from workflow.archive.dumps import read_blocks
from workflow.deck.template import copy_template
from workflow.reference.cohesive import CohesiveLaw
from workflow.reference.discs import Discs
from workflow.reference.integrate import integrate
from workflow.runs.installation import engine, python_child

GAP, TIME = 0.01, 0.03
CASES = {
    "rebound, no cohesion": dict(speed=1.0, transverse=0.0, mu=0.0, f0=0.0),
    "oblique, with friction": dict(speed=1.0, transverse=0.5, mu=0.5, f0=0.0),
    "slow and cohesive: captured": dict(speed=0.5, transverse=0.0, mu=0.5, f0=1.0),
}


def plugin(step: float, **case: float) -> np.ndarray:
    """Final velocity of disc 2 by the plugin, (vx, vy, omega)."""
    steps = round(TIME / step)
    values = {**case, "step": step, "steps": steps, "trace_every": steps, "gap": GAP}
    words = [str(word) for pair in values.items() for word in pair]
    with tempfile.TemporaryDirectory() as folder:
        copy_template("two_discs.in", Path(folder))
        subprocess.run([*python_child(), "two_discs.in", *words], cwd=folder, env=engine().variables(), check=True)
        *_, last = read_blocks(Path(folder) / "grains.dump", "ATOMS")
    return last.table[1, [last.columns.index(name) for name in ("vx", "vy", "omegaz")]]


def reference(speed: float, transverse: float, mu: float, f0: float) -> np.ndarray:
    """The same by the reference integrator."""
    law = CohesiveLaw(kn=1e5, kt=1e5, zeta=0.8, mu=mu, f0=f0, d0=1e-3 if f0 else 0.0)
    discs = Discs(
        position=np.array([[0.0, 0.0], [1.0 + GAP, 0.0]]), velocity=np.array([[0.0, 0.0], [-speed, transverse]]),
        omega=np.zeros(2), diameter=np.ones(2),
    )  # fmt: skip
    end = integrate(law, discs, TIME).discs(-1)
    return np.array([*end.velocity[1], end.omega[1]])


for name, case in CASES.items():
    exact = reference(**case)
    print(f"{name}: vx {exact[0]:+.6f}  vy {exact[1]:+.6f}  omega {exact[2]:+.6f}")
    for step in (1e-5, 5e-6):
        error = np.abs(plugin(step, **case) - exact).max()
        print(f"    step {step:.0e}: largest error of the plugin {error:.1e}")
