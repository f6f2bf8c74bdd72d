"""Energies of one frame from its grains and contact table (G07 law, physics.md section 1)."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from workflow.data.contact_law import ContactLaw
from workflow.data.frame import Floats, Frame


@dataclass(frozen=True)
class Energies:
    """Sums over the frame, in units of force times length.

    ``translation`` sum m v^2/2; ``rotation`` sum I w^2/2, I = m d^2/8; ``normal`` sum N_e^2/(2 K_N); ``tangential``
    sum K_T du^2/2; ``rolling`` sum K_r dtheta^2/2; ``adhesion`` sum U(h) <= 0.
    """

    translation: float
    rotation: float
    normal: float
    tangential: float
    rolling: float
    adhesion: float

    @property
    def kinetic(self) -> float:
        """translation + rotation."""
        return self.translation + self.rotation

    @property
    def elastic(self) -> float:
        """normal + tangential + rolling."""
        return self.normal + self.tangential + self.rolling

    @property
    def total(self) -> float:
        """kinetic + elastic + adhesion."""
        return self.kinetic + self.elastic + self.adhesion

    def as_dict(self) -> dict[str, float]:
        """All parts and sums, for JSON."""
        return asdict(self) | {"kinetic": self.kinetic, "elastic": self.elastic, "total": self.total}


def adhesion(gap: Floats, law: ContactLaw) -> Floats:
    """Potential of the attraction, (M,): its -dU/dh is the attractive force of G07 eqs. 4, 5.

    U = -F0 (D0 - h)^2/(2 D0) for 0 <= h <= D0; U = -F0 D0/2 + F0 h for h < 0; 0 beyond the range.
    """
    tail = np.clip(law.d0 - gap, 0.0, law.d0)
    return -law.f0 * tail**2 / (2 * law.d0 or 1.0) + law.f0 * np.minimum(gap, 0.0)


def energies(frame: Frame, law: ContactLaw) -> Energies:
    """Energies of ``frame``, whose contacts obey ``law``; the velocity is the one relative to the affine motion of the cell."""
    table, m = frame.interactions, frame.mass
    return Energies(
        translation=float((m * (frame.velocity**2).sum(axis=1)).sum() / 2),
        rotation=float((m * (frame.diameter * frame.omega) ** 2).sum() / 16),
        normal=float((table.elastic**2).sum() / (2 * law.kn)),
        tangential=float(law.kt * (table.xi_t**2).sum() / 2),
        rolling=float(law.kr * (table.xi_r**2).sum() / 2),
        adhesion=float(adhesion(table.gap, law).sum()),
    )
