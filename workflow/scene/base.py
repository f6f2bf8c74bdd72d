"""The interface of a scene: what is run, in which stages, units and steps, and what the floors above do with a run of it.

A scene stands below decks, runs, measures and reports and imports none of them.  It declares by names what they are to do
with a run of it, and their registries hold each under that name:

``kind``      what the run ends in: its measures in `workflow.pipeline.kinds.KINDS`; its summary in
              `workflow.reports.summary.SUMMARIES` and its page in `workflow.reports.views.VIEWS`, where a kind without an
              entry is shown number by number
``figures``   groups of figures of `workflow.reports.registry.FIGURES`

Names, not functions: a scene is then read without HDF5, SciPy or matplotlib, imports lead down only, and a file from outside
adds entries to the same registries (docs/extending.md).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from html import escape
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from workflow.data.contact_law import ContactLaw
from workflow.data.discs import Discs
from workflow.data.frame import Floats
from workflow.data.units import Units
from workflow.errors import InputError
from workflow.scene.parameter import quantity_of
from workflow.scene.parts import Readings
from workflow.scene.time_step import Step


@dataclass(frozen=True, kw_only=True, repr=False)
class Scene(Readings):
    """Base of every scene; every parameter is a field (`quantity`), every derived number a property.

    ``name`` on the command line and in files, ``title`` in words; ``template``: the deck, relative to lammps_inputs/, None
    for that of this name; ``stages``: names of the deck's stages by number; ``kind`` and ``figures`` as in the module's
    text; ``ends_in_equilibrium``: its last stage waits for that; ``stream``: first word of the seeds of its random streams,
    None for its name.

    To be given: `size`, `step_choice`, `discs` and `variables`.  The rest has a default.  A subclass that is a dataclass with
    ``repr=False`` has the short repr of this class.
    """

    name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    kind: ClassVar[str] = ""
    template: ClassVar[Path | None] = None
    stages: ClassVar[dict[int, str]] = {}
    figures: ClassVar[tuple[str, ...]] = ()
    ends_in_equilibrium: ClassVar[bool] = False
    stream: ClassVar[str | None] = None

    def __repr__(self) -> str:
        """The call that makes it: parameters that are not as this class would choose them."""
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.chosen().items())})"

    def _repr_html_(self) -> str:
        """For notebooks: every parameter with its unit and meaning, those that were chosen in bold."""
        chosen = self.chosen()
        rows = []
        for item in fields(self):
            known, value = quantity_of(item), getattr(self, item.name)
            text = escape("" if value is None else f"{value} {known.unit}".strip())
            shown = f"<b>{text}</b>" if item.name in chosen else text
            rows.append(f"<tr><td>{item.name}</td><td>{shown}</td><td>{escape(known.meaning)}</td></tr>")
        head = f"{escape(self.title)}; {escape(self.sample)}"
        return f"<details><summary><code>{escape(repr(self))}</code> {head}</summary><table>{''.join(rows)}</table></details>"

    def chosen(self) -> dict[str, Any]:
        """The parameters that are needed to make this scene again, the others follow from them."""
        usual = type(self)()
        found = {name: value for name, value in self.as_mapping().items() if value != getattr(usual, name)}
        for item in fields(self):
            if item.name in found and item.default is None:  # it may follow from the others
                rest = {name: value for name, value in found.items() if name != item.name}
                with suppress(InputError):
                    found = rest if type(self)(**rest) == self else found
        return found

    # ---- what is run
    @property
    def size(self) -> int:
        """Number of grains."""
        raise NotImplementedError

    @property
    def step_choice(self) -> Step:
        """The time step with its reason."""
        raise NotImplementedError

    def discs(self) -> Discs:
        """The initial discs, as the data file holds them."""
        raise NotImplementedError

    def files(self) -> dict[str, str]:
        """What the deck reads beside its data file: name -> text."""
        return {}

    def variables(self) -> dict[str, Any]:
        """Values of the variables of the deck."""
        raise NotImplementedError

    @property
    def digest(self) -> str:
        """Hash of the resolved scene, the run's identity."""
        text = json.dumps({"scene": self.name, **self.as_mapping()}, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    def random(self, stage: str) -> np.random.Generator:
        """The random stream of a stage: its seed hashes what the stage depends on, so that stages are independent."""
        words = hashlib.sha256(f"{self.stream or self.name}/{stage}/{self.as_mapping().get('seed')}".encode()).digest()
        return np.random.default_rng(np.frombuffer(words, dtype=np.uint32))

    # ---- what its numbers mean
    @property
    def units(self) -> Units:
        """Names of its units."""
        return Units("a", "F₁", "T₀")

    @property
    def force_unit(self) -> float:
        """F1, in which forces are judged and drawn."""
        return 1.0

    @property
    def tolerance(self) -> float:
        """Forces below ``tolerance`` F1 count as none."""
        return 1e-4

    @property
    def cohesive(self) -> bool:
        """An attraction acts."""
        return False

    @property
    def force_set_by(self) -> str:
        """What sets the unit of force: "force", an attraction; "pressure"; "gravity"; see `workflow.data.si`."""
        return "force" if self.cohesive else "pressure"

    def law_of(self, stage: str) -> ContactLaw | None:
        """The law of G07 at the end of a stage; None under another law, which the groups of measures do not know."""
        return None

    @property
    def lammps_law(self) -> tuple[ContactLaw, float] | None:
        """Of a run under a pair style of LAMMPS: the law that it stands for, and the R_i R_j/(R_i + R_j) at which its rolling
        spring is that of the law.  None under a pair style of the plugin, which tells more of a contact."""
        return None

    @property
    def needs_plugin(self) -> bool:
        """The deck runs only with the plugin of this package."""
        return True

    @property
    def resumes_exactly(self) -> bool:
        """A run that goes on from a checkpoint is, bit for bit, the run that was not interrupted."""
        return True

    def pressure_of(self, stage: str) -> float | None:
        """Stress imposed in a stage, None in a cell of fixed size."""
        return None

    def alike(self, one: str, other: str) -> bool:
        """The grains have the same law and load at the ends of two stages."""
        return one == other

    def record(self) -> dict[str, Any]:
        """What the archive keeps of it beside its parameters."""
        return {}

    # ---- what it says
    @property
    def sample(self) -> str:
        """Which sample it is: its seed, if it has one, and the number of grains."""
        seed = self.as_mapping().get("seed")
        return f"N = {self.size}" if seed is None else f"seed {seed}, N = {self.size}"

    def warnings(self) -> list[str]:
        """What is unusual, a sentence each."""
        return []

    def left_out(self) -> list[str]:
        """What this scene does not use and therefore does not pay for."""
        return []

    def without_effect(self) -> dict[str, str]:
        """Parameters that change nothing in this scene, as its other ones stand: name -> why."""
        return {}

    def notes(self) -> list[str]:
        """Sentences before a run: the step and its reason, what is unusual, what is left out."""
        choice, out = self.step_choice, self.left_out()
        unit = next((quantity_of(item).unit for item in fields(self) if item.name == "step"), "T0")
        step = f"step {choice.step:.3g} {unit}: {choice.reason}"
        return [step, *self.warnings(), *([f"left out, not paid for: {', '.join(out)}"] if out else [])]

    def state_line(self, series: Mapping[str, Floats]) -> str:
        """What the last row of the time series tells beside stage and time, in words."""
        return ""

    def time_left(self, rows: Mapping[str, Floats], stage: str) -> float | None:
        """Time that the stage still takes, in the unit of the scene, from its ``rows`` of the time series; None: unknown."""
        return None

    def cost_left(self, rows: Mapping[str, Floats]) -> float:
        """Cost of a step in what is left of the stage on the mean, over that of a step now."""
        return 1.0

    def progress_line(self, series: Mapping[str, Floats], left: str | None = None) -> str:
        """One line while it runs: stage i of n, time, what is ``left`` of the stage in words, `state_line`."""
        number = int(series["stage"][-1])
        place = f"{list(self.stages).index(number) + 1}/{len(self.stages)}" if number in self.stages else "?"
        parts = [f"{self.stages.get(number, '?')} {place}", f"t {series['time'][-1]:.2f}", f"left {left}" if left else "",
                 self.state_line(series)]  # fmt: skip
        return "  ".join(filter(None, parts))
