"""A scene, and the measures of a run of it, in SI: rows of name, value of the scene, value in SI."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from workflow.data.frame import Frame
from workflow.data.si import Powder
from workflow.errors import InputError
from workflow.scene.base import Scene
from workflow.scene.parameter import quantity_of

Row = tuple[str, float, str]  # name, value in units of the scene, dimension
# units of parameters, and their dimensions
UNITS = {
    "a": "length", "sigma": "length", "T0": "time", "sqrt(sigma/g)": "time", "sqrt(a/g)": "time", "1/T0": "rate",
    "a/T0": "velocity", "F0/a": "stress", "mg": "force", "mg/sigma": "stiffness", "mg sigma": "energy",
}  # fmt: skip
# numbers of a run: path among its measures, name, dimension
MEASURED = (
    (("time",), "time", "time"), (("stress", "xx"), "stress xx", "stress"), (("stress", "yy"), "stress yy", "stress"),
    (("stress", "xy"), "stress xy", "stress"),
    (("kinetic_energy", "per_grain"), "kinetic energy of a grain", "energy"), (("height",), "height of the heap", "length"),
    (("half_width",), "half width of the heap", "length"), (("numerics", "step"), "time step", "time"),
    (("numerics", "largest_overlap"), "largest overlap", "length"),
    (("numerics", "fastest_approach"), "fastest approach", "velocity"),
)  # fmt: skip


def require_fit(scene: Scene, powder: Powder) -> None:
    """Raise InputError if the unit of force of the scene is not what the powder gives."""
    needed = scene.force_set_by
    if powder.by != needed:
        raise InputError(f"forces of this {scene.name} are in units of {scene.units.force}: give --{needed} instead of "
                         f"--{powder.by}")  # fmt: skip


def of_scene(scene: Scene, powder: Powder) -> Iterator[Row]:
    """The parameters that have a dimension and are not 0, K_N, and the velocities V* and V0.  Raises InputError."""
    require_fit(scene, powder)
    idle, law = scene.without_effect(), scene.law_of(next(iter(scene.stages.values())))
    for item in fields(scene):
        value, dimension = getattr(scene, item.name), UNITS.get(quantity_of(item).unit)
        if dimension and isinstance(value, int | float) and value and item.name not in idle:
            yield item.name, float(value), dimension
    if law is not None:
        yield "K_N", law.kn, "stiffness"
        if law.f0:
            yield "V*", law.d0**0.5, "velocity"
            if hasattr(scene, "v0"):
                yield "V0", scene.v0 * law.d0**0.5, "velocity"


def of_measures(measures: Mapping[str, Any]) -> Iterator[Row]:
    """The measures that have a dimension."""
    for path, name, dimension in MEASURED:
        value: Any = measures
        for key in path:
            value = value.get(key) if isinstance(value, Mapping) else None
        if isinstance(value, int | float):
            yield name, float(value), dimension


def of_frame(frame: Frame) -> Iterator[Row]:
    """Lengths of the cell and normal forces of a frame."""
    sizes = abs(frame.interactions.normal_force)
    yield "width of the cell", float(frame.cell[0]), "length"
    yield "height of the cell", float(frame.cell[1]), "length"
    if len(sizes):
        yield "mean normal force (size)", float(sizes.mean()), "force"
        yield "largest normal force (size)", float(sizes.max()), "force"
