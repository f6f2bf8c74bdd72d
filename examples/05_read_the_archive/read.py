"""A run as arrays: contact forces in float64 from the archive, trajectories through MDAnalysis."""

import os
import subprocess

import numpy as np

from workflow.archive.read import Archive, universe

grains = os.environ.get("WORKFLOW_EXAMPLE_GRAINS", "400")
subprocess.run(
    ["wf", "run", "method1", "--no-cohesion", "--n", grains, "--frame-interval", "1", "--out", "packing"], check=True
)

with Archive("packing/run.h5") as archive:
    frame = archive.frame(-1)
    contacts = frame.interactions
    print(f"{len(archive)} frames, the last at t = {frame.time:.2f} with {len(contacts)} interactions")
    force = contacts.normal_force / contacts.normal_force.mean()
    print("share of contacts above twice the mean force:", round(float((force > 2).mean()), 3))
    # T opposes the elastic displacement; the Coulomb cone bounds it by mu times the elastic part of N
    print("largest |T|/N_e:", round(float(np.max(np.abs(contacts.tangential) / contacts.elastic)), 4))
    print("columns of the time series:", ", ".join(list(archive.series)[:8]), "...")

trajectory = universe("packing/run.h5")
print("MDAnalysis sees", trajectory.atoms.n_atoms, "grains in", trajectory.trajectory.n_frames, "frames")
