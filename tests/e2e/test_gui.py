# labels: gui
# timeout: 300
"""ParaView's window, on an Xvfb: it connects with --live, and draws a run with pipelines/live.py.  With PICTURES=FOLDER the
pictures stay there, for people to look at."""
import shutil
import signal
from live import *

needs_catalyst()
if not shutil.which("paraview") or not shutil.which("Xvfb"):
    skip("paraview or Xvfb is not installed")
SCENE = COLUMN.replace("end = 0.1", "end = 1000.0").replace("snapshot_every = 0.02", "snapshot_every = 0")


class Screen:
    """An Xvfb of a number that is free."""

    def __enter__(self):
        read, write = os.pipe()
        self.server = start(["Xvfb", "-displayfd", str(write), "-screen", "0", "1500x1000x24", "-nolisten", "tcp"],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as stream:
            self.environment = environment(DISPLAY=":" + stream.readline().strip())
        return self

    def __exit__(self, *unused):
        self.server.terminate()
        self.server.wait()


def window(screen, *options, **more):
    return start(["paraview", "-d"] + list(options), env=dict(screen.environment, **more), stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)


def with_window(f, screen, name, options, more, done):
    port = free_port()
    run = Simulation(f("s.cfg"), f(name), "--live", port)
    paraview = window(screen, *[str(o).replace("PORT", str(port)) for o in options], PORT=str(port), **more)
    try:
        run.wait_for("ParaView has connected", seconds=120)
        done(run)
    finally:
        paraview.kill()
        paraview.wait()
    run.wait_for("ParaView has gone")
    run.end(code=130, signal=signal.SIGTERM)


with Folder() as f, Screen() as screen:
    f.write("s.cfg", SCENE)
    with_window(f, screen, "plain", ("--live", "PORT"), {}, lambda run: wait(3))

    picture = f("window.png")

    def drawn(run):
        for _ in range(1200):
            if os.path.exists(picture) and os.path.exists(f("window_2.png")):
                return
            wait(0.05)
        sys.exit("FAILED: the window has drawn nothing")

    with_window(f, screen, "script", ("--script=" + os.path.join(PIPELINES, "live.py"),), {"IMAGE": picture, "FIELD": "velocity"}, drawn)
    expect(os.path.getsize(picture) > 5000, "the picture is empty")
    for name in os.listdir(f.path) if "PICTURES" in os.environ else []:
        if name.endswith(".png"):
            shutil.copy(f(name), os.environ["PICTURES"])
