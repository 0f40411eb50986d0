"""ParaView: the methods of `maille compare --out` side by side, in one view, one colour scale, each under its name.

As a macro (Macros > Import New Macro...): open OUT/SCENE.vtm, Apply, then press the macro. Without a window:
    pvbatch maille_compare.py OUT/SCENE.vtm [--field Displacement|DisplacementError|VonMises|FiberStrain] [--warp FACTOR] [--png FILE] [--state FILE]

Bodies are drawn deformed (Warp By Vector), one below the other along the world's axis in which they are shortest; fields are those of
docs/files.md, vectors by their length. Of the reference there is no DisplacementError: it stays grey.
"""
import argparse
import os
import sys

from paraview import simple, vtk


def opened_file():
    """The .vtm that is active in ParaView's window."""
    source = simple.GetActiveSource()
    names = source.FileName if source is not None and hasattr(source, "FileName") else None
    name = names[0] if names is not None and not isinstance(names, str) and len(names) else names
    if not name or not str(name).endswith(".vtm"):
        raise SystemExit("expected OUT/SCENE.vtm, as `maille compare --out OUT` writes it, to be open and selected")
    return str(name)


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("file", nargs="?", help="OUT/SCENE.vtm")
    parser.add_argument("--field", default="Displacement")
    parser.add_argument("--warp", type=float, default=1.0, help="factor of the drawn displacements")
    parser.add_argument("--png", help="picture to write")
    parser.add_argument("--state", help="ParaView state (.pvsm) to write")
    # In ParaView's window the words are ParaView's own.
    return parser.parse_args(sys.argv[1:] if __name__ == "__main__" and sys.argv[0].endswith("maille_compare.py") else [])


def block_names(source):
    """Of a multi-block file, in its order: the methods."""
    data = source.GetClientSideObject().GetOutputDataObject(0)
    key = vtk.vtkCompositeDataSet.NAME()
    return [data.GetMetaData(i).Get(key) for i in range(data.GetNumberOfBlocks())]


def unit_of(source, field):
    """As the first method's file states it in its field data Units: "Displacement, ...: m; ...; Stress: Pa"; empty where it does not."""
    data = source.GetClientSideObject().GetOutputDataObject(0)
    units = data.GetBlock(0).GetFieldData().GetAbstractArray("Units") if data.GetNumberOfBlocks() else None
    for part in units.GetValue(0).split("; ") if units else ():
        names, _, unit = part.partition(": ")
        if field in names.split(", "):
            return unit.split(",")[0]
    return ""


def array_of(source, field):
    """POINTS or CELLS, whichever has the field, and its number of components; nothing where neither has."""
    for where, arrays in (("POINTS", source.PointData), ("CELLS", source.CellData)):
        array = arrays.GetArray(field)
        if array is not None:
            return where, array
    return None


class Method:
    """One method's body, warped and moved aside."""

    def __init__(self, source, name, index, warp):
        self.name = name
        block = simple.ExtractBlock(registrationName=f"{name} alone", Input=source)
        block.Selectors = [f"/Root/{name}"] if hasattr(block, "Selectors") else []
        merged = simple.MergeBlocks(registrationName=f"{name} merged", Input=block)
        warped = simple.WarpByVector(registrationName=f"{name} deformed", Input=merged)
        warped.Vectors = ["POINTS", "Displacement"]
        warped.ScaleFactor = warp
        self.body = simple.Transform(registrationName=name, Input=warped)
        self.body.UpdatePipeline()
        self.index = index

    def bounds(self):
        return self.body.GetDataInformation().GetBounds()

    def move(self, axis, distance):
        translation = [0.0, 0.0, 0.0]
        translation[axis] = distance
        self.body.Transform.Translate = translation
        self.body.UpdatePipeline()


def side_by_side(methods):
    """One below the other along the axis in which they are shortest (flat bodies: of those in which they have an extent).

    @return that axis, the longest one, and the third
    """
    sizes = [max(m.bounds()[2 * a + 1] - m.bounds()[2 * a] for m in methods) for a in range(3)]
    long = max(range(3), key=lambda a: sizes[a])
    up = min((a for a in range(3) if a != long and sizes[a] > 0.01 * sizes[long]), key=lambda a: sizes[a], default=(long + 1) % 3)
    step = max(1.8 * sizes[up], 0.2 * sizes[long])
    for method in methods:
        method.move(up, -step * method.index)
    return up, long, 3 - up - long


