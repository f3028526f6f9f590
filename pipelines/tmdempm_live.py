"""A run with --live as a Python object, for pvpython and ParaView's Python shell.

    from tmdempm_live import Run
    run = Run(22222)                        # waits for the simulation, which connects to this port
    run.next()                              # waits for the next frame; returns its step
    points = run.data("points")             # a vtkDataSet of that step
    run.inspect("A", "hottest")             # or point=123, or at=(0.5, 1.2)
    run.pause(); run.step_on(10); run.go_on()
    run.checkpoint(); run.stop()
    run.image_interval("temperature", 0.05)

The simulation goes on whatever becomes of this program; only pause() stops it, and only as long as this program lives.
"""
import time as _time

from paraview import live, servermanager

STEERING = "Steering"  # the source of the simulation in whose text commands are written
LINES_KEPT = 50        # of that text


class Gone(Exception):
    """The simulation has ended, or nothing was heard of it in time."""


def listen_at(port):
    """ParaView's link, which a simulation may connect to."""
    return live.ConnectToCatalyst("localhost", port)


def listen(seconds=0.0):
    """Takes what simulations have sent."""
    end = _time.monotonic() + seconds
    while True:
        live.ProcessServerNotifications()
        if _time.monotonic() >= end:
            return
        _time.sleep(0.01)


class Run:
    def __init__(self, port=22222, timeout=None, link=None):
        self.link = link or listen_at(port)
        self._extracts, self._number, self._lines = {}, 0, []
        self._wait(lambda: self._insitu() is not None and self._insitu().GetProxy("sources", STEERING) is not None, timeout,
                   "no simulation has connected to port %d" % port)
        self._text = self._insitu().GetProxy("sources", STEERING).GetProperty("Text")
        self._help = self._text.GetElement(0)
        # commands of those who were here before are not to be given again
        for line in self._help.splitlines():
            number = line.split(" ")[0]
            self._number = max(self._number, int(number)) if number.isdigit() else self._number

    # ---- data ----

    def channels(self):
        """Names of the channels: points, domains, grid, walls, rve_NAME_discs, rve_NAME_contacts."""
        iterator = servermanager.vtkSMProxyIterator()
        iterator.SetSessionProxyManager(self._insitu())
        iterator.SetModeToOneGroup()
        iterator.Begin("sources")
        names = []
        while not iterator.IsAtEnd():
            if iterator.GetProxy().GetXMLName() == "PVTrivialProducer":
                names.append(iterator.GetKey())
            iterator.Next()
        return sorted(names)

    def source(self, channel):
        """ParaView's source that holds a channel here; it gets its data with the next frame."""
        if channel not in self._extracts:
            self._extracts[channel] = live.ExtractCatalystData(self.link, channel)
        return self._extracts[channel]

    def data(self, channel, timeout=60):
        """The channel as a vtkDataSet, as of the last frame; waits for the first one."""
        source = self.source(channel)
        found = []

        def fetch():
            source.SMProxy.MarkDirty(None)
            source.UpdatePipeline()
            data = servermanager.Fetch(source)
            found[:] = [data] if data is not None and data.IsA("vtkDataSet") and data.GetNumberOfPoints() else []
            return found
        self._wait(fetch, timeout, "no data of channel %s" % channel)
        return found[0]

    @property
    def step(self):
        """Step of the last frame."""
        return self.link.GetTimeStep()

    def next(self, timeout=60):
        """Waits for a frame of another step; returns the step."""
        before = self.step
        self._wait(lambda: self.step != before, timeout, "no frame after step %s" % before)
        return self.step

    # ---- steering ----

    def command(self, words):
        """Gives any command of `tmdempm steer`, such as "inspect.A=hottest".  It is followed at the next frame."""
        self._number += 1
        self._lines = (self._lines + ["%d %s" % (self._number, words)])[-LINES_KEPT:]
        self._text.SetElement(0, "\n".join([line for line in self._help.splitlines() if line.startswith("#")] + self._lines))
        self._insitu().GetProxy("sources", STEERING).UpdateVTKObjects()
        self.link.PushUpdatedStates()
        listen()

    def inspect(self, name, rule=None, point=None, at=None):
        """Inspects under this name the RVE of a point, of that nearest to a place, or by a rule: hottest, most_sheared,
        highest_pressure, most_broken."""
        where = "point:%d" % point if point is not None else "at:%.9g,%.9g" % tuple(at) if at is not None else rule
        self.command("inspect.%s=%s" % (name, where))

    def pause(self):
        live.PauseCatalyst(self.link, True)

    def go_on(self):
        live.PauseCatalyst(self.link, False)

    def step_on(self, steps=1):
        """So many steps of a run that is paused; it is paused again after them."""
        self.command("step=%d" % steps)

    def checkpoint(self):
        self.command("checkpoint=1")

    def stop(self):
        """The run saves its state and ends."""
        self.command("stop=1")

    def image_interval(self, name, seconds):
        """Another interval between the pictures `name` of the scene; 0 = no more."""
        self.command("images.%s.every=%.9g" % (name, seconds))

    # ----

    def _insitu(self):
        return self.link.GetInsituProxyManager()

    def _wait(self, reached, timeout, otherwise):
        end = _time.monotonic() + timeout if timeout is not None else float("inf")
        while not reached():
            if _time.monotonic() > end:
                raise Gone(otherwise)
            live.ProcessServerNotifications()
            _time.sleep(0.01)
