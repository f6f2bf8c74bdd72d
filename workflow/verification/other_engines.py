"""Discs in programs that others wrote: the files of LIGGGHTS and YADE for a cohesionless law, their runs, what came out.

The decks are crosscheck_liggghts.in and crosscheck_yade.py; their heads say what is equal to our law and what is not.
"""

from __future__ import annotations

import math
import re
import shlex
import shutil
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from workflow.archive.dump_tables import Dump
from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.deck.template import data_file, templates
from workflow.errors import EngineError
from workflow.runs.launch import run_program
from workflow.scene.placement import Floats
from workflow.verification.one_run import Outcome, outcome_of, velocities

PEERS = ("liggghts", "yade")
DENSITY = 4.0 / math.pi  # of a disc with m = d^2


def liggghts_data(discs: Discs, velocity: Floats, omega: Floats) -> str:
    """Data file of atom_style granular: one type per diameter, the centre of the cell at 0 (deformations start from there)."""
    sizes, kind = np.unique(discs.diameter, return_inverse=True)
    width, height = (discs.cell / 2.0).tolist()
    head = (
        f"discs in a periodic cell\n\n{len(kind)} atoms\n{len(sizes)} atom types\n\n"
        f"{-width!r} {width!r} xlo xhi\n{-height!r} {height!r} ylo yhi\n-0.5 0.5 zlo zhi\n\nAtoms\n\n"
    )
    rows = zip(kind.tolist(), discs.diameter.tolist(), (discs.position - discs.cell / 2.0).tolist(), strict=True)
    text = head + "".join(f"{k} {t + 1} {d!r} {DENSITY!r} {x!r} {y!r} 0\n" for k, (t, d, (x, y)) in enumerate(rows, 1))
    return text + velocities(velocity, omega)


def liggghts_law(discs: Discs, law: ContactLaw) -> str:
    """The law of each pair of types; eta = 2 zeta sqrt(K_N m*) is one number per pair of diameters."""
    mass = np.unique(discs.diameter) ** 2
    eta = 2.0 * law.zeta * np.sqrt(law.kn * mass[:, None] * mass / (mass[:, None] + mass))
    columns: dict[str, Floats | float] = {
        "kn": law.kn, "kt": law.kt, "gamman_abs": eta, "gammat_abs": 0.0, "coefficientFriction": law.mu,
    }  # fmt: skip
    lines = []
    for name, value in columns.items():
        numbers = " ".join(map(repr, (np.zeros_like(eta) + value).ravel().tolist()))
        lines.append(f"fix {name} all property/global {name} peratomtypepair {len(mass)} {numbers}\n")
    return "".join(lines)


def prepare(
    folder: Path, program: str, discs: Discs, law: ContactLaw, values: dict[str, float | int], velocity: Floats, omega: Floats
) -> list[str]:
    """Write deck, grains and run.sh to ``folder``, made if it is not there; the command in run.sh.

    ``values``: variables of the deck beside those of the law.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if program == "liggghts":
        files = {"liggghts.data": liggghts_data(discs, velocity, omega), "liggghts.law": liggghts_law(discs, law)}
        deck = "crosscheck_liggghts.in"
        options = [str(word) for name, value in values.items() for word in ("-var", name, value)]
        command = [program, "-in", deck, "-screen", "none", *options]
    else:
        files = {"grains.data": data_file(discs) + velocities(velocity, omega)}
        deck = "crosscheck_yade.py"
        known = {"kn": law.kn, "kt": law.kt, "zeta": law.zeta, "mu": law.mu, **values}
        command = [program, "-n", "-x", "-j1", deck, *(f"{name}={value!r}" for name, value in known.items())]
    for name, text in {**files, "run.sh": f"#!/bin/sh\n{shlex.join(command)}\n"}.items():
        (folder / name).write_text(text, encoding="ascii")
    shutil.copy(templates() / deck, folder)
    return command


def run(
    folder: Path, program: str, discs: Discs, law: ContactLaw, values: dict[str, float | int], velocity: Floats, omega: Floats
) -> Outcome:
    """`prepare` and run; the final state with ``position`` unwrapped, in the order of the data.

    Raises EngineError with the program's words if it stops.
    """
    command = prepare(folder, program, discs, law, values, velocity, omega)
    dump = folder / "grains.dump"
    dump.unlink(missing_ok=True)
    begun = time.perf_counter()
    words = run_program(command, folder).output()
    found = re.findall(r"^RESULT lx (\S+) ly (\S+)", words, re.MULTILINE)
    if not found or not dump.is_file():
        raise EngineError(f"{program} did not come to the end in '{folder}'; it said: {' '.join(words.split())[-200:]}")
    width, height = map(float, found[-1])
    snapshots = Dump([dump])
    block = list(snapshots.snapshots.values())[-1]
    end = outcome_of(
        snapshots.table(block, ("x", "y", "ix", "iy", "vx", "vy", "omegaz")),
        {"lx": width, "ly": height},
        time.perf_counter() - begun,
    )
    corner = end.cell / 2.0 if program == "liggghts" else np.zeros(2)
    return replace(end, position=end.position + corner)
