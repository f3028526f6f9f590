# script-version: 2.0
"""Every channel of every frame as a file that ParaView opens: points, domains, walls and the inspected RVEs as .vtp, the
grid as .vti, with a .series file for each that names them all with their times.

    tmdempm run SCENE.cfg --pipeline pipelines/extracts.py       writes SCENE.out/catalyst/*.vtp

To write less, let a filter stand between a channel and its file, in `what_to_write`.
"""
import json
import os
import sys

from paraview import catalyst
from vtkmodules.vtkIOXML import vtkXMLImageDataWriter, vtkXMLPolyDataWriter

sys.path.insert(0, os.path.dirname(os.path.abspath(catalyst.get_script_filename())))
from tmdempm_catalyst import producers
from tmdempm_view import data_of

options = catalyst.Options()

series = {}


def what_to_write(sources):
    """The ParaView sources to write, by the name of their files."""
    return sources


def write(data, name, step, time):
    """Under other names first: whoever looks sees whole files or none."""
    image = data.IsA("vtkImageData")
    ending = ".vti" if image else ".vtp"
    path = "%s_%08d%s" % (name, step, ending)
    writer = vtkXMLImageDataWriter() if image else vtkXMLPolyDataWriter()
    writer.SetFileName("." + path)
    writer.SetInputData(data)
    if not writer.Write():
        raise OSError("cannot write %s in %s" % (path, os.getcwd()))
    os.rename("." + path, path)
    files = series.setdefault(name + ending + ".series", [])
    files.append({"name": path, "time": time})
    with open("." + name + ".part", "w", encoding="utf-8") as stream:
        json.dump({"file-series-version": "1.0", "files": files}, stream, indent=1)
    os.rename("." + name + ".part", name + ending + ".series")


producers()  # a script shows ParaView its channels while it is read


def catalyst_execute(info):
    for name, source in what_to_write(producers()).items():
        source.UpdatePipeline(info.time)
        data = data_of(source)
        if data is not None:
            write(data, name, info.timestep, info.time)
