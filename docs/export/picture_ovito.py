"""The picture of an exported run, made by OVITO without a display.

    wf run method2 --n 400 --rolling --pstar 0 --kappa 1e4 --seed 1 --out run && wf export run --to gsd
    pip install ovito && python docs/export/picture_ovito.py run/export ovito.png

What it does by program is what one does by hand: open run.gsd, colour the bonds by "normal", the normal force.
"""

import sys

from ovito.io import import_file
from ovito.modifiers import AssignColorModifier, ColorCodingModifier
from ovito.vis import BondsVis, ParticlesVis, StandardRenderer, Viewport
from PIL import Image

REACH = 0.02  # normal forces [F0] at both ends of the colours
SIZE = (720, 720)

folder, picture = sys.argv[1:]
pipeline = import_file(f"{folder}/run.gsd")
pipeline.modifiers.append(
    ColorCodingModifier(
        property="normal", operate_on="bonds", start_value=-REACH, end_value=REACH, gradient=ColorCodingModifier.BlueWhiteRed()
    )
)
pipeline.modifiers.append(AssignColorModifier(operate_on="particles", color=(0.75, 0.75, 0.75)))
data = pipeline.compute()
print(data.particles.count, "grains,", data.particles.bonds.count, "bonds, time", data.attributes["time"])
data.particles.vis.shape = ParticlesVis.Shape.Circle
bonds = data.particles.bonds.vis
bonds.width, bonds.coloring_mode = 0.25, BondsVis.ColoringMode.Uniform
pipeline.add_to_scene()
view = Viewport(type=Viewport.Type.Top)
view.zoom_all(size=SIZE)
view.render_image(filename=picture, size=SIZE, background=(1, 1, 1), renderer=StandardRenderer())
Image.open(picture).convert("RGB").quantize(64).save(picture, optimize=True)  # a third of the size
