# script-version: 2.0
"""A Cinema database (specification D): pictures of several fields, and data.csv, the table by which Cinema's viewers
browse them.  ParaView's own writer of that table needs pandas; this one needs nothing.

    tmdempm run SCENE.cfg --pipeline pipelines/cinema.py         writes SCENE.out/catalyst/cinema.cdb/
"""
import os
import sys

from paraview import catalyst
from paraview.simple import *

sys.path.insert(0, os.path.dirname(os.path.abspath(catalyst.get_script_filename())))
from tmdempm_catalyst import producers
from tmdempm_view import *

FIELDS = ("temperature", "velocity", "strain_deviatoric")
FOLDER = "cinema.cdb"

options = catalyst.Options()
views, rows = {}, []


def view_of(sources, field):
    """The view of a field; None if there is no such field."""
    if field not in views:
        view = make_view()
        views[field] = view if show_field(view, sources["domains"], field) else None
        if views[field] and "walls" in sources:
            show_walls(view, sources["walls"])
        look_at(view, bounds_of(sources["grid"]))
    return views[field]


def write_table():
    with open(os.path.join(FOLDER, ".data.csv"), "w", encoding="utf-8") as stream:
        stream.write("time,step,field,FILE\n" + "".join("%.9g,%d,%s,%s\n" % row for row in rows))
    os.replace(os.path.join(FOLDER, ".data.csv"), os.path.join(FOLDER, "data.csv"))


def catalyst_execute(info):
    sources = producers()
    os.makedirs(FOLDER, exist_ok=True)
    for source in sources.values():
        source.UpdatePipeline(info.time)
    for field in FIELDS:
        view = view_of(sources, field)
        if view is None:
            continue
        GetColorTransferFunction(field).RescaleTransferFunction(*range_of(data_of(sources["domains"]), field))
        name = "%s_%08d.png" % (field, info.timestep)
        save_view(view, os.path.join(FOLDER, name))
        rows.append((info.time, info.timestep, field, name))
    write_table()


producers()  # a script shows ParaView its channels while it is read
