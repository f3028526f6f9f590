# timeout: 120
"""Looking into the RVEs of a run afterwards: found by number, place, name and rule; taken out and driven on with the bits
of the run; and what is not there is said with the command that makes it."""
import shlex
from e2e import *

# Bonds that break as the column falls and warms up; two packings dealt out in turn (their radii give the DEM step
# together); an inspected point of either.
BONDED = COLUMN.replace("temperature = 20.0; }", "temperature = 20.0; variants = 2; }") \
               .replace("mu = 0.5; seed = 3; };", "mu = 0.5; seed = 3; }; bonds = { strength = 0.004; melting = 30.0; "
                        "softening = \"linear\"; reference = 20.0; };") \
               .replace("heat_capacity", "conductivity = 6e4; heat_capacity") + """
boundaries = ( { name = "hot"; box = [0.0, 0.1, 1.0, 0.1]; temperature = 40.0; from = 0.03; } );
stages = ( { name = "settle"; duration = 0.02; damping = 20.0; then = ("install_bonds"); }, { name = "go"; } );
"""
ALL = ["--set", 'output.rve_states="all"']


def shown(*arguments, verb="show"):
    """What `rve show` says, as a dictionary."""
    lines = [line for line in tmdempm("rve", verb, *arguments).stdout.splitlines() if line[:1].strip()]
    return {line[:15].strip(): line[15:] for line in lines}


def info(path):
    return {line[:15].strip(): line[15:] for line in tmdempm("rve", "info", path).stdout.splitlines()}


def curve(path):
    with open(path, newline="", encoding="utf-8") as stream:
        return list(csv.reader(stream))


def driven_on(f, name, source, time, *options, out=None, at_end=None):
    """A state from the middle, driven along the rest of its path, is that of the end, bit for bit; so is the curve."""
    out = out or f("out")
    middle, end, again, rest = f("middle.h5"), f("end.h5"), f("again.h5"), f("rest.csv")
    said = shown(source, "--name", name, *time, "--out", middle, verb="extract")
    command = shlex.split(said["drive it on"])
    expect(command[:3] == ["tmdempm", "rve", "load"] and "--skip" in command, said["drive it on"])
    tmdempm(*command[1:-1], rest, "--save", again)
    tmdempm("rve", "extract", out, *(at_end or ["--name", name]), "--out", end)
    expect(info(middle)["bits"] != info(end)["bits"], "nothing has happened since the middle")
    expect(info(again)["bits"] == info(end)["bits"], "%s from %s: the state at the end is another" % (name, source))
    whole = f("whole.csv")
    if not options:
        return
    tmdempm("rve", "load", *options, "--load", "path", "--path", os.path.join(out, "rve", name + "_path.csv"), "--out", whole)
    rows, others = curve(whole), curve(rest)
    expect(len(others) < len(rows) and others[1:] == rows[len(rows) - len(others) + 1:], "the rest of the curve is another")


def found(f):
    """The same point by number, place, name and rule; the values of the run's own files."""
    out = f("out")
    for time in ([], ["--time", 0.04]):
        by_name = shown(out, "--name", "A", *time)
        expect(by_name["point"].startswith("5 (A)"), by_name["point"])
        expect(shown(out, "--point", 5, *time) == by_name, "--point and --name differ")
        place = by_name["point"].split("(")[2].split(")")[0].replace(" ", "")
        expect(shown(out, "--at", place, *time) == by_name, "--at and --name differ")
    row = history(out)[0].index("A.stress_yy [Pa]")
    at_end = shown(os.path.join(out, "checkpoint.h5"), "--point", 5)
    expect("yy %.6g," % history(out)[1][-1][row] in at_end["stress"], at_end["stress"])
    snap = os.path.join(out, "snap", "00000400.h5")
    expect(shown(snap, "--name", "A") == shown(os.path.join(out, "run.h5"), "--name", "A", "--time", 0.041), "run.h5")


def rules(f):
    """Each rule finds what the fields say, in snapshots that carry all RVEs and in the checkpoint."""
    out = f("all")
    for rule, field in (("hottest", "temperature"), ("most_sheared", "strain_deviatoric"), ("highest_pressure", "rve_pressure"),
                        ("most_broken", "broken_bonds")):
        at_end = shown(os.path.join(out, "checkpoint.h5"), "--rule", rule)
        snapshot = shown(os.path.join(out, "snap", "00001000.h5"), "--rule", rule)
        expect(at_end["point"] == snapshot["point"], "%s: %s, %s" % (rule, at_end["point"], snapshot["point"]))
        best = int(at_end["point"].split()[0])
        # the largest among the probes, which are all the points
        values = {k: column(out, "P%d.%s%s" % (k, field, unit(out, field)))[-1] for k in range(16)}
        expect(values[best] == max(values.values()) and len(set(values.values())) > 1, "%s: %d of %s" % (rule, best, values))
    expect(int(shown(out, "--rule", "most_broken")["bonds"].split()[0]) < 60, "few bonds have broken")
    said = tmdempm("rve", "show", out, "--rule", "most_broken", "--time", 0.0, code=2).stderr
    expect("no bond has broken" in said, said)


def unit(folder, field):
    """' [Pa]' of a field in history.csv."""
    return [name for name in history(folder)[0] if name.startswith("P0.%s" % field)][0][len("P0." + field):]


