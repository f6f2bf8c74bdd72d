"""Method 1 without cohesion for YADE: the twin of crosscheck_liggghts.in; or, without stress, any discs in a fixed cell.

    yade -n -x -j1 crosscheck_yade.py data=grains.data stress=1 steps=100000 relax_steps=20000     (NAME=VALUE, defaults below)

Spheres kept in a plane, with mass and moment of inertia of discs; K_N, K_T, damping 2 zeta sqrt(K_N m*) of each pair, and the
cell of G07 eq. 3 (homoDeform 3: m dv/dt = F for the velocity without the affine motion, which contacts see whole).  Not equal
to ours: the Coulomb limit is mu |N| with the viscous part of N; lever arms are R - overlap/2; the velocity in N and in the
tangential spring is that of half a step before; the last steps are calmed by YADE's own damping of accelerations.
"""

# ruff: noqa: F821  (names that yade puts into a script)
import math
import sys
from pathlib import Path

given = {"data": "grains.data", "kn": 1e5, "kt": 1e5, "zeta": 0.8, "mu": 0.5, "stress": 0.0, "cell_mass": 0.3, "damping": 0.2,
         "step": 1e-4, "skin": 0.1, "steps": 10000, "relax_steps": 0, "rows": 1000}  # fmt: skip
for word in sys.argv[1:]:
    name, text = word.split("=", 1)
    given[name] = type(given[name])(text)

lines = Path(given["data"]).read_text().split("\n")
count = int(next(line for line in lines if line.endswith("atoms")).split()[0])
width, height = (float(next(line for line in lines if line.endswith(end)).split()[1]) for end in ("xhi", "yhi"))
first = next(k for k, line in enumerate(lines) if line.startswith("Atoms")) + 2
moving = next((k + 2 for k, line in enumerate(lines) if line.startswith("Velocities")), None)
depth = 3.0  # of the cell: more than two diameters, for the collider

material = FrictViscoMat(frictionAngle=math.atan(given["mu"]), betan=given["zeta"], density=1.0, young=1.0, poisson=1.0)
O.materials.append(material)
O.periodic = True
O.cell.setBox(width, height, depth)
O.cell.homoDeform = 3
for k in range(count):
    d, x, y = (float(lines[first + k].split()[c]) for c in (2, 4, 5))
    body = utils.sphere((x, y, depth / 2), d / 2, material=material)
    body.state.mass, body.state.inertia = d * d, (d**4 / 8,) * 3
    if moving is not None:
        u, v, *_, spin = map(float, lines[moving + k].split()[1:])
        body.state.vel, body.state.angVel = (u, v, 0), (0, 0, spin)
    body.state.blockedDOFs = "zXY"
    O.bodies.append(body)

inertia = [given["cell_mass"] * sum(body.state.mass for body in O.bodies) / length for length in (width, height)]
rate = [0.0, 0.0]  # of the lengths of the start, compression positive
rows = ["# time length_x length_y stress_x stress_y\n"]


def cell():
    """One step of the cell: M eps'' = stress - sigma, L = L0 (1 - eps)."""
    size = O.cell.size
    pairs, motion = getStress(size[0] * size[1]), getTotalDynamicStress() * depth
    sigma = [motion[a][a] - pairs[a][a] for a in (0, 1)]
    for a in (0, 1):
        rate[a] += O.dt * (given["stress"] - sigma[a]) / inertia[a]
    O.cell.velGrad = Matrix3(-rate[0] * width / size[0], 0, 0, 0, -rate[1] * height / size[1], 0, 0, 0, 0)
    if O.iter % given["rows"] == 0:
        rows.append(f"{O.iter * O.dt!r} {size[0]!r} {size[1]!r} {sigma[0]!r} {sigma[1]!r}\n")


newton = NewtonIntegrator(damping=0.0)
stiffness = {"kn": MatchMaker(algo="val", val=given["kn"]), "kRatio": MatchMaker(algo="val", val=given["kt"] / given["kn"])}
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist=given["skin"] / 2),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom()],
        [Ip2_FrictViscoMat_FrictViscoMat_FrictViscoPhys(**stiffness)],
        [Law2_ScGeom_FrictViscoPhys_CundallStrackVisco()],
    ),
    *([PyRunner(command="cell()", iterPeriod=1)] if given["stress"] else []),
    newton,
]
O.dt = given["step"]
O.run(given["steps"], True)
if given["relax_steps"]:
    newton.damping = given["damping"]
    O.run(given["relax_steps"], True)
Path("series.txt").write_text("".join(rows))

size = O.cell.size
with open("grains.dump", "w") as file:
    file.write(f"ITEM: TIMESTEP\n{O.iter}\nITEM: NUMBER OF ATOMS\n{count}\nITEM: BOX BOUNDS pp pp pp\n")
    file.write(f"0 {size[0]!r}\n0 {size[1]!r}\n-0.5 0.5\nITEM: ATOMS id diameter mass x y ix iy vx vy omegaz\n")
    for k, body in enumerate(O.bodies, 1):
        state = body.state
        u = state.vel - O.cell.velGrad * state.pos
        values = (2 * body.shape.radius, state.mass, state.pos[0], state.pos[1], 0, 0, u[0], u[1], state.angVel[2])
        file.write(" ".join(map(repr, (k, *values))) + "\n")
print(f"RESULT lx {size[0]!r} ly {size[1]!r}")
