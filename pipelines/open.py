"""Opens what a finished run has written, coloured: the scene, its walls, and the RVEs that were inspected.

    paraview --script=pipelines/open.py                 asks nothing: opens the newest *.out here (or what RUN names)
    RUN=out/silo.out FIELD=velocity paraview --script=pipelines/open.py
    pvpython pipelines/open.py out/silo.out [--field velocity] [--image picture.png] [--time 0.5]
"""
import argparse
import glob
import os
import re
import sys

from paraview.simple import *


def own_folder():
    """ParaView's window does not tell a script where it lies; its command line does."""
    if "__file__" in globals():
        return os.path.dirname(os.path.abspath(__file__))
    with open("/proc/self/cmdline", encoding="utf-8") as stream:
        found = re.search("\0--script[=\0]([^\0]+)", stream.read())
    return os.path.dirname(os.path.abspath(found.group(1))) if found else os.path.abspath("pipelines")


HERE = own_folder()
sys.path.insert(0, HERE)
from tmdempm_view import *


def choose_folder(asked):
    """A run's folder: the one asked for, or the newest here."""
    if asked:
        return asked.rstrip("/")
    found = [os.path.dirname(path) for pattern in ("domains.pvd", "*.out/domains.pvd", "out/*/domains.pvd")
             for path in glob.glob(pattern)]
    if not found:
        sys.exit("open.py: no run here: name its folder, as in RUN=out/silo.out")
    return max(found, key=lambda folder: os.path.getmtime(os.path.join(folder or ".", "domains.pvd"))) or "."


def open_series(folder, name):
    path = os.path.join(folder, name + ".pvd")
    return OpenDataFile(path, registrationName=name) if os.path.exists(path) else None


def show_run(folder, field, time):
    """Shows the scene in one view and each RVE in another beside it; returns the views."""
    domains = open_series(folder, "domains")
    if domains is None:
        sys.exit("open.py: %s holds no domains.pvd: is it the folder of a run, with output.vtk on?" % folder)
    times = list(domains.TimestepValues)
    time = times[-1] if time is None else min(times, key=lambda t: abs(t - time))
    domains.UpdatePipeline(time)
    data = data_of(domains)
    if field is None:
        field = next(f for f in ("temperature", "velocity", "displacement", "stress") if location_of(data, f))
    if location_of(data, field) is None:
        names = data.GetCellData()
        sys.exit("open.py: there is no field %s; there are %s"
                 % (field, ", ".join(names.GetArrayName(i) for i in range(names.GetNumberOfArrays()))))
    scene = make_view(view=GetActiveViewOrCreate("RenderView"))
    scene.ViewTime = time
    show_field(scene, domains, field)
    walls = open_series(folder, "walls")
    if walls is not None:
        show_walls(scene, walls)
    AnnotateTimeFilter(registrationName="time", Input=domains, Format="t = {time:.4g} s")
    clock = Show(GetActiveSource(), scene)
    clock.Color, clock.FontSize, clock.WindowLocation = BLACK, 14, "Upper Left Corner"
    look_at(scene, bounds_of(domains, walls) if walls is not None else bounds_of(domains))
    return [scene] + [show_rve(folder, name, time) for name in rves_of(folder)]


def rves_of(folder):
    return sorted(os.path.basename(path)[len("rve_"):-len("_discs.pvd")]
                  for path in glob.glob(os.path.join(folder, "rve_*_discs.pvd")))


def show_rve(folder, name, time):
    discs, contacts = open_series(folder, "rve_%s_discs" % name), open_series(folder, "rve_%s_contacts" % name)
    for source in (discs, contacts):
        source.UpdatePipeline(time)
    view = make_view((900, 800))
    view.ViewTime = time
    show_discs(view, discs)
    network = Network(view, contacts)
    network.update(range_of(data_of(discs), "radius")[1])
    heading(view, "RVE %s\n%s" % (name, note_of(data_of(discs))))
    look_at(view, bounds_of(discs, contacts))
    return view


def arguments():
    parser = argparse.ArgumentParser(prog="open.py")
    parser.add_argument("folder", nargs="?", default=os.environ.get("RUN"))
    parser.add_argument("--field", default=os.environ.get("FIELD"))
    parser.add_argument("--time", type=float)
    parser.add_argument("--image", help="writes the scene (and NAME_rve_A.png ...) and ends")
    # paraview --script leaves its own arguments here
    return parser.parse_args(sys.argv[1:] if os.path.basename(sys.argv[0]) == "open.py" else [])


wish = arguments()
folder = choose_folder(wish.folder)
views = show_run(folder, wish.field, wish.time)
if wish.image:
    stem, ending = os.path.splitext(wish.image)
    for view, name in zip(views, [""] + ["_rve_" + name for name in rves_of(folder)]):
        SaveScreenshot(stem + name + ending, view, ImageResolution=list(view.ViewSize))
else:
    for view in views:
        AssignViewToLayout(view)
    SetActiveView(views[0])
    RenderAllViews()
