"""Pictures of an exported run, made by OVITO and by VTK (the library inside ParaView), both without a display.

    wf run method2 --n 400 --rolling --pstar 0 --kappa 1e4 --out run && wf export run --to gsd,vtk
    pip install ovito vtk && python docs/export/pictures.py run/export

writes ovito.png and paraview.png beside this file.  What it does by program is what one does by hand in either: open the
file, colour the contacts by their normal force.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
REACH = 0.02  # normal forces [F0] at both ends of the colours
SIZE = 900


def ovito(folder: Path) -> None:
    """Open run.gsd; Color coding on the bonds by "normal"; grains as circles, so that the bonds stand out of them."""
    from ovito.io import import_file
    from ovito.modifiers import AssignColorModifier, ColorCodingModifier
    from ovito.vis import BondsVis, ParticlesVis, StandardRenderer, Viewport

    pipeline = import_file(str(folder / "run.gsd"))
    blue_red = ColorCodingModifier.BlueWhiteRed()
    pipeline.modifiers.append(
        ColorCodingModifier(property="normal", operate_on="bonds", start_value=-REACH, end_value=REACH, gradient=blue_red)
    )
    pipeline.modifiers.append(AssignColorModifier(operate_on="particles", color=(0.75, 0.75, 0.75)))
    data = pipeline.compute()
    print("ovito:", data.particles.count, "grains,", data.particles.bonds.count, "bonds at", data.attributes["time"])
    data.particles.vis.shape = ParticlesVis.Shape.Circle
    pipeline.add_to_scene()
    bonds = data.particles.bonds.vis
    bonds.width, bonds.coloring_mode = 0.25, BondsVis.ColoringMode.Uniform
    view = Viewport(type=Viewport.Type.Top)
    view.zoom_all(size=(SIZE, SIZE))
    view.render_image(
        filename=str(HERE / "ovito.png"), size=(SIZE, SIZE), background=(1, 1, 1), frame=pipeline.source.num_frames - 1,
        renderer=StandardRenderer(),
    )  # fmt: skip


def paraview(folder: Path) -> None:
    """Open grains and contacts; Glyph (2D circle, scaled by diameter) on one, Tube on the other, coloured by "normal"."""
    import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
    from vtkmodules.vtkFiltersCore import vtkGlyph3D, vtkTubeFilter
    from vtkmodules.vtkFiltersSources import vtkRegularPolygonSource
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
    from vtkmodules.vtkRenderingCore import (
        vtkActor,
        vtkColorTransferFunction,
        vtkPolyDataMapper,
        vtkRenderer,
        vtkRenderWindow,
        vtkWindowToImageFilter,
    )

    def reader(name: str) -> vtkXMLPolyDataReader:
        source = vtkXMLPolyDataReader()
        source.SetFileName(str(sorted(folder.glob(f"{name}.*.vtp"))[-1]))
        source.Update()
        return source

    grains, contacts = reader("grains"), reader("contacts")
    print("vtk:", grains.GetOutput().GetNumberOfPoints(), "grains,", contacts.GetOutput().GetNumberOfLines(), "contacts")
    circle = vtkRegularPolygonSource()
    circle.SetNumberOfSides(40)  # of radius 1/2
    glyph = vtkGlyph3D()
    glyph.SetInputConnection(grains.GetOutputPort())
    glyph.SetInputArrayToProcess(0, 0, 0, 0, "diameter")  # of the points
    glyph.SetSourceConnection(circle.GetOutputPort())
    glyph.SetScaleModeToScaleByScalar()
    tube = vtkTubeFilter()
    tube.SetRadius(0.1)
    tube.SetNumberOfSides(12)
    tube.SetInputConnection(contacts.GetOutputPort())
    colours = vtkColorTransferFunction()
    for value, colour in zip((-REACH, 0.0, REACH), ((0.02, 0.19, 0.57), (0.87, 0.87, 0.87), (0.7, 0.02, 0.15)), strict=True):
        colours.AddRGBPoint(value, *colour)
    scene = vtkRenderer()
    scene.SetBackground(1.0, 1.0, 1.0)
    for part, coloured in ((glyph, False), (tube, True)):
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(part.GetOutputPort())
        mapper.SetScalarVisibility(coloured)
        if coloured:
            mapper.SetScalarModeToUseCellFieldData()
            mapper.SelectColorArray("normal")
            mapper.SetLookupTable(colours)
        actor = vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(0.75, 0.75, 0.75)
        actor.GetProperty().LightingOff()
        actor.SetPosition(0.0, 0.0, 1.0 if coloured else 0.0)
        scene.AddActor(actor)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetSize(SIZE, SIZE)
    window.AddRenderer(scene)
    scene.GetActiveCamera().ParallelProjectionOn()
    scene.ResetCamera()
    scene.GetActiveCamera().Zoom(1.35)
    window.Render()
    picture = vtkWindowToImageFilter()
    picture.SetInput(window)
    writer = vtkPNGWriter()
    writer.SetFileName(str(HERE / "paraview.png"))
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()


if __name__ == "__main__":
    ovito(Path(sys.argv[1]))
    paraview(Path(sys.argv[1]))
