"""Watches a run with --live, coloured at once: the scene, and the contact network of each inspected RVE.

    paraview --script=pipelines/live.py                       listens at port 22222; PORT=..., FIELD=... say otherwise
    pvpython pipelines/live.py --image now.png [--port P] [--field velocity] [--frames N] [--command inspect.A=hottest]

In ParaView's window: Catalyst > Pause and Continue; commands are written into the text of the simulation's source
`Steering` (Properties panel).  In the Python shell `watcher.run` is a Run of tmdempm_live.py.
"""
import argparse
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


sys.path.insert(0, own_folder())
import tmdempm_live
from tmdempm_view import *


class Watcher:
    """Shows every frame that comes."""

    def __init__(self, port, field, drawn=None):
        self.field, self.drawn, self.frames = field, drawn, 0
        self.run, self.views, self.networks = None, [], {}
        self.scene = make_view(view=GetActiveViewOrCreate("RenderView"))
        self.text = heading(self.scene, "waits for a simulation at port %d" % port)
        AssignViewToLayout(self.scene)
        self.link = tmdempm_live.listen_at(port)
        self.link.AddObserver("ConnectionCreatedEvent", lambda *unused: self.come())
        self.link.AddObserver("UpdateEvent", lambda *unused: self.draw())

    def listen_in_window(self):
        """ParaView's window has a loop of its own, which calls us now and then."""
        Render(self.scene)
        interactor = self.scene.GetInteractor()
        interactor.AddObserver("TimerEvent", lambda *unused: tmdempm_live.listen())
        interactor.CreateRepeatingTimer(50)

    def come(self):
        """A simulation has connected."""
        self.run = tmdempm_live.Run(link=self.link, timeout=10)
        for channel in self.run.channels():
            self.run.source(channel)

    def draw(self):
        """A frame has come."""
        if self.run is None:
            return
        for channel in self.run.channels():  # an RVE may be new
            self.run.source(channel).SMProxy.MarkDirty(None)
            self.run.source(channel).UpdatePipeline()
        data = data_of(self.run.source("domains"))
        if data is None:
            return
        if not self.views:
            self.show_scene(data)
        GetColorTransferFunction(self.field).RescaleTransferFunction(*range_of(data, self.field))
        self.text.Text = "t = %.4g s, step %d" % (data.GetFieldData().GetArray("time").GetValue(0), self.run.step)
        self.draw_cells()
        for view in self.views:
            Render(view)
        self.frames += 1
        if self.drawn:
            self.drawn(self)

    def show_scene(self, data):
        view = self.scene
        self.views.append(view)
        if location_of(data, self.field) is None:
            self.field = "velocity"
        show_field(view, self.run.source("domains"), self.field)
        if "walls" in self.run.channels():
            show_walls(view, self.run.source("walls"))
        look_at(view, data_of(self.run.source("grid")).GetBounds())

    def draw_cells(self):
        for channel in self.run.channels():
            discs = self.run.source(channel)
            name = channel[len("rve_"):-len("_discs")]
            if not (channel.startswith("rve_") and channel.endswith("_discs")) or data_of(discs) is None:
                continue
            contacts = self.run.source("rve_%s_contacts" % name)
            if name not in self.networks:
                if data_of(contacts) is None:
                    continue
                view = make_view((900, 800))
                self.views.append(view)
                show_discs(view, discs)
                self.networks[name] = Network(view, contacts), heading(view, "")
                AssignViewToLayout(view)
            network, text = self.networks[name]
            network.update(range_of(data_of(discs), "radius")[1])
            text.Text = "RVE %s\n%s" % (name, note_of(data_of(discs)))
            look_at(network.view, bounds_of(discs, contacts))


def arguments():
    parser = argparse.ArgumentParser(prog="live.py")
    parser.add_argument("--port", type=int, default=int(os.environ.get("PORT", 22222)))
    parser.add_argument("--field", default=os.environ.get("FIELD", "temperature"))
    parser.add_argument("--image", default=os.environ.get("IMAGE"), help="rewrites this picture (and NAME_1.png ... of the RVEs) with each frame")
    parser.add_argument("--frames", type=int, default=0, help="ends after so many")
    parser.add_argument("--command", action="append", default=[], help="given to the run when its first frame has come")
    # paraview --script leaves its own arguments here
    return parser.parse_args(sys.argv[1:] if os.path.basename(sys.argv[0]) == "live.py" else [])


def save(watcher):
    stem, ending = os.path.splitext(wish.image)
    for k, view in enumerate(watcher.views):
        save_view(view, stem + ("_%d" % k if k else "") + ending)


wish = arguments()
watcher = Watcher(wish.port, wish.field, save if wish.image else None)
if os.path.basename(sys.argv[0]) != "live.py":
    watcher.listen_in_window()
else:
    while not wish.frames or watcher.frames < wish.frames:
        tmdempm_live.listen(0.05)
        while watcher.frames and wish.command:
            watcher.run.command(wish.command.pop(0))
    sys.stdout.flush()
    os._exit(0)  # ParaView's own end waits for a simulation that does not end
