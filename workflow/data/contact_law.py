"""The constants of the cohesive contact law of G07, one class from the scene to the reference, the measures and the figures.

G07 is Gilabert, Roux, Castellanos, PRE 75, 011303 (2007).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from workflow.errors import InputError


@dataclass(frozen=True)
class ContactLaw:
    """Constants of the law of G07 sec. II B, under the names that ``pair_style disc/cohesive`` takes.

    ==========  ========  ==============  ===========================================================================
    field       symbol    unit            meaning
    ==========  ========  ==============  ===========================================================================
    ``kn``      K_N       force/length    normal stiffness, N = -K_N h for a gap h < 0 (eq. 5)
    ``kt``      K_T       force/length    tangential stiffness, T = -K_T xi_t (eq. 8)
    ``zeta``    zeta      1               damping, fraction of critical: gamma_n = zeta sqrt(4 K_N m*) (eq. 6)
    ``mu``      mu        1               friction coefficient, K_T |xi_t| <= mu K_N (-h); inf: never slips (eq. 8)
    ``f0``      F0        force           attraction in contact, -F0 (1 - h/D0) at a gap 0 <= h <= D0 (eq. 4)
    ``d0``      D0        length          range of the attraction
    ``kr``      K_r       force length    rolling stiffness, moment -K_r xi_r (eq. 9)
    ``mur``     mu_r      length          rolling friction, K_r |xi_r| <= mu_r K_N (-h); inf: never rolls (eq. 10)
    ==========  ========  ==============  ===========================================================================

    f0 = 0 or d0 = 0: no tail; mu = 0: no friction; mur = 0: no rolling resistance.  ``mu`` is NaN where the data of another
    program do not say it.  Raises InputError unless kn > 0 and all others >= 0, all finite but ``mu`` and ``mur``.
    """

    kn: float
    kt: float = 0.0
    zeta: float = 0.0
    mu: float = 0.0
    f0: float = 0.0
    d0: float = 0.0
    kr: float = 0.0
    mur: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value, limitless = getattr(self, field.name), field.name in ("mu", "mur")
            known = (value >= 0.0 and (limitless or value < math.inf)) or (field.name == "mu" and math.isnan(value))
            if not known or (field.name == "kn" and value == 0.0):
                allowed = "> 0 and finite" if field.name == "kn" else ">= 0" + ("" if limitless else " and finite")
                raise InputError(f"law: '{field.name}' is {value!r}; it must be {allowed}; correct this value")

    @property
    def cohesive(self) -> bool:
        """An attraction acts: F0 > 0."""
        return self.f0 > 0.0

    @property
    def rolling(self) -> bool:
        """Contacts resist rolling: mu_r > 0."""
        return self.mur > 0.0

    @property
    def cutoff_gap(self) -> float:
        """Largest gap at which a pair interacts: D0 with cohesion, 0 without [length]."""
        return self.d0 if self.f0 > 0.0 else 0.0

    @property
    def tail_stiffness(self) -> float:
        """Stiffness of pairs in the tail of the attraction, -F0/D0 (eq. 4), 0 where there is none [force/length]."""
        return -self.f0 / self.d0 if self.cutoff_gap > 0.0 else 0.0
