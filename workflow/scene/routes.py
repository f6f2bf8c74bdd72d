"""Which contact law, and what moves the cell: the combinations there are, and what the decks need to know of them.

``exact`` is the law of G07 in the plugin.  ``granular`` and ``hooke/history`` are LAMMPS's own pair styles, with their
integration: dampers see half-step velocities.  What differs, and by how much, is in docs/model.md.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from workflow.errors import InputError

if TYPE_CHECKING:
    from workflow.scene.packing import Packing

LARGEST_FRICTION = 1e4  # of hooke/history
RATIO = 3.0  # of diameters, beyond which half-step velocities let small grains stick (Vyas et al., CPC 310, 109524 (2025))


def route_variables(scene: Packing) -> dict[str, Any]:
    """The law file, and what LAMMPS's laws need in place of constants of the material."""
    return {"law": f"common/law_{_law_file(scene)}.in", "pair_radius": (1.0 + scene.smallest) / 8.0}


def _law_file(scene: Packing) -> str:
    if scene.exact:
        return "cohesive"
    end = "_cohesive" if scene.cohesion else "_inertial" if scene.barostat == "inertial" else ""
    return scene.law.replace("/", "_") + end


def mean_pair_mass(smallest: float) -> float:
    """Mean of m_i m_j/(m_i + m_j) over pairs of discs with diameters uniform in [smallest, 1] and m = d^2."""
    mass = np.linspace(smallest, 1.0, 201) ** 2
    return float((mass[:, None] * mass / (mass[:, None] + mass)).mean())


def check_route(scene: Packing) -> None:
    """Raise InputError for a law, a barostat and parameters that do not go together."""
    law, named = scene.law or "exact", f"law = {scene.law}"
    of_lammps, first_order = law != "exact", scene.barostat == "berendsen"
    rules = (
        (law == "hooke/history" and scene.cohesion, f"{named} has no attraction: add cohesion = false, or use granular"),
        (law == "hooke/history" and scene.rolling, f"{named} has no rolling resistance: leave rolling out, or use granular"),
        (law == "hooke/history" and scene.mu > LARGEST_FRICTION,
         f"{named} takes friction up to mu = {LARGEST_FRICTION:g}, not {scene.mu:g}: use granular for grains that never slip"),
        (law == "granular" and scene.zeta >= 1.0,
         f"{named} takes its damping as a restitution, which there is below zeta = 1 only, not at {scene.zeta:g}: "
         "use a smaller zeta, or the exact law"),
        (law == "granular" and scene.zeta == 0.0 and scene.dashpots > 0.0 and scene.mu > 0.0,
         f"{named} has dashpots as multiples of the damping, and zeta = 0 is none: use dashpots = 0, or the exact law"),
        (scene.scheme == "synchronized" and law != "granular",
         f"scheme = synchronized is one of law = granular, not of {law}: use second or paper"),
        (scene.scheme == "synchronized" and scene.mu == 0.0,
         "scheme = synchronized is one of springs that slide, and mu = 0 has none: leave scheme out"),
        (of_lammps and scene.drag > 0.0 and scene.barostat != "inertial",
         f"{named} with barostat = {scene.barostat} has no background drag: use dashpots, or barostat = inertial"),
        (scene.barostat != "inertial" and bool(scene.rate_cap or scene.wall_cap),
         f"barostat = {scene.barostat} has no cap on the speed of the cell: leave rate_cap and wall_cap out, or use inertial"),
        (scene.barostat == "nph" and scene.convention not in (0, -1),
         f"barostat = nph has its own momentum convention, -1, not {scene.convention}: leave it out, or use inertial"),
        (first_order and scene.convention != 0,
         f"barostat = berendsen has no momentum convention, here {scene.convention}: leave it out, or use inertial"),
    )  # fmt: skip
    for wrong, words in rules:
        if wrong:
            raise InputError(words)


def route_warnings(scene: Packing) -> list[str]:
    """What a law of LAMMPS does otherwise that a user should hear before the run."""
    if scene.exact:
        return []
    words = [f"law {scene.law} of LAMMPS: no account of energies, no elastic displacements (docs/model.md)"]
    if scene.smallest * RATIO < 1.0 and scene.scheme != "synchronized":
        words.append(
            f"size ratio {1.0 / scene.smallest:g}: with half-step velocities small grains may stick between large ones; "
            "exact, or granular with --scheme synchronized, does not do that"
        )
    return words
