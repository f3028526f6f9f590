"""How a run looks in ParaView: what images.py, live.py and open.py share.

Every function takes ParaView's sources as they come: channels of a running simulation, extracts of a live connection, or
readers of a finished run's .pvd files.
"""
import math
import os

from paraview import servermanager
from paraview.simple import *

# Colours of fields that have a customary one; others get the first.
MAPS = {"": "Viridis (matplotlib)", "temperature": "Inferno (matplotlib)", "temperature_smooth": "Inferno (matplotlib)",
        "heat_friction": "Inferno (matplotlib)", "strain_deviatoric": "Plasma (matplotlib)"}
BLACK, GREY = [0.0, 0.0, 0.0], [0.35, 0.35, 0.37]


def data_of(source):
    """The data set behind a source, the first block of several; None if there is none yet."""
    data = servermanager.Fetch(source)
    while data is not None and data.IsA("vtkCompositeDataSet"):
        data = data.GetBlock(0) if data.GetNumberOfBlocks() else None
    return data if data is not None and data.IsA("vtkDataSet") and data.GetNumberOfPoints() else None


def unit_of(data, field):
    """The unit that the simulation gives with a field, or ""."""
    units = data.GetFieldData().GetAbstractArray("units") if data is not None else None
    for i in range(units.GetNumberOfValues() if units else 0):
        name, _, unit = units.GetValue(i).partition("=")
        if name == field:
            return "" if unit == "-" else unit
    return ""


def location_of(data, field):
    """"CELLS" or "POINTS", wherever the field is; None."""
    if data is not None and data.GetCellData().HasArray(field):
        return "CELLS"
    return "POINTS" if data is not None and data.GetPointData().HasArray(field) else None


def range_of(data, field):
    """Lowest and highest value (of vectors and tensors their magnitude), of numbers only; never empty."""
    array = (data.GetCellData() if location_of(data, field) == "CELLS" else data.GetPointData()).GetArray(field)
    low, high = array.GetFiniteRange(-1 if array.GetNumberOfComponents() > 1 else 0)
    if not low <= high:
        low, high = 0.0, 0.0
    return (low, high) if high > low else (low, low + max(1e-12, 1e-6 * abs(low)))


def bounds_of(*sources):
    """What holds all of these."""
    boxes = [data.GetBounds() for data in map(data_of, sources) if data is not None]
    return [(max if i % 2 else min)(box[i] for box in boxes) for i in range(6)] if boxes else [0, 1, 0, 1, 0, 0]


def make_view(size=(1100, 850), view=None):
    """A white sheet that looks straight at the plane; of a view that is there, or a new one."""
    view = view or CreateView("RenderView")
    view.ViewSize = list(size)
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.OrientationAxesVisibility = 0
    view.CameraParallelProjection = 1
    view.InteractionMode = "2D"
    return view


def look_at(view, bounds):
    """The whole of [xmin, xmax, ymin, ymax, ...], with room for the colour bar on the right and the heading above."""
    width, height = bounds[1] - bounds[0], bounds[3] - bounds[2]
    across, up = view.ViewSize[0], view.ViewSize[1]
    scale = max(0.5 * height / 0.84, 0.5 * width / 0.76 * up / across)
    x, y = 0.5 * (bounds[0] + bounds[1]) + 0.1 * 2 * scale * across / up, 0.5 * (bounds[2] + bounds[3]) + 0.04 * 2 * scale
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [x, y, 10.0], [x, y, 0.0], [0.0, 1.0, 0.0]
    view.CameraParallelScale = scale


def save_view(view, path):
    """Under another name first: whoever looks sees a whole picture or none."""
    folder, name = os.path.split(path)
    Render(view)
    SaveScreenshot(os.path.join(folder, "." + name), view, ImageResolution=list(view.ViewSize))
    os.replace(os.path.join(folder, "." + name), path)


def digits_for(low, high):
    """How many digits tell the labels of a bar apart."""
    largest, span = max(abs(low), abs(high)), high - low
    return max(4, min(15, math.ceil(math.log10(largest / span)) + 3)) if span > 0 else 6


