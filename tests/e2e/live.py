"""What the tests of the live connection share."""
import shutil as sh
import socket
import threading
from e2e import *

PIPELINES = os.path.join(SOURCE_DIR, "pipelines")
HERE = os.path.dirname(os.path.abspath(__file__))


def needs_catalyst():
    """Skips the test where there is no ParaView to test with."""
    import json
    if not sh.which("pvpython"):
        skip("pvpython is not installed (python3-paraview)")
    sinks = {sink["name"]: sink for sink in json.loads(tmdempm("info", "--json").stdout)["sinks"]}
    if not sinks["catalyst"]["available"]:
        skip("no Catalyst: " + sinks["catalyst"]["install"])


def free_port():
    """The first of two free ports in a row: a live connection takes both."""
    for _ in range(200):
        with socket.socket() as one, socket.socket() as two:
            one.bind(("127.0.0.1", 0))
            try:
                two.bind(("127.0.0.1", one.getsockname()[1] + 1))
            except OSError:
                continue
            return one.getsockname()[1]
    skip("no free ports")


class Simulation:
    """A run in the background, whose terminal is kept."""

    def __init__(self, cfg, out, *options, threads=1):
        self.out, self.said = out, []
        self.process = start([TMDEMPM, "run", cfg, "--out", out, "--threads", str(threads)] + [str(o) for o in options],
                                        env=environment(), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        self.reader = threading.Thread(target=lambda: self.said.extend(self.process.stderr), daemon=True)
        self.reader.start()

    def text(self):
        return "".join(self.said)

    def wait_for(self, words, seconds=60, count=1):
        """Until the terminal has said this."""
        for _ in range(int(20 * seconds)):
            if self.text().count(words) >= count:
                return
            expect(self.process.poll() is None, "the run has ended:\n" + self.text())
            wait(0.05)
        sys.exit("FAILED: the run has not said \"%s\" in %g s:\n%s" % (words, seconds, self.text()))

    def end(self, code=None, signal=None, seconds=60):
        """Waits for its end (after a signal); nothing of it is left."""
        children = self.children()
        if signal:
            self.process.send_signal(signal)
        self.process.wait(timeout=seconds)
        self.reader.join(timeout=5)
        expect(code is None or self.process.returncode == code, "the run ended with %d:\n%s" % (self.process.returncode, self.text()))
        for _ in range(100):
            if not any(map(alive, children)):
                return
            wait(0.05)
        sys.exit("FAILED: processes of the run are left")

    def children(self, of=None):
        """Process ids of its viewers and their children."""
        of = of or self.process.pid
        try:
            with open("/proc/%d/task/%d/children" % (of, of), encoding="utf-8") as stream:
                found = [int(pid) for pid in stream.read().split()]
        except OSError:
            return []
        return found + [grandchild for child in found for grandchild in self.children(child)]

    def viewer(self):
        """The process id of its only viewer."""
        found = [pid for pid in self.children() if command_of(pid) == "tmdempm-viewer"]
        expect(len(found) == 1, "there are %d viewers" % len(found))
        return found[0]


def wait(seconds):
    import time
    time.sleep(seconds)


def command_of(pid):
    try:
        with open("/proc/%d/comm" % pid, encoding="utf-8") as stream:
            return stream.read().strip()
    except OSError:
        return ""


def alive(pid):
    try:
        with open("/proc/%d/stat" % pid, encoding="utf-8") as stream:
            return stream.read().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def resident(pid):
    """MiB."""
    with open("/proc/%d/status" % pid, encoding="utf-8") as stream:
        return sum(int(line.split()[1]) for line in stream if line.startswith("VmRSS")) / 1024.0


def pvpython(*arguments, seconds=100):
    return start(["pvpython"] + [str(a) for a in arguments], env=environment(), stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True)