def steered(f, cfg):
    """An RVE that steering begins to inspect in the middle has a path from there on; it is found, and driven on, too."""
    log = f.write("steer.csv", "time [s],step,source,command\n0.05,500,test,inspect.C=point:9\n")
    out = f("steered")
    tmdempm("run", cfg, "--out", out, "--steering", log)
    driven_on(f, "C", out, ["--time", 0.08], out=out, at_end=["--point", 9])
    said = shown(os.path.join(out, "snap", "00000800.h5"), "--point", 9, "--out", f("C.h5"), verb="extract")
    expect("C_00000500_path.csv --skip 300 " in said["drive it on"], said["drive it on"])


def missing(f, cfg):
    """Not in the snapshot: the message names the command, and the command makes it."""
    said = tmdempm("rve", "show", f("out"), "--point", 7, "--time", 0.04, code=2).stderr
    expect("carries the states of the inspected RVEs only (A, B)" in said and "tmdempm run" in said, said)
    command = shlex.split([line for line in said.splitlines() if line.strip().startswith("tmdempm run")][0])
    expect(cfg in command and "--restart" not in command, said)  # the checkpoint lies after it
    tmdempm(*command[1:])
    there = shown(command[-1], "--point", 7)
    same = shown(f("all"), "--point", 7, "--time", 0.04)
    expect({k: v for k, v in there.items() if k != "from"} == {k: v for k, v in same.items() if k != "from"}, str(there))


def guarded(f, cfg):
    """The state in which a guard stopped a run is there to be looked at."""
    tmdempm("run", cfg, "--out", f("guarded"), "--set", "materials.[0].law.overlap_max=0.006", "--set", "gravity=[0.0,-98.0]", code=3)
    said = shown(f("guarded", "guard.h5"), "--rule", "highest_pressure")
    expect("step 1," in said["from"] and "(" in said["point"], str(said))


def refused(f, cfg):
    for arguments, words in ((["--point", 99], "has the points 0 to 15"), (["--name", "C"], "(A, B)"), ([], "expected --point ID"),
                             (["--rule", "coldest"], "hottest, most_sheared"), (["--at", "1;2"], "x,y"),
                             (["--point", 1, "--rule", "hottest"], "expected one of them")):
        said = tmdempm("rve", "show", f("out"), *arguments, code=2).stderr
        expect(words in said, said)
    for name in ("no.h5", "s.cfg"):
        expect(name in tmdempm("rve", "show", f(name), "--point", 1, code=2).stderr, name)
    tmdempm("rve", "extract", f("out"), "--point", 1, "--out", f("nowhere", "x.h5"), code=4)
    # an RVE file is whole or refused; a packing it is not
    with open(f("middle.h5"), "rb") as stream:
        data = bytearray(stream.read())
    tmdempm("rve", "pack", "--discs", 64, "--pressure", 10e3, "--mu", 0.5, "--out", f("plain.h5"))
    for at in range(len(data) // 4, len(data) - 8, len(data) // 7):
        torn = bytearray(data)
        torn[at] ^= 0x10
        with open(f("torn.h5"), "wb") as stream:
            stream.write(torn)
        done = subprocess.run([TMDEMPM, "rve", "info", f("torn.h5")], capture_output=True, text=True, env=environment(), timeout=60)
        expect(done.returncode in (0, 2, 4), "damaged at %d: ended with %d\n%s" % (at, done.returncode, done.stderr))
        if done.returncode == 0:  # something that no bit of the RVE hangs on, or the readable copy beside it
            expect(info(f("torn.h5"))["bits"] == info(f("middle.h5"))["bits"], "damaged at %d and not seen" % at)
    load = ["--load", "path", "--path", f("out", "rve", "A_path.csv"), "--out", f("x.csv")]
    said = tmdempm("rve", "load", "--packing", f("middle.h5"), *load, "--skip", 5000, code=2).stderr
    expect("--skip 5000 leaves nothing" in said, said)
    said = tmdempm("rve", "load", "--packing", f("middle.h5"), "--load", "shear", "--rate", 1, "--strain", 1e-3, "--skip", 3,
                   "--out", f("x.csv"), code=2).stderr
    expect("--skip" in said, said)
    said = tmdempm("run", cfg, "--set", "materials.[0].law.packing={ file = \"%s\"; }" % f("middle.h5"), "--out", f("y"), code=2).stderr
    expect("not a packing" in said, said)


with Folder() as f:
    probes = "probes = ( %s );" % ", ".join('{ name = "P%d"; id = %d; }' % (k, k) for k in range(16))
    cfg = f.write("s.cfg", BONDED)
    tmdempm("run", cfg, "--out", f("out"), "--until", 0.06)
    driven = f("half.h5")
    os.link(f("out", "checkpoint.h5"), driven)  # the middle of what follows
    tmdempm("run", cfg, "--restart", f("out", "checkpoint.h5"))
    tmdempm("run", f.write("all.cfg", BONDED.replace('probes = ( { name = "A"; id = 5; } );', probes)), "--out", f("all"), *ALL)
    found(f)
    driven_on(f, "A", f("out"), ["--time", 0.04], "--scene", cfg, "--seed", 4)  # point 5 has the second packing
    driven_on(f, "B", f("out"), ["--time", 0.06])
    os.rename(driven, f("out", "half.h5"))
    driven_on(f, "A", f("out", "half.h5"), [])
    rules(f)
    steered(f, cfg)
    missing(f, cfg)
    guarded(f, cfg)
    refused(f, cfg)
    # an RVE in the middle of its life is loaded as a packing is: with its history, and its law's friction
    tmdempm("rve", "load", "--packing", f("middle.h5"), "--load", "shear", "--rate", 1, "--strain", 1e-3, "--out", f("shear.csv"))
    expect(len(curve(f("shear.csv"))) > 10, "no curve")
