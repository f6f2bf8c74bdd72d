"""Measures of grains that other programs made: LAMMPS dumps, arrays, a Universe.

The same on the command line: wf measure grains.dump --contacts contacts.dump --mu 0.3 --kn 1000 --kt 286
"""

import os
import subprocess
import warnings
from pathlib import Path

import MDAnalysis
import numpy as np

import workflow as wf
from workflow.archive.foreign import foreign_frames, universe_frame
from workflow.data.balance import solid_fraction
from workflow.data.build import make_frame
from workflow.measures.packing import coordination
from workflow.measures.percolation import percolation

grains = os.environ.get("WORKFLOW_EXAMPLE_GRAINS", "400")
deck = Path(__file__).with_name("pack.in").read_text()
Path("pack.in").write_text(deck)
subprocess.run(["lmp", "-in", "pack.in", "-var", "grains", grains, "-screen", "none", "-log", "none"], check=True)

# dumps: a frame, and the law of its contacts
frame = next(foreign_frames("grains.dump", "contacts.dump", friction=0.3))
found = wf.measure(frame, groups=["forces", "rigidity"], law=wf.ContactLaw(kn=1000.0, kt=286.0, mu=0.3))
print(frame, frame.interactions, sep="\n")
print("hyperstaticity", found["rigidity"]["hyperstaticity"], "floppy modes", found["rigidity"]["floppy_modes"])
print(f"{frame.grains} grains, {len(frame.interactions)} contacts, z = {coordination(frame, threshold=1e-6).z:.3f}")
print("forces percolate up to", percolation(frame).any)

# plain arrays of any origin: positions, diameters and the cell are enough; contacts are then the discs that overlap
arrays = make_frame(frame.position, frame.diameter, frame.cell)
print(f"from arrays: {len(arrays.interactions)} overlaps, solid fraction {solid_fraction(arrays):.4f}")

# a MDAnalysis Universe: float32, which the warning is about
universe = MDAnalysis.Universe.empty(frame.grains, trajectory=True)
universe.add_TopologyAttr("radii", frame.diameter / 2)
universe.atoms.positions = np.column_stack((frame.position, np.zeros(frame.grains)))
universe.dimensions = [*frame.cell, 1.0, 90.0, 90.0, 90.0]
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    seen = universe_frame(universe)
print(f"from a Universe: {len(seen.interactions)} overlaps; {said[-1].message}")
