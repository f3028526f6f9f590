# timeout: 120
"""Where a run may write, what it writes there, and how it ends when it may not."""
import base64
import json
import struct
import time
from xml.etree import ElementTree
from e2e import *


def header_and_files(f, cfg):
    out = f("out")
    said = tmdempm("run", cfg, "--out", out, "--until", 0.02).stdout
    for name in ("history.csv", "run.json", "log.txt", "checkpoint.h5", "run.h5", "points.pvd", "domains.pvd", "grid.pvd", "walls.pvd"):
        expect(os.path.exists(os.path.join(out, name)), name + " is missing")
        expect(name in said, name + " is not announced:\n" + said)
    expect(not [n for n in files_below(out) if n.endswith(".tmp")], "temporary files are left")
    names, rows = history(out)
    for name in ("time [s]", "step [-]", "dt [s]", "energy_kinetic [J]", "energy_residual [J]", "heat_in [J]",
                 "region.all.mass [kg]", "region.all.flow [kg/s]", "region.low.temperature [C]",
                 "wall.ground.force_x [N]", "wall.ground.force_y [N]", "wall.ground.friction_heat [J]",
                 "A.position_x [m]", "A.velocity_y [m/s]", "A.temperature [C]", "A.stress_xx [Pa]", "B.strain_xy [-]",
                 "C.displacement_y [m]"):
        expect(name in names, "no column `%s` in\n%s" % (name, names))
    expect(len(set(names)) == len(names), "a column is there twice")
    expect([row[0] for row in rows] == sorted(set(row[0] for row in rows)), "times do not grow")
    with open(os.path.join(out, "history.csv"), "rb") as stream:
        lines = stream.read().split(b"\r\n")
    expect(lines[-1] == b"" and all(b"\n" not in line for line in lines), "rows do not end as RFC 4180 wants")
    mass = column(out, "region.all.mass [kg]")
    expect(abs(mass[0] - 300) < 1e-9 and mass[-1] == mass[0], "mass %r" % mass)
    expect(abs(column(out, "C.temperature [C]")[0] - 20) < 1e-9, "temperatures are not in the scene's unit")


def report(f):
    with open(f("out", "run.json"), encoding="utf-8") as stream:
        run = json.load(stream)
    expect(run["state"] == "done" and run["points"] == 120 and run["step"] == 200, str(run))
    for task in ("law", "mpm", "output", "viewer_wait", "total"):
        expect(run["seconds"][task] >= 0, "no time of " + task)
    expect(run["rates"]["point_steps_per_second"] > 0, "no rate")


def refusals(f, cfg):
    before = files_below(f("out"))
    said = tmdempm("run", cfg, "--out", f("out"), code=2).stderr
    expect("is not empty" in said and "--force" in said, said)
    expect(files_below(f("out")) == before, "a refused run has written")
    tmdempm("run", cfg, "--out", f("out"), "--force", "--until", 0)
    expect(files_below(f("out.old-1")) == before, "the old folder is not whole")
    tmdempm("run", cfg, "--out", f("out"), "--force", "--until", 0)
    expect(os.path.isdir(f("out.old-2")), "no second old folder")
    os.mkdir(f("empty"))
    tmdempm("run", cfg, "--out", f("empty"), "--until", 0)
    said = tmdempm("run", cfg, "--out", cfg, code=2).stderr
    expect("Not a directory" in said, said)
    said = tmdempm("run", cfg, "--out", "/proc/nowhere", code=4).stderr
    expect("/proc/nowhere" in said, said)
    # the default name, beside the user
    tmdempm("run", cfg, "--until", 0, cwd=f("empty"))
    expect(os.path.exists(f("empty", "s.out", "history.csv")), "no default folder")


def usage(f, cfg):
    before = sorted(os.listdir(f.path))
    for arguments, text in (
            ((), "which command"), (("fly",), "`fly` is no command"), (("run",), "which scene"),
            (("run", cfg, cfg), "is too much"), (("run", cfg, "--nonsense"), "--nonsense"), (("run", cfg, "--out"), "--out"),
            (("run", cfg, "-x"), "-x"), (("run", cfg, "--quiet=1"), "no argument is expected in `--quiet=1`"), (("run", cfg, "--set", "end"), "expected path=value"),
            (("run", cfg, "--set", "time.ende=1"), "time.ende"), (("run", cfg, "--set", "time.end=soon"), "time.end"),
            (("run", cfg, "--set", "walls.[7].friction=1"), "walls"),
            (("run", cfg, "--threads", "0"), "--threads 0"), (("run", cfg, "--threads", "two"), "--threads two"),
            (("run", cfg, "--until", "-1"), "--until"), (("run", cfg, "--device", "cuda"), "--device cuda"),
            (("run", cfg, "--device", "abacus"), "expected auto, cpu"), (("run", "nothing.cfg"), "nothing.cfg"),
            (("check",), "which scene"), (("check", cfg, "--out", "x"), "--out"), (("info", "more"), "`more`"),
            (("bench",), "expected one of"), (("bench", "everything"), "expected one of")):
        done = subprocess.run([TMDEMPM] + list(arguments), capture_output=True, text=True, cwd=f.path, env=environment())
        expect(done.returncode == 2, "%s ended with %d" % (arguments, done.returncode))
        expect(text in done.stderr, "%s: `%s` is not in: %s" % (arguments, text, done.stderr))
        expect(done.stdout == "", "%s prints %s" % (arguments, done.stdout))
    expect(sorted(os.listdir(f.path)) == before, "something was written: %s" % os.listdir(f.path))