def colour(methods, field, unit, view):
    """The same scale for all; what lacks the field stays grey."""
    largest, smallest, vector = 0.0, 0.0, False
    for method in methods:
        display = simple.Show(method.body, view)
        display.Representation = "Surface With Edges"
        found = array_of(method.body, field)
        if found is None:
            display.AmbientColor = display.DiffuseColor = [0.6, 0.6, 0.6]
            display.ColorArrayName = ["POINTS", ""]
            continue
        where, array = found
        vector = array.GetNumberOfComponents() > 1
        simple.ColorBy(display, (where, field, "Magnitude") if vector else (where, field))
        low, high = array.GetRange(-1 if vector else 0)
        largest, smallest = max(largest, high), min(smallest, low)
        bar_display = display
    table = simple.GetColorTransferFunction(field)
    table.RescaleTransferFunction(0.0 if vector else smallest, largest if largest > smallest else smallest + 1)
    bar = simple.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle = f"{field} [{unit}]" if unit not in ("", "1") else field, "length" if vector else ""
    bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
    bar_display.SetScalarBarVisibility(view, True)
    return largest


def label(methods, axes, nearer, view):
    """Above the left end of each, where it is farthest from the viewer, who looks from above."""
    up, long, across = axes
    for method in methods:
        bounds = method.bounds()
        place = [0.0, 0.0, 0.0]
        place[long] = bounds[2 * long]
        place[up] = bounds[2 * up + 1] + 0.03 * (bounds[2 * long + 1] - bounds[2 * long])
        place[across] = bounds[2 * across + (0 if nearer > 0 else 1)]
        text = simple.Text(registrationName=f"name of {method.name}", Text=method.name)
        display = simple.Show(text, view)
        display.TextPropMode = "Billboard 3D Text"
        display.BillboardPosition = place
        display.Color = [0.0, 0.0, 0.0]
        display.FontSize = 22


def look(axes, view):
    """The longest axis to the right, the stack upright, a little from above. @return the sign of the third axis towards the viewer"""
    up, long, across = axes
    nearer = 1 if (long, up, across) in ((0, 1, 2), (1, 2, 0), (2, 0, 1)) else -1
    camera = view.GetActiveCamera()
    unit = [[1.0 if a == axis else 0.0 for a in range(3)] for axis in range(3)]
    camera.SetFocalPoint(0, 0, 0)
    camera.SetPosition(*[nearer * c for c in unit[across]])
    camera.SetViewUp(*unit[up])
    view.CameraParallelProjection = 1
    camera.Elevation(20)
    camera.OrthogonalizeViewUp()
    simple.ResetCamera(view)
    return nearer


def compare(file, field="Displacement", warp=1.0):
    """Makes the pipeline. @return the view, the methods, the largest value of the field"""
    source = simple.XMLMultiBlockDataReader(registrationName=os.path.basename(file), FileName=[file])
    source.UpdatePipeline()
    view = simple.GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.ViewSize = [1400, 900]
    simple.Hide(source, view)
    methods = [Method(source, name, index, warp) for index, name in enumerate(block_names(source))]
    if not any(array_of(method.body, field) for method in methods):
        raise SystemExit(f"no method has a field {field}; docs/files.md lists those that there are")
    axes = side_by_side(methods)
    largest = colour(methods, field, unit_of(source, field), view)
    label(methods, axes, look(axes, view), view)
    simple.Render(view)
    return view, methods, largest


def main():
    asked = arguments()
    view, methods, largest = compare(os.path.abspath(asked.file or opened_file()), asked.field, asked.warp)
    for method in methods:
        print(f"{method.name}: {' '.join(f'{number:.6g}' for number in method.bounds())}")
    print(f"largest {asked.field}: {largest:.6g}")
    if asked.png:
        simple.SaveScreenshot(asked.png, view, ImageResolution=[1400, 900])
    if asked.state:
        simple.SaveState(asked.state)


if __name__ in ("__main__", "__vtkconsole__"):
    main()
