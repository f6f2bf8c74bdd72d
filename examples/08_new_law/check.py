"""Compile the law and use it in the decks of the package: two discs collide, a gas is compressed.

The collision is compared with the closed form and with the reference integrator.
"""

import math
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workflow.archive.dumps import read_blocks, read_frames
from workflow.data.series import read_series
from workflow.deck.template import templates
from workflow.reference.cohesive import CONTACT, CohesiveLaw
from workflow.reference.discs import Discs
from workflow.reference.integrate import integrate
from workflow.runs.installation import engine, python_child

HERE = Path(__file__).resolve().parent
PLUGIN = HERE.parents[1] / "plugins"  # headers; of an installed package they are beside it
SPEED, KN, CAP, STEP = 1.0, 1e4, 20.0, 1e-5
REDUCED = 0.5  # mass of two discs of mass 1
DECKS = Path("decks")  # a copy of the decks of the package, to run in


def build() -> None:
    """cappedplugin.so beside the decks: one file, compiled like the package's own plugin."""
    done = subprocess.run([sys.executable, PLUGIN / "where.py"], capture_output=True, text=True, check=True)
    _, lammps, mpi, _ = done.stdout.strip().split(";")
    subprocess.run(
        ["c++", "-std=c++17", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off", "-DLAMMPS_SMALLBIG",
         "-isystem", lammps, "-isystem", mpi, "-I", PLUGIN, HERE / "pair_disc_capped.cpp", "-o", DECKS / "cappedplugin.so"],
        check=True,
    )  # fmt: skip


def closed_form() -> tuple[float, float]:
    """Deepest overlap and duration of the contact: a sine up to the cap, then a parabola, and back."""
    frequency, limit = math.sqrt(KN / REDUCED), CAP / KN
    deepest = limit + (0.5 * REDUCED * SPEED**2 - 0.5 * KN * limit**2) / CAP
    at_cap = math.sqrt(SPEED**2 - (frequency * limit) ** 2)
    return deepest, 2.0 * math.asin(frequency * limit / SPEED) / frequency + 2.0 * at_cap * REDUCED / CAP


@dataclass(frozen=True)
class CappedLaw(CohesiveLaw):
    """The law for the reference integrator: that of G07 with another repulsion."""

    cap: float = 0.0

    def response(self, reduced, motion, memory, modes):
        """As without cap, less what the spring has beyond it."""
        found = super().response(reduced, motion, memory, modes)
        beyond = np.where(modes[0] == CONTACT, np.maximum(-self.kn * motion.gap - self.cap, 0.0), 0.0)
        return found._replace(normal=found.normal - beyond)


def run(deck: str, **values: float) -> str:
    """Run a deck of the package with the law of this folder; its log."""
    for dump in DECKS.glob("*.dump"):
        dump.unlink()
    words = {"law": HERE / "capped.in", "kn": KN, "cap": CAP, **values}
    command = [*python_child(), deck, *(str(word) for pair in words.items() for word in pair)]
    subprocess.run(command, cwd=DECKS, env=engine().variables(), check=True)
    return (DECKS / "log.lammps").read_text()


shutil.copytree(templates(), DECKS)
build()
deepest, duration = closed_form()
log = run("two_discs.in", speed=SPEED, gap=0.0, step=STEP, steps=round(1.2 * duration / STEP), trace_every=1)
frames = [(block.time, block.named) for block in read_blocks(DECKS / "grains.dump", "ATOMS")]
time = np.array([time for time, _ in frames])
gap = np.array([np.diff(grains["x"])[0] - 1.0 for _, grains in frames])
vn = np.array([np.diff(grains["vx"])[0] for _, grains in frames])
table = np.loadtxt(log.rpartition("v_dissipated")[2].split("Loop")[0].splitlines()[1:])  # of thermo: step time ke c_energy
kinetic, potential = table[:, 2], table[:, 3]

in_contact = np.flatnonzero(gap < 0.0)
enters, leaves = in_contact[0], in_contact[-1]
ends = time[leaves] + gap[leaves] / -vn[leaves]
discs = Discs(
    position=np.array([[0.0, 0.0], [1.0, 0.0]]), velocity=np.array([[0.0, 0.0], [-SPEED, 0.0]]),
    omega=np.zeros(2), diameter=np.ones(2),
)  # fmt: skip
exact = integrate(CappedLaw(kn=KN, cap=CAP), discs, float(time[-1]), t_eval=time)
apart = exact.position[:, 1, 0] - exact.position[:, 0, 0] - 1.0
errors = {
    "deepest overlap": abs(-gap.min() / deepest - 1.0),
    "duration of the contact": abs(ends / duration - 1.0),
    "speed of the rebound": abs(vn[-1] / SPEED - 1.0),
    "energy": np.ptp(potential + kinetic) / kinetic[0],
    "gap against the reference": np.abs(gap - apart).max() / deepest,
}
frequency = math.sqrt(KN / REDUCED)
for name, error in errors.items():
    print(f"{name:28s} relative error {error:.1e}")
# second order in the step, (omega dt)^2 = 2e-6, times a few
assert max(errors.values()) < 10.0 * (frequency * STEP) ** 2, "the law is not what it should be"

run("method1.in", dashpots=0, rolling_dashpots=0, step=3e-4, max_steps=20_000)
*_, packing = read_frames(DECKS / "grains.dump", DECKS / "contacts.dump")
series = read_series(DECKS / "series.txt")
largest, residual = packing.interactions.elastic.max(), np.abs(series["residual"]).max() / series["work"].max()
print(f"compressed gas: {len(packing.interactions)} contacts, largest force {largest:.4g}, energy balance to {residual:.1e}")
# the work of the stress becomes motion, as nothing damps it; (omega dt)^2 = 2e-3
assert len(packing.interactions) > 10 and 0.5 * CAP < largest <= CAP and residual < 2e-3, "the law is not used by the deck"
