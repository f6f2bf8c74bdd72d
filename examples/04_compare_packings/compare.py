"""What cohesion and friction do to a packing of method 1: solid fraction and coordination number."""

import os

import workflow

GRAINS = int(os.environ.get("WORKFLOW_EXAMPLE_GRAINS", "400"))

grid = {"cohesion": [False, True], "mu": [0.15, 0.5]}
print("cohesion  mu    Phi     z      z*     rattlers")
for run in workflow.sweep("method1", grid, out="packings", n=GRAINS):
    found = run.measures
    print(
        f"{run.scene.cohesion!s:8}  {run.scene.mu:4.2f}  {found['solid_fraction']:.4f}  {found['coordination']:.3f}  "
        f"{found['coordination_backbone']:.3f}  {100 * found['rattler_fraction']:.1f} %"
    )
    workflow.plot(run, "forces", out=run.directory / "forces.svg")
