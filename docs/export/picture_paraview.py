"""The picture of an exported run, made by ParaView without a display.

    wf run method2 --n 400 --rolling --pstar 0 --kappa 1e4 --seed 1 --out run && wf export run --to vtk --all
    apt-get install paraview xvfb && xvfb-run -a pvpython docs/export/picture_paraview.py run/export paraview.png

What it does by program is what one does by hand: open the three .pvd files, *Glyph* (sphere, scaled by "diameter", all
points) for the grains, *Tube* for the contacts, coloured by "normal", the normal force.
"""

import sys

from paraview.simple import (
    ColorBy,
    CreateRenderView,
    GetAnimationScene,
    GetColorTransferFunction,
    GetScalarBar,
    GetTimeKeeper,
    Glyph,
    PVDReader,
    Render,
    ResetCamera,
    SaveScreenshot,
    Show,
    Transform,
    Tube,
)

REACH = 0.02  # normal forces [F0] at both ends of the colours
SIZE = [720, 720]

folder, picture = sys.argv[1:]
grains, contacts, cell = (PVDReader(FileName=f"{folder}/{name}.pvd") for name in ("grains", "contacts", "cell"))
view = CreateRenderView(ViewSize=SIZE, UseColorPaletteForBackground=0, Background=[1, 1, 1], OrientationAxesVisibility=0)
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()

discs = Glyph(Input=grains, GlyphType="Sphere")  # of radius 1/2
discs.GlyphType.ThetaResolution = discs.GlyphType.PhiResolution = 24
discs.ScaleArray, discs.ScaleFactor, discs.GlyphMode = ["POINTS", "diameter"], 1.0, "All Points"
shown = Show(discs, view)
shown.ColorArrayName = [None, ""]
shown.AmbientColor = shown.DiffuseColor = [0.75, 0.75, 0.75]

above = Transform(Input=Tube(Input=contacts, Radius=0.12))
above.Transform.Translate = [0.0, 0.0, 0.7]  # in front of the grains
tubes = Show(above, view)
for part in (shown, tubes):
    part.Ambient, part.Diffuse = 1.0, 0.0  # the colours themselves, whatever the light
ColorBy(tubes, ("CELLS", "normal"))
colours = GetColorTransferFunction("normal")
colours.ApplyPreset("Cool to Warm", True)
colours.RescaleTransferFunction(-REACH, REACH)
bar = GetScalarBar(colours, view)
bar.Title, bar.ComponentTitle, bar.TitleColor, bar.LabelColor = "normal force N / F0", "", [0, 0, 0], [0, 0, 0]
bar.Orientation, bar.WindowLocation, bar.Position, bar.ScalarBarLength = "Horizontal", "Any Location", [0.3, 0.01], 0.4
bar.TitleFontSize = bar.LabelFontSize = 12
tubes.SetScalarBarVisibility(view, True)

border = Show(cell, view)
border.AmbientColor = border.DiffuseColor = [0, 0, 0]
border.LineWidth = 2
view.InteractionMode, view.CameraParallelProjection = "2D", 1
Render(view)
ResetCamera(view)
view.CameraParallelScale *= 0.86
print(grains.GetDataInformation().GetNumberOfPoints(), "grains,", contacts.GetDataInformation().GetNumberOfCells(),
      "contacts, time", GetTimeKeeper().Time, "of", len(grains.TimestepValues), "frames")  # fmt: skip
SaveScreenshot(picture, view)
