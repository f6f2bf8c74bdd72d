"""A small packing with its direct numbers, written in the ways in which other programs write theirs.

Nothing of the package is used here: the numbers come from the definitions, the files from their manuals.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

MU, STIFFNESS = 0.3, 1000.0
ORIGIN = np.array([-1.5, 2.25])
PACK: dict[str, Callable[[bytes], bytes]] = {"": bytes, "gz": gzip.compress, "bz2": bz2.compress, "xz": lzma.compress}
JUNK = {"element": "Si", "type": "1", "c_q[1]": "-nan", "v_ratio": "inf", "name": "A-b_c", "state": "0", "ix": "3", "proc": "7"}


@dataclass(frozen=True)
class Packing:
    """Discs on a shaken triangular lattice, periodic, with the forces of their overlaps; pairs i < j, each once.

    ``normal`` along the unit vector from i to j, repulsion positive, ``tangential`` along that turned by 90 degrees.
    """

    cell: np.ndarray
    ids: np.ndarray
    position: np.ndarray
    radius: np.ndarray
    mass: np.ndarray
    velocity: np.ndarray
    omega: np.ndarray
    i: np.ndarray
    j: np.ndarray
    branch: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    slides: np.ndarray

    @property
    def force(self) -> np.ndarray:
        """Of i on j, (M, 2)."""
        n = self.branch / np.hypot(*self.branch.T)[:, None]
        return self.normal[:, None] * n + self.tangential[:, None] * np.column_stack((-n[:, 1], n[:, 0]))

    @property
    def net(self) -> np.ndarray:
        """Sum of the forces on each grain, (N, 2)."""
        total = np.zeros_like(self.position)
        np.add.at(total, self.j, self.force)
        np.add.at(total, self.i, -self.force)
        return total


def packing(seed: int, across: int = 6) -> Packing:
    """``across`` x ``across`` discs; every fifth contact slides."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(across), np.arange(across))
    cell = np.array([across, across * np.sqrt(0.75)])
    place = np.column_stack(((x + 0.5 * (y % 2)).ravel(), (y * np.sqrt(0.75)).ravel())) + rng.uniform(
        -0.03, 0.03, (across**2, 2)
    )
    count = across**2
    radius = rng.uniform(0.47, 0.53, count)
    first, second = np.triu_indices(count, 1)
    branch = place[second] - place[first]
    branch -= cell * np.round(branch / cell)
    gap = np.hypot(*branch.T) - radius[first] - radius[second]
    kept = gap < 0
    first, second, branch, gap = first[kept], second[kept], branch[kept], gap[kept]
    normal = -STIFFNESS * gap
    slides = np.arange(len(gap)) % 5 == 0
    tangential = MU * normal * np.where(slides, rng.choice([-1.0, 1.0], len(gap)), rng.uniform(-0.9, 0.9, len(gap)))
    ids = np.sort(rng.choice(np.arange(1, 4 * count), count, replace=False))
    return Packing(cell, ids, place % cell + ORIGIN, radius, rng.uniform(1.0, 3.0, count), rng.normal(size=(count, 2)),
                   rng.normal(size=count), first, second, branch, normal, tangential, slides)  # fmt: skip


def direct(p: Packing) -> dict[str, float]:
    """What `wf measure --json` must say, from the definitions; names are paths in its output."""
    area, count = float(p.cell.prod()), len(p.ids)
    pairs = p.force.T @ p.branch / area
    kinetic = (p.mass[:, None] * p.velocity).T @ p.velocity / area
    energy = 0.5 * p.mass * (p.velocity**2).sum(axis=1) + 0.25 * p.mass * (p.radius * p.omega) ** 2
    total = pairs + kinetic
    return {
        "grains": count, "interactions.contacts": len(p.i), "interactions.distant": 0, "coordination": 2 * len(p.i) / count,
        "solid_fraction": float(np.pi * (p.radius**2).sum() / area),
        "stress.pressure": float(np.trace(total)) / 2, "stress.xx": float(total[0, 0]), "stress.yy": float(total[1, 1]),
        "stress.contacts.pressure": float(np.trace(pairs)) / 2, "stress.contacts.xx": float(pairs[0, 0]),
        "stress.kinetic.pressure": float(np.trace(kinetic)) / 2, "kinetic_energy.raw": float(energy.mean()),
        "rattler_fraction": rattlers(p), "sliding_contacts": int(p.slides.sum()),
        "unbalanced_force.force": float(np.hypot(*p.net.T).max()) / float(np.abs(p.normal).mean()),
        "unbalanced_force.engine_force_difference": 0.0,
    }  # fmt: skip


def rattlers(p: Packing) -> float:
    """Share of the grains outside the network in which each has two contacts and more that bear 1e-4 of the mean force."""
    bears = np.hypot(p.normal, p.tangential) > 1e-4 * np.abs(p.normal).mean()
    links = set(zip(p.i[bears].tolist(), p.j[bears].tolist(), strict=True))
    while True:
        ends = [end for link in links for end in link]
        lone = {end for end in ends if ends.count(end) < 2}
        if not lone:
            return 1.0 - len(set(ends)) / len(p.ids)
        links = {link for link in links if not lone & set(link)}