def other_commands(f, cfg):
    before = sorted(os.listdir(f.path))
    said = tmdempm("check", cfg).stdout
    for word in ("passes", "points     120", "nodes", "RVEs       none", "memory", "limit", "P-wave modulus", "time "):
        expect(word in said, "`%s` is not in:\n%s" % (word, said))
    expect(sorted(os.listdir(f.path)) == before, "check has written")
    said = tmdempm("info").stdout
    for word in ("thermoelastic", "rve", "ugimp", "linear", "images", "cpu", "temperature", "energy_residual"):
        expect(word in said, "`%s` is not in:\n%s" % (word, said))
    info = json.loads(tmdempm("info", "--json").stdout)
    expect({law["name"] for law in info["laws"]} == {"thermoelastic", "rve", "neohookean_rankine"}, str(info["laws"]))
    for missing in [part for part in info["devices"] + info["sinks"] if not part["available"]]:
        expect(len(missing["install"]) > 10, "nothing says how to get %s" % missing["name"])
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run([TMDEMPM, "check", cfg], stdout=full, stderr=subprocess.PIPE, text=True, env=environment())
    expect(done.returncode == 4 and "standard output" in done.stderr, "a full output: %d %s" % (done.returncode, done.stderr))
    expect("tmdempm run" in tmdempm("--help").stdout and "0." in tmdempm("--version").stdout, "help, version")


def step_over_the_limit(f):
    """Only the packing knows how stiff an RVE is: the step is refused all the same before anything is written."""
    cfg = f.write("fast.cfg", COLUMN.replace("step = 1e-4", "step = 1e-2"))
    for command in (("check", cfg), ("run", cfg, "--out", f("fast"))):
        said = tmdempm(*command, code=2).stderr
        expect(cfg + ": time.step: " in said and "above the limit" in said and "cure: " in said, said)
    expect(not os.path.exists(f("fast")), "a refused run has written")


def vtk_blocks(f):
    """A .vtp is well-formed XML whose blocks say their own size."""
    root = ElementTree.parse(f("out", "vtk", "domains_00000200.vtp")).getroot()
    blocks = [a for a in root.iter("DataArray") if a.get("format") == "binary"]
    expect(len(blocks) > 10, "%d arrays" % len(blocks))
    for block in blocks:
        data = base64.b64decode(block.text.strip(), validate=True)
        expect(struct.unpack("<Q", data[:8])[0] == len(data) - 8, "%s: %d bytes" % (block.get("Name"), len(data) - 8))


def disk_full(f, cfg):
    """/dev/full cannot be a folder; a limit on the size of files fails a write in the same way."""
    import resource
    import signal

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

    said = tmdempm("run", cfg, "--out", f("full"), code=4, preexec_fn=limit).stderr
    expect(f("full") in said and "File too large" in said, said)
    expect(not [n for n in files_below(f("full")) if n.endswith(".tmp")], "temporary files are left")


def in_use(f, cfg):
    """Two runs never write to one folder: not by force, not by a restart."""
    out = f("busy")
    tmdempm("run", cfg, "--out", out, "--until", 0.01)
    again = ["run", cfg, "--out", out, "--restart", os.path.join(out, "checkpoint.h5"), "--set", "time.end=1000"]
    first = start([TMDEMPM] + again + ["--quiet"], env=environment())
    try:
        while "continues" not in open(os.path.join(out, "log.txt"), encoding="utf-8").read():
            time.sleep(0.01)
            expect(first.poll() is None, "the first run has ended")
        for more in (again, ["run", cfg, "--out", out, "--force"]):
            expect("another run is writing to" in tmdempm(*more, code=2).stderr, "the folder is not protected")
        expect(first.poll() is None, "the first run has ended")
    finally:
        first.kill()
        first.wait()


with Folder() as f:
    cfg = f.write("s.cfg", BLOCK)
    header_and_files(f, cfg)
    report(f)
    vtk_blocks(f)
    usage(f, cfg)
    other_commands(f, cfg)
    refusals(f, cfg)
    in_use(f, cfg)
    disk_full(f, cfg)
    step_over_the_limit(f)
