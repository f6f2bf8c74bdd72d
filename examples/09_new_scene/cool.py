"""Run a scene from a file of one's own and compare it with Haff's law E(t) = E0/(1 + t/tau)^2."""

import math
import os
from pathlib import Path

import numpy as np

import workflow as wf

GRAINS = int(os.environ.get("WORKFLOW_EXAMPLE_GRAINS", "1000"))
PHI, ZETA, SPEED = 0.2, 0.05, 1.0
SCENE = Path(__file__).resolve().parent / "scene" / "free_cooling.py"

os.environ["WORKFLOW_SCENES"] = str(SCENE)
gas = wf.run("free_cooling", n=GRAINS, zeta=ZETA, phi0=PHI, out="gas")
time, kinetic = gas.series["time"], gas.series["kinetic"]

# restitution of the damped spring; Enskog's collision frequency of discs of diameter and mass 1 at temperature v0^2/2
restitution = math.exp(-math.pi * ZETA / math.sqrt(1.0 - ZETA**2))
crowding = (1.0 - 7.0 * PHI / 16.0) / (1.0 - PHI) ** 2
frequency = 2.0 * math.sqrt(math.pi * SPEED**2 / 2.0) * (4.0 * PHI / math.pi) * crowding
rate = (1.0 - restitution**2) * frequency / 4.0
measured = (np.sqrt(kinetic[0] / kinetic) - 1.0)[1:] / time[1:]
collisions = GRAINS / 2 * math.log(1.0 + rate * time[-1]) * frequency / rate
print(f"1/tau: kinetic theory {rate:.4f}, measured {measured[-1]:.4f} over {collisions:.0f} collisions")
# what a collision loses scatters as much as it is; kinetic theory itself (molecular chaos) is good to a few percent
assert abs(measured[-1] / rate - 1.0) < 0.05 + 3.0 / math.sqrt(collisions)
