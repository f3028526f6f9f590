# script-version: 2.0
"""Pictures by ParaView: temperature, velocity and deviatoric strain of the scene, and the contact network of each
inspected RVE.

    tmdempm run SCENE.cfg --pipeline pipelines/images.py         writes SCENE.out/catalyst/*.png

FIELDS may be changed; `tmdempm info` lists what there is.
"""
import os
import sys

from paraview import catalyst
from paraview.simple import *

sys.path.insert(0, os.path.dirname(os.path.abspath(catalyst.get_script_filename())))
from tmdempm_catalyst import producers, rves
from tmdempm_view import *

FIELDS = ("temperature", "velocity", "strain_deviatoric")

options = catalyst.Options()
sources = producers()  # a script shows ParaView its channels while it is read


class Scene:
    """The domains coloured by one field, and the walls."""

    def __init__(self, field):
        self.field, self.view = field, make_view()
        self.text = heading(self.view, "")
        self.display = None

    def draw(self, sources, info):
        domains, data = sources["domains"], data_of(sources["domains"])
        if location_of(data, self.field) is None:
            return
        if self.display is None:
            self.display = show_field(self.view, domains, self.field)
            look_at(self.view, sources["grid"].GetDataInformation().GetBounds())
            if "walls" in sources:
                show_walls(self.view, sources["walls"])
        GetColorTransferFunction(self.field).RescaleTransferFunction(*range_of(data, self.field))
        self.text.Text = "t = %.4g s" % info.time
        save_view(self.view, "%s_%08d.png" % (self.field, info.timestep))


class Rve:
    """The discs behind one point and the forces between them."""

    def __init__(self, name, sources):
        self.name, self.view = name, make_view((900, 800))
        self.discs = sources["rve_%s_discs" % name]
        self.text = heading(self.view, "")
        show_discs(self.view, self.discs)
        self.network = Network(self.view, sources["rve_%s_contacts" % name])

    def draw(self, info):
        data = data_of(self.discs)
        if data is None:
            return
        look_at(self.view, bounds_of(self.discs, self.network.contacts))
        self.network.update(range_of(data, "radius")[1])
        self.text.Text = "RVE %s, t = %.4g s\n%s" % (self.name, info.time, note_of(data))
        save_view(self.view, "rve_%s_%08d.png" % (self.name, info.timestep))


scenes = [Scene(field) for field in FIELDS]
cells = {}


def catalyst_execute(info):
    sources = producers()
    for source in sources.values():
        source.UpdatePipeline(info.time)
    for scene in scenes:
        scene.draw(sources, info)
    for name in rves(sources):
        if name not in cells:
            cells[name] = Rve(name, sources)
        cells[name].draw(info)