def colour(view, display, data, field, preset=None, title=None, limits=None, separate=False):
    """Colours by a field, with a bar; limits = the field's own; separate = not those of other views.  Returns the colours."""
    ColorBy(display, (location_of(data, field), field), separate)
    table = GetColorTransferFunction(field, display, separate=separate)
    table.ApplyPreset(preset or MAPS.get(field, MAPS[""]), True)
    low, high = limits or range_of(data, field)
    table.RescaleTransferFunction(low, high)
    table.NanColor, table.NanOpacity = [0.8, 0.8, 0.8], 1.0
    bar, unit = GetScalarBar(table, view), unit_of(data, field)
    bar.Title, bar.ComponentTitle = (title or field.replace("_", " ")) + (" [%s]" % unit if unit else ""), ""
    bar.TitleColor, bar.LabelColor = BLACK, BLACK
    bar.TitleFontSize, bar.LabelFontSize = 15, 13
    digits = "%%.%dg" % digits_for(low, high)
    bar.AutomaticLabelFormat, bar.LabelFormat, bar.RangeLabelFormat = 0, digits, digits
    bar.WindowLocation, bar.ScalarBarLength = "Lower Right Corner", 0.55 # placed whole, however narrow the window
    bar.Visibility = 1
    display.SetScalarBarVisibility(view, True)
    return table


def heading(view, words, place="Upper Left Corner"):
    """A line of text; returns the source, whose Text may change."""
    text = Text(Text=words)
    display = Show(text, view, "TextSourceRepresentation")
    display.Color, display.FontSize, display.WindowLocation = BLACK, 14, place
    return text


def show_field(view, domains, field, limits=None):
    """The domains of the points, coloured by a field; None if the field is not there."""
    data = data_of(domains)
    if location_of(data, field) is None:
        return None
    display = Show(domains, view)
    display.Representation = "Surface"
    display.Ambient, display.Diffuse = 1.0, 0.0
    colour(view, display, data, field, limits=limits)
    return display


def show_walls(view, walls):
    display = Show(walls, view)
    display.Representation = "Wireframe"
    display.ColorArrayName = ["POINTS", ""]
    display.AmbientColor = display.DiffuseColor = GREY
    display.LineWidth = 3.0
    return display


def show_discs(view, discs, field=None):
    """The discs of an RVE in their size; coloured by a field, or plain."""
    display = Show(discs, view)
    display.Representation = "Point Gaussian"
    display.ShaderPreset = "Plain circle"
    display.ScaleByArray, display.UseScaleFunction, display.GaussianRadius = 1, 0, 1.0
    display.SetScaleArray = ["POINTS", "radius"]
    data = data_of(discs)
    if field and location_of(data, field):
        colour(view, display, data, field)
    else:
        display.ColorArrayName = ["POINTS", ""]
        display.AmbientColor = display.DiffuseColor = [0.87, 0.87, 0.90]
    return display


class Network:
    """The force chains of an RVE: bands as wide as their normal force, tension told from compression."""

    def __init__(self, view, contacts):
        # each contact has two points of its own, so that this changes no value
        points = CellDatatoPointData(Input=contacts, ProcessAllArrays=1)
        self.contacts = contacts
        self.width = Calculator(Input=points, AttributeType="Point Data", ResultArrayName="width", Function="abs(normal_force)")
        self.tubes = Tube(Input=self.width, NumberofSides=6, VaryRadius="By Absolute Scalar", Scalars=["POINTS", "width"])
        self.view = view
        self.display = Show(self.tubes, view)
        self.display.Ambient, self.display.Diffuse = 1.0, 0.0

    def update(self, radius):
        """Widths and colours for the data as it is: the strongest contact is as wide as a disc of this radius."""
        data = data_of(self.contacts)
        if data is None:
            return
        low, high = range_of(data, "normal_force")
        strongest = max(abs(low), abs(high)) or 1.0
        self.width.Function = "%.9g*abs(normal_force)" % (0.5 * radius / strongest)
        self.tubes.UpdatePipeline()
        # without tension: from weak to strong; with it: blue compression, red tension, nothing at white
        if low < -1e-9 * strongest:
            colour(self.view, self.display, data_of(self.tubes), "normal_force", "Cool to Warm (Extended)", "normal force",
                   (-strongest, strongest), separate=True).InvertTransferFunction()
        else:
            colour(self.view, self.display, data_of(self.tubes), "normal_force", "Black-Body Radiation", "normal force",
                   (0.0, 1.4 * strongest), separate=True)


def note_of(data):
    """What the simulation says of an RVE: pressure, void ratio ..."""
    note = data.GetFieldData().GetAbstractArray("note") if data is not None else None
    return note.GetValue(0) if note else ""
