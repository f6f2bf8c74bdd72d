"""wf units: what the units and parameters of a scene mean for a powder, in SI, and back."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from workflow.cli.lists import add_list, any_word, listed
from workflow.cli.options import command
from workflow.data.si import DIMENSIONS, FORCES, STANDS_FOR, Powder, in_words
from workflow.errors import InputError
from workflow.pipeline.si import of_scene
from workflow.runs.directory import RunDirectory
from workflow.scene.base import Scene
from workflow.scene.registry import scene_from

EXAMPLES = """
wf units --diameter 10um --density 1200 --force 30nN                   a toner: T0, and what P* = 0.01, kappa and V* mean
wf units --diameter 10um --density 1200 --force 30nN --convert 5Pa,2ms  and back: 5 Pa is P* = ...
wf units packing --diameter 10um --density 1200 --force 30nN           the parameters of a run
wf units --diameter 2mm --density 2500 --pressure 1kPa                 beads without cohesion
wf units --diameter 2mm --density 2500 --gravity 9.81                  a heap
"""
MEANS = {("force", "stress"): ": pstar", ("force", "stiffness"): ": kappa", ("pressure", "stiffness"): ": kappa"}
SHOWN: dict[str, dict[str, Any]] = {
    "force": {"scene": "method2"},
    "pressure": {"scene": "method1", "cohesion": False},
    "gravity": {"scene": "heap"},
}


def declare(commands: Any) -> None:
    """Options of `wf units`."""
    parser = command(commands, "units", "say what the units and parameters of a scene mean in SI", EXAMPLES, action=action)
    parser.add_argument("directory", type=Path, nargs="?", metavar="DIR", help="run directory (default: the default scene)")
    add_powder(parser)
    add_list(parser, "--convert", "Q", f"SI quantities to give in units of the scene: of {', '.join(DIMENSIONS)}")
    parser.add_argument("--json", action="store_true", help="print JSON, in SI")


def add_powder(parser: Any, needed: bool = True) -> None:
    """What says which powder it is; quantities with units."""
    parser.add_argument("--diameter", metavar="L", required=needed, help="diameter of the largest grains [m], such as 10um")
    parser.add_argument("--density", metavar="RHO", required=needed, help="density of their material [kg/m^3]")
    for name, unit in FORCES.items():
        parser.add_argument(f"--{name}", metavar=name[0].upper(), help=f"{STANDS_FOR[name]} [{unit}]; one of these three")


def powder_of(arguments: argparse.Namespace) -> Powder:
    """The powder that the command line describes.  Raises InputError."""
    if arguments.diameter is None or arguments.density is None:
        raise InputError("--si needs a powder: give --diameter, --density and one of --force, --pressure and --gravity")
    return Powder.of(arguments.diameter, arguments.density, **{name: getattr(arguments, name) for name in FORCES})


def refuse_powder(arguments: argparse.Namespace) -> None:
    """Raise InputError for a powder that is given and not used."""
    for name in ("diameter", "density", *FORCES):
        if getattr(arguments, name) is not None:
            raise InputError(f"--{name} says what SI values are: add --si")


def action(arguments: argparse.Namespace) -> int:
    """Print the units, the parameters, and what is to be converted."""
    powder = powder_of(arguments)
    scene: Scene = RunDirectory.open(arguments.directory).scene if arguments.directory else scene_from(SHOWN[powder.by])
    asked = listed("--convert", arguments.convert, any_word) if arguments.convert else []
    back = [(text, *powder.back(text)) for text in asked]
    parameters = list(of_scene(scene, powder))
    if arguments.json:
        units = {name: dict(zip(("value", "unit"), powder.unit(name), strict=True)) for name in DIMENSIONS}
        rows = [{"name": name, "value": value, **_si(powder, value, dimension)} for name, value, dimension in parameters]
        found = [{"si": text, "dimension": dimension, "value": value} for text, dimension, value in back]
        print(json.dumps({"units": units, "parameters": rows, "converted": found}, indent=1))
        return 0
    print("unit of             SI")
    for name in DIMENSIONS:
        print(f"{name:20s}{in_words(*powder.unit(name))}")
    print(f"\n{scene.name:20s}{'value':12s}SI")
    for name, value, dimension in parameters:
        print(f"{name:20s}{value:<12.6g}{powder.words(value, dimension)}")
    if scene.cohesive:
        print(f"\nF0 is {powder.force / (powder.mass * 9.81):.3g} times the weight of a grain")
    for text, dimension, value in back:
        print(f"{text} is {value:.6g} in units of {dimension}{MEANS.get((powder.by, dimension), '')}")
    return 0


def _si(powder: Powder, value: float, dimension: str) -> dict[str, Any]:
    factor, unit = powder.unit(dimension)
    return {"si": value * factor, "unit": unit}
