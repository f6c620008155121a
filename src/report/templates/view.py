"""The results of a case in ParaView.

    paraview --script=results/view.py       (or File > Load State, or Tools > Python Shell > Run Script)
    pvbatch results/view.py picture.png     one picture, without a window

What the case has not computed is left out. Shown: the grains, cut open through the axis, the speed on the cut, streamlines. Hidden, with
an eye in the Pipeline Browser: the pressure on the cut, the whole grains, the section, the shortest paths, the voxels, OpenFOAM's meshes.
"""

import json
import os
import sys

from paraview.simple import *

# Where the results are: beside this script, or where they were when it was written.
HERE = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else "."
if not any(os.path.isdir(os.path.join(HERE, stage)) for stage in ("lbm", "stl", "voxelise", "foam")):
    HERE = @folder@
view = GetActiveViewOrCreate("RenderView")
try:
    LoadPalette("WhiteBackground")
except Exception:
    view.Background = [1.0, 1.0, 1.0]
view.OrientationAxesLabelColor = [0.0, 0.0, 0.0]


def path_of(*names):
    path = os.path.join(HERE, *names)
    return path if os.path.exists(path) else None


def show(source, visible=True, **properties):
    display = Show(source, view)
    for name, value in properties.items():
        setattr(display, name, value)
    if not visible:
        Hide(source, view)
    return display


def colour_by(source, array, association, title, component="", visible=True):
    """Colours by an array, with a bar that has a title with its unit."""
    display = show(source)
    ColorBy(display, (association, array, "Magnitude") if component == "Magnitude" else (association, array))
    display.RescaleTransferFunctionToDataRange(True, False)
    colours = GetColorTransferFunction(array)
    colours.ApplyPreset("Viridis (matplotlib)", True)
    bar = GetScalarBar(colours, view)
    bar.Title = title
    bar.ComponentTitle = ""
    bar.TitleColor = bar.LabelColor = [0.0, 0.0, 0.0]
    bar.TitleFontSize, bar.LabelFontSize, bar.ScalarBarThickness = 16, 13, 12
    bar.WindowLocation = "Upper Right Corner"
    display.SetScalarBarVisibility(view, visible)
    if not visible:
        Hide(source, view)


def cells_with(source, array, low, high):
    """The cells whose value lies between both; the filter has other properties before ParaView 5.10."""
    cells = Threshold(Input=source)
    cells.Scalars = ["CELLS", array]
    if hasattr(cells, "LowerThreshold"):
        cells.LowerThreshold, cells.UpperThreshold = low, high
    else:
        cells.ThresholdRange = [low, high]
    return cells


def middle_of(source):
    source.UpdatePipeline()
    low_high = source.GetDataInformation().GetBounds()
    return [0.5 * (low_high[axis] + low_high[axis + 1]) for axis in (0, 2, 4)]


def add_grains(path):
    grains = STLReader(FileNames=[path])
    RenameSource("grains, whole", grains)
    show(grains, visible=False, DiffuseColor=[0.82, 0.78, 0.70])
    cut = Clip(Input=grains)
    cut.ClipType = "Plane"
    cut.ClipType.Origin = middle_of(grains)
    cut.ClipType.Normal = [0.0, -1.0, 0.0]
    RenameSource("grains, cut open", cut)
    show(cut, DiffuseColor=[0.82, 0.78, 0.70])


