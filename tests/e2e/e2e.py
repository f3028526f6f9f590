"""What the end-to-end tests share: the program as a user has it, its folders and its files."""
import csv
import ctypes
import filecmp
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

TMDEMPM = os.environ["TMDEMPM"]
SOURCE_DIR = os.environ["SOURCE_DIR"]
SKIPPED = 77

# A warm elastic block that falls on a hot rough ground: heat, walls, probes, regions; a run takes a second.
BLOCK = """
title = "block";
units = { temperature = "C"; };
grid = { origin = [0.0, 0.0]; size = [1.0, 1.0]; cell = 0.1; };
time = { end = 0.2; step = 1e-4; };
mpm = { pic_fraction = 0.01; damping_particle = 0.1; };
thermal = { on = true; };
gravity = [0.0, -9.8];
materials = ( { name = "m"; density = 1000.0; heat_capacity = 100.0; conductivity = 1.0;
                law = { type = "thermoelastic"; young = 2.5e6; poisson = 0.25; expansion = 1e-5; }; } );
bodies = ( { name = "block"; material = "m"; box = [0.2, 0.1, 0.8, 0.6]; temperature = 20.0; } );
walls = ( { name = "ground"; line = ([0.0, 0.1], [1.0, 0.1]); friction = 0.5; temperature = 50.0; } );
probes = ( { name = "A"; material = [0.5, 0.3]; }, { name = "B"; at = [0.5, 0.2]; }, { name = "C"; id = 3; } );
regions = ( { name = "all"; box = [0.0, 0.0, 1.0, 1.0]; }, { name = "low"; box = [0.0, 0.0, 1.0, 0.3]; } );
"""

# A column of 16 RVEs of 64 discs that collapses: everything of an RVE scene, small enough for a test.
COLUMN = """
title = "column";
units = { temperature = "C"; };
grid = { origin = [0.0, 0.0]; size = [1.0, 0.5]; cell = 0.1; };
time = { end = 0.1; step = 1e-4; };
mpm = { pic_fraction = 0.05; damping_particle = 0.1; };
thermal = { on = true; };
gravity = [0.0, -9.8];
materials = ( { name = "sand"; heat_capacity = 670.0;
                law = { type = "rve"; packing = { discs = 64; pressure = 10e3; mu = 0.5; seed = 3; }; }; } );
bodies = ( { name = "column"; material = "sand"; box = [0.4, 0.1, 0.6, 0.3]; points_per_cell = 4; temperature = 20.0; } );
walls = ( { name = "ground"; line = ([0.0, 0.1], [1.0, 0.1]); friction = 0.5; } );
probes = ( { name = "A"; id = 5; } );
regions = ( { name = "all"; box = [0.0, 0.0, 1.0, 0.5]; } );
inspect = ( { name = "A"; id = 5; }, { name = "B"; at = [0.525, 0.225]; } );
output = { history_every = 0.001; snapshot_every = 0.02; checkpoint_every = 0.01; };
"""


class Folder:
    """A temporary folder that is gone at the end."""

    def __enter__(self):
        self.path = tempfile.mkdtemp(prefix="tmdempm-e2e-")
        return self

    def __exit__(self, *unused):
        shutil.rmtree(self.path)

    def __call__(self, *names):
        return os.path.join(self.path, *names)

    def write(self, name, text):
        with open(self(name), "w", encoding="utf-8") as stream:
            stream.write(text)
        return self(name)


def environment(**more):
    """One cache of packings for all tests, beside the build."""
    cache = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(TMDEMPM))), "test-cache")
    return dict(os.environ, XDG_CACHE_HOME=cache, **more)


def start(command, **options):
    """A process in the background that does not outlive the test, however that ends."""
    kernel, death_signal = ctypes.CDLL(None), 1  # PR_SET_PDEATHSIG
    return subprocess.Popen(command, preexec_fn=lambda: kernel.prctl(death_signal, signal.SIGKILL), **options)


def tmdempm(*arguments, code=0, threads=1, **options):
    """Runs the program; fails the test unless it ends with this exit code."""
    arguments = [str(a) for a in arguments]
    if arguments and arguments[0] == "run" and threads:
        arguments += ["--threads", str(threads)]
    done = subprocess.run([TMDEMPM] + arguments, capture_output=True, text=True, env=environment(), timeout=600, **options)
    expect(done.returncode == code, "tmdempm %s\nended with %d, expected %d\n%s\n%s"
           % (" ".join(arguments), done.returncode, code, done.stdout, done.stderr))
    return done


def expect(condition, message):
    if not condition:
        sys.exit("FAILED: " + message)


def skip(reason):
    print("SKIPPED: " + reason)
    sys.exit(SKIPPED)


def same_file(a, b, what):
    expect(filecmp.cmp(a, b, shallow=False), "%s differ: %s %s" % (what, a, b))


def history(folder):
    """history.csv as (names, rows of floats)."""
    with open(os.path.join(folder, "history.csv"), newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    return rows[0], [[float(cell) for cell in row] for row in rows[1:]]


def column(folder, name):
    names, rows = history(folder)
    expect(name in names, "no column `%s` in %s" % (name, names))
    return [row[names.index(name)] for row in rows]


def files_below(folder):
    return sorted(os.path.relpath(os.path.join(at, name), folder) for at, _, names in os.walk(folder) for name in names)


def processes(mark):
    """Numbers and names of the processes that run with this text in their environment: what a test has started, and
    what that has started."""
    found = {}
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open("/proc/%s/environ" % pid, "rb") as stream:
                ours = mark.encode() in stream.read()
            with open("/proc/%s/stat" % pid, encoding="utf-8", errors="replace") as stream:
                head, tail = stream.read().rsplit(")", 1)
        except OSError:
            continue
        if ours and tail.split()[0] not in "ZX":
            found[int(pid)] = head.split("(", 1)[1]
    return found


def all_gone(mark, what, seconds=10):
    """None of them is left soon."""
    end = time.monotonic() + seconds
    while processes(mark) and time.monotonic() < end:
        time.sleep(0.05)
    expect(not processes(mark), "%s: still there: %s" % (what, processes(mark)))
