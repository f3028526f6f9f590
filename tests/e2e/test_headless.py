# timeout: 120
"""Pictures without a screen, and nothing left behind: no viewer and no Xvfb outlives a run that ends, is killed, or whose
viewer is killed or crashes."""
import signal
import uuid
from e2e import *

IMAGES = """
images = ( { name = "cell"; kind = "rve"; rve = "A"; field = "rotation"; map = "coolwarm"; size = [200, 160]; every = 0.005; } );
"""
N = 21  # pictures of a whole run


class Run:
    """A run in the background, on a machine without a screen (or with `display`), and what it has started."""

    def __init__(self, f, cfg, name, display=None):
        self.mark = "TMDEMPM_TEST=%s" % uuid.uuid4()
        env = environment(TMDEMPM_TEST=self.mark.split("=")[1])
        env.pop("DISPLAY", None)
        if display:
            env["DISPLAY"] = display
        self.out = f(name)
        self.process = start([TMDEMPM, "run", cfg, "--out", self.out, "--threads", "1", "--quiet"], env=env,
                                        stderr=subprocess.PIPE, text=True)

    def find(self, name):
        """The number of its process of this name, as soon as it is there."""
        for _ in range(600):
            for pid, found in processes(self.mark).items():
                if found == name:
                    return pid
            time.sleep(0.05)
        sys.exit("FAILED: no %s of %s: %s" % (name, self.out, processes(self.mark)))

    def wait_for_pictures(self, n):
        for _ in range(600):
            if len(self.pictures()) >= n:
                return
            time.sleep(0.05)
        sys.exit("FAILED: no %d pictures in %s" % (n, self.out))

    def pictures(self):
        folder = os.path.join(self.out, "images")
        return [name for name in os.listdir(folder) if name.endswith(".png")] if os.path.isdir(folder) else []

    def end(self, code):
        said = self.process.communicate(timeout=100)[1]
        expect(self.process.returncode == code, "%s ended with %d: %s" % (self.out, self.process.returncode, said))
        all_gone(self.mark, self.out)
        return said


def whole(f, cfg):
    """No DISPLAY, and one that is dead: all pictures, of the same pixels, and nothing is left."""
    first, second = Run(f, cfg, "none"), Run(f, cfg, "dead", display=":987")
    xvfb = first.find("Xvfb")
    for run in (first, second):
        run.end(0)
        expect(len(run.pictures()) == N, "%d pictures" % len(run.pictures()))
        with open(os.path.join(run.out, "log.txt"), encoding="utf-8") as stream:
            expect("an Xvfb of our own" in stream.read(), "the log does not tell of the Xvfb")
    for name in first.pictures():
        same_file(os.path.join(first.out, "images", name), os.path.join(second.out, "images", name), name)
    for at in ("/tmp/.X11-unix", "/tmp"):  # its sockets and locks are gone too
        expect(not any(str(xvfb) == open_lock(os.path.join(at, name)) for name in os.listdir(at)), "a lock of the Xvfb is left")


def open_lock(path):
    if not (os.path.basename(path).startswith(".X") and path.endswith("-lock")):
        return ""
    try:
        with open(path, encoding="ascii", errors="replace") as stream:
            return stream.read().strip()
    except OSError:
        return ""


def engine_dies(f, cfg, number):
    run = Run(f, cfg, "engine%d" % number)
    run.wait_for_pictures(2)
    expect({"tmdempm-viewer", "Xvfb"} <= set(name[:14] for name in processes(run.mark).values()), str(processes(run.mark)))
    os.kill(run.process.pid, number)
    run.end(130 if number == signal.SIGTERM else -number)


def viewer_dies(f, cfg, number):
    """The run goes on with another viewer and all pictures."""
    run = Run(f, cfg, "viewer%d" % number)
    run.wait_for_pictures(2)
    os.kill(run.find("tmdempm-viewer"), number)
    said = run.end(0)
    expect(len(run.pictures()) == N, "%d pictures after signal %d: %s" % (len(run.pictures()), number, said))
    expect("signal %d" % number in said, said)


def xvfb_dies(f, cfg):
    """So does the viewer then, and the run goes on."""
    run = Run(f, cfg, "xvfb")
    run.wait_for_pictures(2)
    os.kill(run.find("Xvfb"), signal.SIGKILL)
    run.end(0)
    expect(len(run.pictures()) == N, "%d pictures" % len(run.pictures()))


with Folder() as f:
    cfg = f.write("s.cfg", COLUMN + IMAGES)
    os.environ.pop("DISPLAY", None)
    if subprocess.run([TMDEMPM, "doctor", "viewer", "images"], env=environment(), stdout=subprocess.PIPE, text=True,
                      check=False).stdout.count(" works ") != 2:
        skip("no viewer, or no Xvfb")
    whole(f, cfg)
    for number in (signal.SIGKILL, signal.SIGSEGV, signal.SIGTERM):
        engine_dies(f, cfg, number)
    for number in (signal.SIGKILL, signal.SIGSEGV):
        viewer_dies(f, cfg, number)
    xvfb_dies(f, cfg)