def add_flow(path, direction):
    flow = XMLImageDataReader(FileName=[path])
    RenameSource("flow", flow)
    show(flow, visible=False).SetRepresentationType("Outline")
    pores = cells_with(flow, "phase", 1, 1)
    RenameSource("pores", pores)
    show(pores, visible=False)
    middle = middle_of(flow)
    for name, array, title, component, visible in (
        ("speed on the cut", "velocity_m_per_s", "speed, m/s", "Magnitude", True),
        ("pressure on the cut", "pressure_Pa", "pressure, Pa", "", False),
    ):
        cut = Slice(Input=pores)
        cut.SliceType = "Plane"
        cut.SliceType.Origin = middle
        cut.SliceType.Normal = [0.0, 1.0, 0.0]
        RenameSource(name, cut)
        colour_by(cut, array, "CELLS", title, component, visible)
    points = CellDatatoPointData(Input=flow)
    RenameSource("flow at points", points)
    show(points, visible=False).SetRepresentationType("Outline")
    bounds = flow.GetDataInformation().GetBounds()
    along = "xyz".index(direction)
    corner, first, second = ([bounds[0], bounds[2], bounds[4]] for _ in range(3))
    across = [axis for axis in range(3) if axis != along]
    for point in (corner, first, second):
        point[along] += 0.1 * (bounds[2 * along + 1] - bounds[2 * along])
    first[across[0]] = bounds[2 * across[0] + 1]
    second[across[1]] = bounds[2 * across[1] + 1]
    seeds = Plane(Origin=corner, Point1=first, Point2=second, XResolution=14, YResolution=14)
    RenameSource("where the streamlines start", seeds)
    show(seeds, visible=False)
    lines = StreamTracerWithCustomSource(Input=points, SeedSource=seeds)
    lines.Vectors = ["POINTS", "velocity_m_per_s"]
    lines.MaximumStreamlineLength = 5.0 * (bounds[2 * along + 1] - bounds[2 * along])
    RenameSource("streamlines", lines)
    colour_by(lines, "velocity_m_per_s", "POINTS", "speed, m/s", "Magnitude")


def add_section(low, high):
    flow = FindSource("flow")
    bounds = flow.GetDataInformation().GetBounds()
    box = Box(XLength=bounds[1] - bounds[0], YLength=bounds[3] - bounds[2], ZLength=high - low)
    box.Center = [0.5 * (bounds[0] + bounds[1]), 0.5 * (bounds[2] + bounds[3]), 0.5 * (low + high)]
    RenameSource("section", box)
    show(box, visible=False, AmbientColor=[0.0, 0.0, 0.0]).SetRepresentationType("Outline")


def add_paths(path, name):
    paths = XMLPolyDataReader(FileName=[path])
    RenameSource(name, paths)
    colour_by(paths, "tortuosity", "CELLS", "tortuosity of a path", visible=False)


def add_voxels(path):
    voxels = XMLImageDataReader(FileName=[path])
    RenameSource("voxels", voxels)
    show(voxels, visible=False).SetRepresentationType("Outline")
    solid = cells_with(voxels, "phase", 0, 0)
    RenameSource("voxels of grain", solid)
    show(solid, visible=False)


def add_foam(folder):
    """All times; the last one is shown. Its viscosity and pressure drop are 1: U and p have no unit."""
    reader = OpenFOAMReader(FileName=os.path.join(HERE, "foam", folder, "case.foam"))
    RenameSource("OpenFOAM, " + folder, reader)
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    if times:
        reader.UpdatePipeline(times[-1])
    show(reader, visible=False)


if path_of("stl", "solid.stl"):
    add_grains(path_of("stl", "solid.stl"))
if path_of("lbm", "flow.vti") and path_of("lbm", "result.json"):
    with open(path_of("lbm", "result.json")) as file:
        result = json.load(file)
    add_flow(path_of("lbm", "flow.vti"), result["direction"])
    add_section(*result["section_m"])
for file, name in (("paths_shortest.vtp", "shortest paths"), ("paths_geometric_paper.vtp", "paths of the paper's method")):
    if path_of("tortuosity", file):
        add_paths(path_of("tortuosity", file), name)
if path_of("voxelise", "pore.vti"):
    add_voxels(path_of("voxelise", "pore.vti"))
for folder in ("mesh_fine", "mesh_coarse", "mesh_coarsest"):
    if path_of("foam", folder, "case.foam"):
        add_foam(folder)

ResetCamera(view)
centre = view.CameraFocalPoint
distance = view.CameraParallelScale * 4.0
view.CameraPosition = [centre[0] + 0.3 * distance, centre[1] - distance, centre[2] + 0.25 * distance]
view.CameraViewUp = [0.0, 0.0, 1.0]
ResetCamera(view)
Render(view)
if len(sys.argv) > 1 and sys.argv[-1].endswith(".png"):
    SaveScreenshot(sys.argv[-1], view, ImageResolution=[1200, 1200])