@dataclass
class Way:
    """How files are written; the defaults are those of a LAMMPS dump with named columns."""

    forms: tuple[str, str] = ("", "")  # of x and y
    size: str = "radius"
    contact: str = "vector"  # vector: fx fy; parts: fx fy and tx ty; scalar: normal tangential; own: three parts
    branch: bool = False
    gap: str = ""
    flags: bool = False
    order: int = 0  # seed of the order of columns, rows and ends
    junk: tuple[str, ...] = ()
    twice: str = ""  # both: every pair from both grains; some: a few rows again
    header: tuple[str, ...] = ()  # of units, time, tilt, old, label
    packed: str = ""
    digits: int = 17
    dropped: tuple[str, ...] = ()
    renamed: dict[str, str] = field(default_factory=dict)
    step: int = 700


def grains_text(p: Packing, way: Way) -> str:
    """One snapshot of ``dump custom``."""
    rng = np.random.default_rng(way.order)
    columns: dict[str, Any] = {"id": p.ids, "mass": p.mass, "vx": p.velocity[:, 0], "vy": p.velocity[:, 1], "omegaz": p.omega,
                               "fx": p.net[:, 0], "fy": p.net[:, 1]}  # fmt: skip
    columns |= {"radius": p.radius} if way.size == "radius" else {"diameter": 2 * p.radius}
    for k, form in enumerate(way.forms):
        values = p.position[:, k]
        values = values + p.cell[k] * rng.integers(-3, 4, len(values)) if "u" in form else values
        columns["xy"[k] + form] = (values - ORIGIN[k]) / p.cell[k] if "s" in form else values
    return _snapshot(p, way, "ATOMS", columns, len(p.ids), rng)


def contacts_text(p: Packing, way: Way) -> str:
    """One snapshot of ``dump local``; the force is that on the first grain of a row, as LAMMPS gives it."""
    rng = np.random.default_rng(way.order + 1)
    rows = np.arange(len(p.i))
    if way.twice == "some":
        rows = np.append(rows, rng.choice(rows, 5, replace=False))
    turned = rng.random(len(rows)) < 0.5
    if way.twice == "both":
        rows, turned = np.tile(rows, 2), np.repeat([False, True], len(rows))
    sign = np.where(turned, -1.0, 1.0)[:, None]
    ends = np.where(turned[:, None], np.column_stack((p.j, p.i))[rows], np.column_stack((p.i, p.j))[rows])
    n = p.branch / np.hypot(*p.branch.T)[:, None]
    along = -(sign * p.normal[rows, None] * n[rows])
    aside = -(sign * p.force[rows]) - along
    columns: dict[str, Any] = {"id_i": p.ids[ends[:, 0]], "id_j": p.ids[ends[:, 1]]}
    whole = along if way.contact == "parts" else along + aside
    if way.contact in ("vector", "parts"):
        columns |= {"fx": whole[:, 0], "fy": whole[:, 1]}
    if way.contact == "parts":
        columns |= {"tx": aside[:, 0], "ty": aside[:, 1]}
    if way.contact == "scalar":
        columns |= {"normal": p.normal[rows], "tangential": p.tangential[rows]}
    if way.contact == "own":
        columns |= {"elastic": 1.2 * p.normal[rows], "viscous": -0.2 * p.normal[rows], "attraction": 0 * p.normal[rows],
                    "tangential": p.tangential[rows]}  # fmt: skip
    if way.branch:
        columns |= {"bx": (sign * p.branch[rows])[:, 0], "by": (sign * p.branch[rows])[:, 1]}
    if way.gap:
        gap = np.hypot(*p.branch[rows].T) - p.radius[p.i[rows]] - p.radius[p.j[rows]]
        columns[way.gap] = gap if way.gap == "gap" else -gap
    if way.flags:
        columns["sliding"] = p.slides[rows].astype(int)
    return _snapshot(p, way, "CONTACTS" if "label" in way.header else "ENTRIES", columns, len(rows), rng)


def _snapshot(p: Packing, way: Way, label: str, columns: dict[str, Any], rows: int, rng: np.random.Generator) -> str:
    columns = {way.renamed.get(name, name): values for name, values in columns.items() if name not in way.dropped}
    columns |= {name: [JUNK[name]] * rows for name in way.junk if name not in columns}
    names = rng.permutation(list(columns)).tolist()
    order = rng.permutation(rows)
    lines = [" ".join(_word(columns[name][row], way.digits) for name in names) for row in order]
    head = ("ITEM: UNITS\nlj\n" if "units" in way.header else "") + ("ITEM: TIME\n0.5\n" if "time" in way.header else "")
    faces = "" if "old" in way.header else " pp pp pp"
    tilt = " 0" if "tilt" in way.header else ""
    faces = f" xy xz yz{faces}" if tilt else faces
    box = (
        "".join(f"{low:.17g} {low + side:.17g}{tilt}\n" for low, side in zip(ORIGIN, p.cell, strict=True)) + f"-0.5 0.5{tilt}\n"
    )
    head += f"ITEM: TIMESTEP\n{way.step}\nITEM: NUMBER OF {label}\n{rows}\nITEM: BOX BOUNDS{faces}\n{box}"
    return head + f"ITEM: {label} {' '.join(names)}\n" + "".join(f"{line} \n" for line in lines)


def _word(value: Any, digits: int) -> str:
    return value if isinstance(value, str) else str(value) if isinstance(value, np.integer) else f"{value:.{digits}g}"


def write(folder: Path, name: str, texts: Sequence[str], packed: str = "") -> Path:
    """A file of snapshots, compressed if ``packed`` says how."""
    path = folder / (f"{name}.{packed}" if packed else name)
    path.write_bytes(PACK[packed]("".join(texts).encode()))
    return path
