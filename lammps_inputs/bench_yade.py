"""Speed of YADE on the state of bench.in: spheres kept in a plane, linear springs, one dashpot constant for all pairs.

    yade -n -x -j1 bench_yade.py DATA KN ZETA MU STEP WARM STEPS

Prints a line in LAMMPS's words, "Loop time of ...".
"""

# ruff: noqa: F821  (names that yade puts into a script)
import math
import sys
import time
from pathlib import Path

data, kn, zeta, mu, step, warm, steps = sys.argv[1], *map(float, sys.argv[2:6]), *map(int, sys.argv[6:8])
lines = Path(data).read_text().split("\n")
count = int(next(line for line in lines if line.endswith("atoms")).split()[0])
width, height = (float(next(line for line in lines if line.endswith(end)).split()[1]) for end in ("xhi", "yhi"))
first = next(k for k, line in enumerate(lines) if line.startswith("Atoms")) + 2
moving = next(k for k, line in enumerate(lines) if line.startswith("Velocities")) + 2

dashpot = 2.0 * zeta * math.sqrt(kn * 0.28)  # at the mean reduced mass
# a contact has the springs and dashpots of its two materials in series: half of each
O.materials.append(ViscElMat(kn=2 * kn, ks=2 * kn, cn=2 * dashpot, cs=0.0, frictionAngle=math.atan(mu), density=1))
O.periodic = True
O.cell.setBox(width, height, 3.0)
for atom, motion in zip(lines[first : first + count], lines[moving : moving + count], strict=True):
    d, x, y = (float(atom.split()[k]) for k in (2, 4, 5))
    u, v = map(float, motion.split()[1:3])
    body = utils.sphere((x, y, 1.5), d / 2)
    body.state.mass, body.state.inertia, body.state.vel = d * d, (d**4 / 8,) * 3, (u, v, 0)
    body.state.blockedDOFs = "zXY"
    O.bodies.append(body)
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist=-0.2),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]),
    NewtonIntegrator(damping=0.0),
]
O.dt = step
O.run(max(1, warm), True)
begun = time.perf_counter()
O.run(steps, True)
print(f"Loop time of {time.perf_counter() - begun:.6f} on 1 procs for {steps} steps with {count} atoms", flush=True)
