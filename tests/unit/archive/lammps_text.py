"""Random frames and the LAMMPS text files that describe them, written as `dump custom` and `dump local` write them."""

import numpy as np

from workflow.data.frame import Frame, Interactions

NUMBERED = tuple(f"c_pairs[{k}]" for k in range(1, 16))  # what decks of version 0.2 wrote
GRAINS = "id diameter mass x y ix iy vx vy omegaz fx fy tqz"


def random_frame(step=1000, grains=12, pairs=20, stage="0", seed=1, first_id=1):
    rng = np.random.default_rng([seed, step])
    size = np.random.default_rng(seed).uniform(0.5, 1.0, 1000)[:grains]
    i, j = np.triu_indices(grains, 1)
    rows = np.sort(rng.choice(len(i), pairs, replace=False))
    columns = rng.normal(size=(8, pairs))
    contacts = Interactions(i[rows], j[rows], rng.normal(size=(pairs, 2)), *columns, *(rng.random((2, pairs)) > 0.5))
    return Frame(step, step * 1e-4, stage, np.array([-1.0, 0.5]), np.array([7.0, 9.25]),
                 np.arange(first_id, first_id + grains), size, size**2, rng.normal(size=(grains, 2)),
                 rng.normal(size=(grains, 2)), rng.normal(size=grains), rng.normal(size=(grains, 2)),
                 rng.normal(size=grains), contacts)  # fmt: skip


def _head(frame, kind, rows):
    lo, hi = frame.origin, frame.origin + frame.cell
    return (
        f"ITEM: TIME\n{frame.time:.16g}\nITEM: TIMESTEP\n{frame.step}\nITEM: NUMBER OF {kind}\n{rows}\n"
        f"ITEM: BOX BOUNDS pp pp pp\n{lo[0]:.16e} {hi[0]:.16e}\n{lo[1]:.16e} {hi[1]:.16e}\n-0.5 0.5\n"
    )


def grains_text(frame, order=None, columns=GRAINS):
    """One snapshot; rows in ``order`` (LAMMPS does not sort), columns as named."""
    x, v, f = frame.position, frame.velocity, frame.force
    data = {"id": frame.ids, "diameter": frame.diameter, "mass": frame.mass, "x": x[:, 0], "y": x[:, 1],
            "ix": np.zeros(frame.grains, int), "iy": np.full(frame.grains, -3), "vx": v[:, 0], "vy": v[:, 1],
            "omegaz": frame.omega, "radius": frame.diameter / 2, "fx": f[:, 0], "fy": f[:, 1], "tqz": frame.torque}  # fmt: skip
    rows = range(frame.grains) if order is None else order
    lines = [" ".join(f"{data[c][k]:.17g}" for c in columns.split()) + " \n" for k in rows]
    return _head(frame, "ATOMS", frame.grains) + f"ITEM: ATOMS {columns} \n" + "".join(lines)


def contacts_text(frame, swap=(), order=None, idle=0, names=NUMBERED, columns=range(15)):
    """One snapshot; pairs in ``swap`` written as (j, i), the other view; ``idle`` rows of state 0 in front; ``names`` of the
    columns, of which those in ``columns`` are written, in that order."""
    c = frame.interactions
    lines = ["3 2 0 1.5 0.5 0.9 0 0 0 0 0 0 0 0 0\n"] * idle
    for k in range(len(c)) if order is None else order:
        s = -1 if k in swap else 1
        pair = (frame.ids[c.i[k]], frame.ids[c.j[k]])[::s]
        state = 2 if c.gap[k] < 0 else 1
        numbers = (s * c.branch[k, 0], s * c.branch[k, 1], c.gap[k], c.elastic[k], c.viscous[k], c.attraction[k],
                   c.tangential[k], s * c.moment[k], c.xi_t[k], s * c.xi_r[k])  # fmt: skip
        line = " ".join([*map(str, pair), str(state), *(f"{n:.17g}" for n in numbers)])
        lines.append(f"{line} {int(c.sliding[k])} {int(c.rolling[k])} \n")
    chosen = [" ".join(line.split()[k] for k in columns) + " \n" for line in lines]
    return _head(frame, "ENTRIES", len(lines)) + f"ITEM: ENTRIES {' '.join(names[k] for k in columns)} \n" + "".join(chosen)
