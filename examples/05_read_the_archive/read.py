"""A run as arrays: contact forces in float64, tables of pandas, trajectories through MDAnalysis."""

import os

import numpy as np

import workflow as wf
from workflow.archive.read import universe

grains = int(os.environ.get("WORKFLOW_EXAMPLE_GRAINS", "400"))
packing = wf.run("method1", n=grains, cohesion=False, frame_interval=1.0, out="packing")

frames = packing.frames
contacts = frames[-1].interactions
print(frames, frames[-1], contacts, sep="\n")
force = contacts.normal_force / contacts.normal_force.mean()
print("share of contacts above twice the mean force:", round(float((force > 2).mean()), 3))
# T opposes the elastic displacement; the Coulomb cone bounds it by mu times the elastic part of N
print("largest |T|/N_e:", round(float(np.max(np.abs(contacts.tangential) / contacts.elastic)), 4))
print("columns of the time series:", ", ".join(list(packing.series)[:8]), "...")
print(contacts.to_pandas().describe()[["gap", "normal_force", "tangential"]].round(4))

trajectory = universe(packing.archive)
print("MDAnalysis sees", trajectory.atoms.n_atoms, "grains in", trajectory.trajectory.n_frames, "frames")
