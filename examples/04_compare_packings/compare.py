"""What cohesion and friction do to a packing of method 1: solid fraction and coordination number."""

import json
import os
import subprocess

GRAINS = os.environ.get("WORKFLOW_EXAMPLE_GRAINS", "400")

print("cohesion  mu    Phi     z      z*     rattlers")
for cohesion in (False, True):
    for mu in (0.15, 0.5):
        flag = "--cohesion" if cohesion else "--no-cohesion"
        out = f"packing{flag}-mu{mu}"
        command = ["wf", "run", "method1", flag, "--mu", str(mu), "--n", GRAINS, "--out", out, "--json"]
        measures = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        print(
            f"{cohesion!s:8}  {mu:4.2f}  {measures['solid_fraction']:.4f}  {measures['coordination']:.3f}  "
            f"{measures['coordination_backbone']:.3f}  {100 * measures['rattler_fraction']:.1f} %"
        )
