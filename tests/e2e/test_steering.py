# timeout: 180
"""A run is steered through `tmdempm steer`: it stops where it is told, goes on, saves, ends; what is inspected changes; the
physics does not; and the log of it repeats the run, file by file."""
import atexit
import signal
import socket
import stat
import time
from e2e import *

SCENE = ["--set", "output.history_every=1e-4", "--set", "time.end=0.04"]
OF_THE_MOMENT = {"run.json", "log.txt", "steering.csv"}


class Run:
    """A run that waits before its first step."""

    def __init__(self, cfg, out, *options):
        self.out = out
        self.process = start([TMDEMPM, "run", cfg, "--threads", "1", "--quiet", *map(str, options), "--paused"]
                                        + ([] if "--restart" in options else ["--out", out]), env=environment(),
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        atexit.register(self.process.kill)  # a test that fails leaves nothing that waits
        wait(lambda: self.process.poll() is not None or subprocess.run([TMDEMPM, "steer", out], capture_output=True).returncode == 0)
        if self.process.poll() is not None:
            sys.exit("FAILED: the run has ended: %s" % (self.process.communicate(),))

    def steer(self, *commands, code=0):
        done = tmdempm("steer", self.out, *commands, code=code)
        return done.stderr if code else done.stdout

    def state(self):
        return [line.split(None, 1) for line in self.steer().splitlines()]

    def step(self):
        return int(dict(self.state())["step"].split()[0])

    def ends(self, code):
        said = self.process.communicate(timeout=60)[1]
        expect(self.process.returncode == code, "the run ended with %d, expected %d: %s" % (self.process.returncode, code, said))
        expect(not os.path.exists(os.path.join(self.out, "steering.socket")), "the socket has outlived the run")
        return said


def wait(condition):
    for _ in range(600):
        if condition():
            return
        time.sleep(0.05)
    sys.exit("FAILED: waited for 30 s")


def same_runs(a, b, what, without=()):
    names = [n for n in files_below(a) if n not in OF_THE_MOMENT and not n.startswith(tuple(without))]
    others = [n for n in files_below(b) if n not in OF_THE_MOMENT and not n.startswith(tuple(without))]
    expect(names == others and len(names) > 20, "%s: other files: %s" % (what, set(names) ^ set(others)))
    for name in names:
        same_file(os.path.join(a, name), os.path.join(b, name), what)


def bits(path):
    return [line for line in tmdempm("rve", "info", path).stdout.splitlines() if line.startswith("bits")][0].split()[1]


def cpu(pid):
    with open("/proc/%d/stat" % pid, encoding="ascii") as stream:
        return sum(int(ticks) for ticks in stream.read().rsplit(")", 1)[1].split()[11:13])


def paused(f, cfg):
    """It stands still, at no cost, until it is told; steps are counted exactly; signals are heard."""
    run = Run(cfg, f("paused"), *SCENE)
    rows, before = len(history(run.out)[1]), cpu(run.process.pid)
    expect(dict(run.state())["state"] == "paused by --paused", str(run.state()))
    time.sleep(0.5)
    expect(run.step() == 0 and len(history(run.out)[1]) == rows, "it has moved")
    expect(cpu(run.process.pid) - before <= 2, "it has worked while it was paused")
    expect(run.steer("step=3") == "paused at step 3, time 0.0003 s\n", "step=3")
    expect(run.step() == 3 and len(history(run.out)[1]) == rows + 3, "not three steps")
    run.steer("step=1", "step=40")
    expect(run.step() == 44 and len(history(run.out)[1]) == rows + 44, "not 44 steps")
    # SIGUSR1 saves also now, SIGTERM ends it
    checkpoint = os.path.join(run.out, "checkpoint.h5")
    expect(not os.path.exists(checkpoint), "there is a checkpoint already")
    run.process.send_signal(signal.SIGUSR1)
    wait(lambda: os.path.exists(checkpoint))
    run.process.send_signal(signal.SIGTERM)
    expect("interrupted at step 44" in run.ends(130), "SIGTERM")


def refused(f, cfg):
    """What is wrong is said, does nothing, and is not in the log; who may not come is kept out."""
    run = Run(cfg, f("refused"), *SCENE)
    for command, words in (("faster=1", "one of pause="), ("inspect.A=coldest", "hottest"), ("inspect.A=point:99", "0 to 15"),
                           ("inspect.Z=none", "no RVE is inspected as"), ("images.warm.every=1", "no picture"), ("step=0", "at least 1"),
                           ("pause", "NAME=VALUE"), ("pause=1\nstop=1", "control characters")):
        said = run.steer(command, code=2)
        expect(words in said, "%s: %s" % (command, said))
    # none of several is done if one is nonsense
    run.steer("step=5", "nonsense", code=2)
    with open(os.path.join(run.out, "steering.csv"), encoding="utf-8") as stream:
        expect(run.step() == 0 and len(stream.readlines()) == 2, "a refused command was done, or is in the log")  # header, --paused
    expect(stat.S_IMODE(os.stat(os.path.join(run.out, "steering.socket")).st_mode) == 0o600, "others may connect")
    if os.geteuid() == 0:
        os.chmod(f.path, 0o755)
        program = shutil.copy(TMDEMPM, f("tmdempm"))  # another user may not reach the one that is tested
        other = subprocess.run([program, "steer", run.out], capture_output=True, text=True, user=65534)
        expect(other.returncode == 4 and "another user" in other.stderr, str(other))
    # a client that talks without end is dropped, and the run does not care
    with socket.socket(socket.AF_UNIX) as talker:
        os.chdir(run.out)
        talker.connect("steering.socket")
        os.chdir("/")
        try:
            talker.sendall(b"x" * 100000)
        except BrokenPipeError:
            pass
    with start([TMDEMPM, "steer", run.out, "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True) as client:
        said, why = client.communicate("nonsense\nstep=2\nstate\n\nstop=1\n")
    lines = said.splitlines()
    expect(lines[0].startswith("error 2 ") and lines[1] == "ok paused at step 2, time 0.0002 s" and lines[-1].startswith("ok stops"), said)
    expect(client.returncode == 2 and "nonsense" in why, why)
    run.ends(130)
    expect("no run is working" in tmdempm("steer", run.out, code=4).stderr, "no run")
    expect("folder of a run" in tmdempm("steer", f("nowhere"), code=2).stderr, "no folder")


def held(f, cfg):
    """A client that holds the run and is killed lets it go on; its step's answer is nobody's."""
    out = f("a" * 60, "b" * 60, "held")  # longer than a socket's address
    os.makedirs(os.path.dirname(out))
    run = Run(cfg, out, *SCENE)
    with start([TMDEMPM, "steer", out, "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as client:
        client.stdin.write("pause=0\npause=hold\nstate\n")
        client.stdin.flush()
        while not client.stdout.readline().startswith("inspect    B"):
            pass
        there = run.step()
        time.sleep(0.2)
        expect(run.step() == there < 400, "it is not paused")
        client.kill()
    run.ends(0)


def steered(f, cfg):
    """A whole session, its effects, and its repetition."""
    run = Run(cfg, f("live"), *SCENE)
    run.steer("step=10", "inspect.C=at:0.55,0.2", "inspect.hot=hottest")
    point = int(dict(line[1].split("=") for line in run.state() if line[0] == "inspect")["C"].split(":")[1])
    expect(point not in (5, 10), "C is one of those that the scene inspects")
    run.steer("step=190", "checkpoint=1", "step=50", "inspect.A=point:0", "inspect.B=none")
    names = [line[1].split("=")[0] for line in run.state() if line[0] == "inspect"]
    expect(names == ["A", "C", "hot"], str(names))
    run.steer("pause=0")
    run.ends(0)
    # in the next snapshot and frame
    for step, there in ((200, "AB"), (400, "A")):
        snapshot = os.path.join(run.out, "snap", "%08d.h5" % step)
        for name, number in (("A", 5 if step == 200 else 0), ("C", point)):
            said = tmdempm("rve", "show", snapshot, "--name", name).stdout
            expect("\npoint          %d " % number in said, said)
        hot = [tmdempm("rve", "show", snapshot, *which).stdout.split("\npoint")[1].split()[0] for which in (("--name", "hot"), ("--rule", "hottest"))]
        expect(hot[0] == hot[1], "hot is %s, the hottest is %s" % tuple(hot))
        expect(os.path.exists(os.path.join(run.out, "vtk", "rve_B_discs_%08d.vtp" % step)) == ("B" in there), "B at %d" % step)
        expect(os.path.exists(os.path.join(run.out, "vtk", "rve_hot_contacts_%08d.vtp" % step)), "hot at %d" % step)
    expect(not os.path.exists(os.path.join(run.out, "vtk", "rve_C_discs_00000000.vtp")), "C before it was asked for")
    # whoever is inspected from mid-run on can be driven from there, to the bits of the end
    rve = lambda name: os.path.join(run.out, "rve", name)
    expect(sorted(os.listdir(rve(""))) == ["A_00000250.h5", "A_00000250_path.csv", "A_path.csv", "B_path.csv", "C_00000010.h5",
                                           "C_00000010_path.csv"], str(os.listdir(rve(""))))
    for name, number in (("C_00000010", point), ("A_00000250", 0)):
        tmdempm("rve", "load", "--packing", rve(name + ".h5"), "--load", "path", "--path", rve(name + "_path.csv"), "--out",
                f("curve.csv"), "--save", f("end.h5"))
        tmdempm("rve", "extract", run.out, "--point", number, "--out", f("taken.h5"))
        expect(bits(f("end.h5")) == bits(f("taken.h5")) != bits(rve(name + ".h5")), name)
    said = tmdempm("rve", "extract", run.out, "--name", "C", "--time", 0.02, "--out", f("taken.h5")).stdout
    expect("C_00000010_path.csv --skip 190" in said, said)
    with open(os.path.join(run.out, "log.txt"), encoding="utf-8") as stream:
        expect("steering: steer: inspect.C=point:%d: C is point:%d" % (point, point) in stream.read(), "log.txt")
    # the same again, from the log
    tmdempm("run", cfg, "--out", f("again"), "--steering", os.path.join(run.out, "steering.csv"), *SCENE)
    same_runs(run.out, f("again"), "repeated")
    tmdempm("run", cfg, "--out", f("twice"), "--steering", f("again", "steering.csv"), *SCENE)
    same_file(f("again", "steering.csv"), f("twice", "steering.csv"), "logs of repetitions")
    # and none of it has touched the physics
    tmdempm("run", cfg, "--out", f("plain"), *SCENE)
    for name in ("checkpoint.h5", "history.csv"):
        same_file(os.path.join(run.out, name), f("plain", name), "steering changed the physics")
    expect(not os.path.exists(f("plain", "steering.csv")), "a log of nothing")
    broken = f.write("broken.csv", "time,step,source,command\n0,1,me,inspect.A=coldest\n")
    expect("broken.csv:2: " in tmdempm("run", cfg, "--out", f("no"), "--steering", broken, *SCENE, code=2).stderr, "broken.csv")
    expect(not os.path.exists(f("no")), "a refused run has written")


def continued(f, cfg):
    """Stopped, killed while paused, restarted each time: the files are those of the run in one piece."""
    run = Run(cfg, f("pieces"), *SCENE)
    run.steer("step=30", "inspect.C=at:0.55,0.2", "inspect.hot=most_sheared", "step=90")
    run.steer("stop=1")
    said = run.ends(130)
    expect("interrupted at step 120" in said, said)
    checkpoint = f("pieces", "checkpoint.h5")
    run = Run(cfg, f("pieces"), "--restart", checkpoint, *SCENE)
    state = run.steer()
    expect("C=point" in state and "hot=most_sheared" in state, state)
    run.steer("step=100", "inspect.B=none", "checkpoint=1", "step=23", "inspect.D=point:3")  # D is lost with the rest
    run.process.kill()
    run.process.communicate()
    expect(os.path.exists(f("pieces", "steering.socket")), "kill -9 leaves the socket")
    tmdempm("steer", f("pieces"), code=4)
    run = Run(cfg, f("pieces"), "--restart", checkpoint, *SCENE)
    expect(run.step() == 220 and "D=" not in run.steer() and "B=" not in run.steer(), run.steer())
    run.steer("pause=0")
    run.ends(0)
    tmdempm("run", cfg, "--out", f("whole"), "--steering", f("pieces", "steering.csv"), *SCENE)
    same_runs(f("pieces"), f("whole"), "continued", without=["rve/D"])
    # a repetition that is interrupted goes on, too
    repeat = ["--steering", f("pieces", "steering.csv"), *SCENE]
    for until in (0.003, 0.012, 0.022, 0.03):
        there = ["--restart", f("parts", "checkpoint.h5")] if until > 0.003 else ["--out", f("parts")]
        tmdempm("run", cfg, *there, "--until", until, *repeat)
    tmdempm("run", cfg, "--restart", f("parts", "checkpoint.h5"), *repeat)
    for name in ("checkpoint.h5", "history.csv", "rve/C_00000030_path.csv", "rve/B_path.csv"):
        same_file(f("whole", name), f("parts", name), "repeated in parts")
    # elsewhere it goes on with what was in force
    tmdempm("run", cfg, "--restart", f("parts", "checkpoint.h5"), "--out", f("else"), "--until", 0.041, *SCENE)
    with open(f("else", "steering.csv"), encoding="utf-8") as stream:
        expect("earlier,inspect.C=point:" in stream.read(), "the log of what goes on elsewhere")


def ruled(f, cfg):
    """A rule in a scene follows the point, from one snapshot to the next."""
    scene = [*SCENE, "--set", 'inspect=({ name = "p"; rule = "highest_pressure"; })', "--set", "output.snapshot_every=0.002",
             "--set", 'output.rve_states="all"']
    tmdempm("run", cfg, "--out", f("ruled"), *scene)
    expect(not os.path.exists(f("ruled", "rve")) or not os.listdir(f("ruled", "rve")), "a path of many points")
    seen = set()
    for name in sorted(os.listdir(f("ruled", "snap"))):
        point = lambda *which: tmdempm("rve", "show", f("ruled", "snap", name), *which).stdout.split("\npoint")[1].split()[0]
        seen.add(point("--name", "p"))
        expect(point("--name", "p") == point("--rule", "highest_pressure"), "not the one with the highest pressure")
    expect(len(seen) > 1, "always the same point")
    for rule, words in (("coldest", "hottest"), ("most_broken", "with bonds")):
        said = tmdempm("run", cfg, "--out", f("no"), "--set", 'inspect=({ name = "p"; rule = "%s"; })' % rule, code=2).stderr
        expect("inspect.[0].rule" in said and words in said, said)
    said = tmdempm("check", cfg, "--set", 'inspect=({ name = "p"; rule = "hottest"; id = 3; })', code=2).stderr
    expect("two places" in said, said)


def pictured(f, cfg):
    """Another interval for a picture; the picture of an RVE that is no longer inspected is missed, said once, and comes back."""
    if not os.path.exists(os.path.join(os.path.dirname(TMDEMPM), "tmdempm-viewer")):
        print("pictures are not tried: no viewer is built")
        return
    scene = [*SCENE, "--set", 'images=({ name = "g"; kind = "rve"; rve = "A"; field = "rotation"; size = [300, 240]; every = 0.02; })']
    run = Run(cfg, f("pictured"), *scene)
    run.steer("step=100", "images.g.every=0.001", "step=20", "inspect.A=none", "step=20", "inspect.A=hottest", "step=10", "images.g.every=0",
              "pause=0")
    run.ends(0)
    drawn = [int(name[2:10]) for name in sorted(os.listdir(f("pictured", "images")))]
    expect(drawn == [0, 110, 120, 150], str(drawn))
    with open(f("pictured", "log.txt"), encoding="utf-8") as stream:
        expect(stream.read().count("picture g is not drawn: the RVE A is not inspected (now)") == 1, "the missing picture")


with Folder() as f:
    cfg = f.write("s.cfg", COLUMN)
    paused(f, cfg)
    refused(f, cfg)
    held(f, cfg)
    steered(f, cfg)
    continued(f, cfg)
    ruled(f, cfg)
    pictured(f, cfg)
