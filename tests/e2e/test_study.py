# timeout: 240
"""Studies: runs of a second, errors against an exact solution, resumption, gates, charts."""
import csv
import glob
import json
import signal
import subprocess
import time
from e2e import *

# A half space whose end is suddenly heated, short and coarse.
BAR = """
grid = { origin = [-0.16, -0.16]; size = [3.2, 0.4]; cell = 0.08; };
time = { end = 0.4; step = 2e-3; };
materials = ( { name = "m"; density = 1.0; heat_capacity = 1.0; conductivity = 1.0;
                law = { type = "thermoelastic"; young = 1.0; poisson = 0.0; expansion = 1e-6; }; } );
bodies = ( { name = "bar"; material = "m"; box = [0.0, 0.0, 2.88, 0.08]; temperature = 0.0; points_per_cell = 1; } );
boundaries = ( { name = "hot"; box = [-0.16, 0.0, 0.0, 0.08]; temperature = 100.0; },
               { name = "sides"; box = [0.0, 0.0, 2.88, 0.08]; velocity_y = 0.0; } );
probes = ( { name = "A"; material = [0.48, 0.04]; } );
output = { history_every = 0.02; snapshot_every = 0.4; };
"""

STUDY = """
title = "heated bar";
scene = { file = "bar.cfg"; set = ("time.step=$(dt)"); };
knobs = ( { name = "pic"; path = "mpm.pic_fraction"; values = [0.01, 0.1]; },
          { name = "dt"; unit = "s"; values = [2e-3, 1e-3, 5e-4]; } );
reference = { exact = "danilovskaya"; parameters = { shock = 100.0; }; };
norms = ( { name = "T"; column = "A.temperature"; scale = 100.0; from = 0.02; gate = 1.0; },
          { name = "T_all"; points = "temperature"; scale = 100.0; } );
against = ("dt");
"""


def study(folder, *arguments, code=0, name="bar_study.cfg"):
    return tmdempm("study", folder(name), "--out", folder("out"), *arguments, code=code)


def rows(folder, name="bar_study"):
    with open(folder("out", name, "study.csv"), newline="", encoding="utf-8") as stream:
        table = list(csv.reader(stream))
    return [dict(zip([cell.split(" [")[0] for cell in table[0]], row)) for row in table[1:]]


def outcomes(folder, name="bar_study"):
    """When each run ended."""
    return {path: os.stat(path).st_mtime_ns for path in glob.glob(folder("out", name, "runs", "*", "outcome.txt"))}


def write(f):
    f.write("bar.cfg", BAR)
    f.write("bar_study.cfg", STUDY)


# Two at a time; every run has its errors, its cost and its folder; the charts are drawn.
with Folder() as f:
    write(f)
    said = study(f, "--jobs", 2)
    expect("6 runs, 0 of them done before" in said.stdout, said.stdout)
    table = rows(f)
    expect(len(table) == 6, "%d rows" % len(table))
    for row in table:
        expect(row["outcome"] == "done", str(row))
        expect(0 < float(row["T.error"]) < 0.02, "T.error " + row["T.error"])
        expect(0 < float(row["T_all.error"]) < 0.02, "T_all.error " + row["T_all.error"])
        expect(float(row["steps"]) == round(0.4 / float(row["dt"])), "steps " + row["steps"])
        expect(float(row["point_steps"]) == 36 * float(row["steps"]), "point_steps " + row["point_steps"])
        expect(float(row["cpu"]) > 0 and float(row["wall"]) > 0, "no cost")
        expect(os.path.exists(f("out", "bar_study", row["folder"], "out", "history.csv")), row["folder"])
    # a second look: the error of one run from its own history (the exact solution is tested elsewhere)
    first = f("out", "bar_study", table[0]["folder"], "out")
    exact = tmdempm("exact", "danilovskaya", "--set", "shock=100", "--at", "0.48,0.04", "--times", "0.02:0.4:19")
    exact = [float(line.split(",")[1]) for line in exact.stdout.splitlines()[1:]]
    ours = column(first, "A.temperature [K]")[1:]
    expect(len(exact) == len(ours) == 20, "%d and %d values" % (len(exact), len(ours)))
    squares = [((a - b) / 100) ** 2 for a, b in zip(exact, ours)]
    rms = ((sum(squares) - 0.5 * (squares[0] + squares[-1])) / 19) ** 0.5
    expect(abs(rms - float(table[0]["T.error"])) < 1e-9, "T.error is %s, by hand %.12g" % (table[0]["T.error"], rms))
    if "no charts" not in said.stderr:
        for name in ("cost.png", "cost.svg", "convergence_dt.png", "convergence_dt.svg"):
            expect(os.path.getsize(f("out", "bar_study", name)) > 5000, name)
    # once more: nothing is run; with another program, scene or setting it would be
    before = outcomes(f)
    again = study(f, "--no-charts")
    expect("6 of them done before" in again.stdout, again.stdout)
    expect(outcomes(f) == before, "a run that was done has been repeated")
    study(f, "--no-charts", "--set", "scene.set.[0]=time.step=$(dt/2)")
    expect(len(outcomes(f)) == 12, "another step is another run")
    study(f, "--no-charts", "--fresh")
    expect(all(when > before[path] for path, when in outcomes(f).items() if path in before), "--fresh has kept old runs")

# Killed in the middle: its children end; what was done stays, the rest is run.
with Folder() as f:
    f.write("bar.cfg", BAR.replace("end = 0.4", "end = 16.0").replace("snapshot_every = 0.4", "snapshot_every = 16.0"))
    f.write("bar_study.cfg", STUDY)
    command = [TMDEMPM, "study", f("bar_study.cfg"), "--out", f("out"), "--no-charts"]
    process = start(command, stdout=subprocess.DEVNULL, env=environment())
    while len(outcomes(f)) < 2:
        time.sleep(0.01)
        expect(process.poll() is None, "the study ended by itself")
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = outcomes(f)
    expect(2 <= len(before) < 6, "%d runs were done" % len(before))
    time.sleep(0.5)
    expect(len(outcomes(f)) == len(before), "a run has outlived its study")
    said = study(f, "--no-charts", "--jobs", 2)
    expect("%d of them done before" % len(before) in said.stdout, said.stdout)
    expect(all(outcomes(f)[path] == when for path, when in before.items()), "a run that was done has been repeated")
    expect(len(rows(f)) == 6 and all(row["outcome"] == "done" for row in rows(f)), "runs are missing")

# SIGINT ends the children and says how to go on.
with Folder() as f:
    f.write("bar.cfg", BAR.replace("end = 0.4", "end = 4000.0"))
    f.write("bar_study.cfg", STUDY)
    process = start([TMDEMPM, "study", f("bar_study.cfg"), "--out", f("out"), "--jobs", "2"], text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment())
    while not glob.glob(f("out", "bar_study", "runs", "*", "out", "history.csv")):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    expect(process.returncode == 130, "SIGINT gave %d" % process.returncode)
    expect("the same command goes on where it was" in errors, errors)
    expect(not outcomes(f), "an interrupted run counts as done")

# A gate that is missed: exit code 3, with the norm, its value, the bound and the combination.
with Folder() as f:
    f.write("bar.cfg", BAR)
    f.write("bar_study.cfg", STUDY.replace("gate = 1.0", 'gates = ( { bound = 1e-9; where = "pic=0.1, dt=1e-3"; } )'))
    said = study(f, "--no-charts", code=3)
    expect("T is 0.00" in said.stderr and "expected at most 1e-09 (pic=0.1, dt=0.001)" in said.stderr, said.stderr)
    expect("1 of 1 gates missed" in said.stderr, said.stderr)
    f.write("bar_study.cfg", STUDY + 'orders = ( { norm = "T_all"; knob = "dt"; least = 5.0; } );')
    said = study(f, "--no-charts", code=3)
    expect("the order of T_all in dt is" in said.stderr and "expected at least 5" in said.stderr, said.stderr)

# A run that a guard stops is an outcome, not the end of the study; a gate does not let it pass.
with Folder() as f:
    f.write("bar.cfg", BAR.replace("velocity_y = 0.0;", "velocity_y = 0.0; velocity_x = 40.0;"))
    f.write("bar_study.cfg", STUDY.replace(" gate = 1.0;", "").replace("0.01, 0.1", "0.01"))
    study(f, "--no-charts")
    expect(all(row["outcome"] == "guard" and row["reason"] for row in rows(f)), str(rows(f)))
    f.write("bar_study.cfg", STUDY.replace("0.01, 0.1", "0.01"))
    said = study(f, "--no-charts", code=3)
    expect("T could not be had" in said.stderr and "guard" in said.stderr, said.stderr)

# Stability: everything with and without guards; the slow wall is stable, the fast one drives points out of the grid.
with Folder() as f:
    f.write("bar.cfg", BAR)
    f.write("bar_study.cfg", """
        kind = "stability";
        scene = { file = "bar.cfg"; set = ("boundaries.sides.velocity_x=$(speed)"); };
        knobs = ( { name = "speed"; unit = "m/s"; values = [0, 40]; } );
        guards_off = ("guards.points_leaving=false", "guards.energy_residual=0");
        map = ("speed");
        norms = ( { name = "x"; kind = "max"; column = "A.position_x"; unit = "m"; garbage = 2.0; } );
        curves = ( { label = "a cell per step"; y = "0.08/2e-3"; } );""")
    said = study(f)
    verdicts = {(row["speed"], row["guards"]): row["verdict"] for row in rows(f)}
    expect(verdicts == {("0", "on"): "stable", ("0", "off"): "stable", ("40", "on"): "guarded", ("40", "off"): "guarded"}, str(rows(f)))
    if "no charts" not in said.stderr:
        expect(os.path.getsize(f("out", "bar_study", "map.png")) > 5000, "map.png")
    # what the scene refuses is an outcome too; it has no folder, and the file of that name here is somebody's own
    f.write("bar_study.cfg", """
        kind = "stability";
        scene = { file = "bar.cfg"; };
        knobs = ( { name = "dt"; path = "time.step"; values = [2e-3, 1.0]; } );
        guards_off = ("guards.points_leaving=false");
        map = ("dt");
        norms = ( { name = "x"; kind = "max"; column = "A.position_x"; unit = "m"; garbage = 2.0; } );""")
    f.write("outcome.txt", "outcome done")
    for more in (), ("--fresh",):
        tmdempm("study", "bar_study.cfg", "--out", "out", "--no-charts", *more, cwd=f())
        found = sorted((row["dt"], row["outcome"]) for row in rows(f))
        expect(found == [("0.002", "done")] * 2 + [("1", "refused")] * 2, str(found))
        expect(os.path.exists(f("outcome.txt")), "a file of the user's is gone")

# Mistakes are told with file and line before anything is run.
with Folder() as f:
    write(f)
    for old, new, message in (("values = [0.01, 0.1]", "values = []", "wrong.cfg:4: knobs.[0] has nothing to turn it to"),
                              ("mpm.pic_fraction", "mpm.pick", "mpm.pick is not known, expected a key of the scene"),
                              ("danilovskaya", "danilovski", 'there is no exact solution "danilovski"'),
                              ("shock", "shok", "reference.parameters"),
                              ("bar.cfg", "baz.cfg", "baz.cfg' (No such file or directory), expected a scene file"),
                              ("A.temperature", "A.temperatur", "A.temperatur is not known here")):
        f.write("wrong.cfg", STUDY.replace(old, new))
        said = study(f, "--no-charts", name="wrong.cfg", code=2)
        expect(message in said.stderr, "expected %s, got %s" % (message, said.stderr))
    expect("expected tmdempm study FILE.cfg" in tmdempm("study", code=2).stderr, "no file, no message")
    expect("knobs" in tmdempm("study", "--keys").stdout, "--keys says nothing")

# The finest run as the reference, and one RVE alone.
with Folder() as f:
    write(f)
    f.write("bar_study.cfg", STUDY.replace('exact = "danilovskaya"; parameters = { shock = 100.0; };', 'finest = "dt=5e-4";')
            .replace('points = "temperature"; scale = 100.0;', 'column = "A.temperature"; kind = "end"; relative = true;'))
    study(f, "--no-charts")
    for row in rows(f):
        expect((row["T.error"] == "nan") == (row["dt"] == "0.0005") == (row["reference"] == "yes"), str(row))
        expect(row["dt"] == "0.0005" or 0 < float(row["T_all.error"]) < 0.05, str(row))
    f.write("rve.cfg", """
        load = ("discs=64", "pressure=100e3", "mu-pack=0.5", "load=isochoric", "rate=1", "strain=0.02", "rows=20");
        knobs = ( { name = "deps"; path = "strain-per-step"; values = [1e-5, 1e-4]; },
                  { name = "seed"; path = "seed"; seed = true; values = [1, 2]; } );
        reference = { finest = "deps=1e-5"; };
        norms = ( { name = "p"; column = "-(stress_xx + stress_yy)/2"; abscissa = "strain_xx"; kind = "mean"; relative = true; } );""")
    study(f, "--no-charts", name="rve.cfg")
    table = rows(f, "rve")
    expect(len(table) == 4 and all(row["outcome"] == "done" for row in table), str(table))
    expect(all(float(row["p.value"]) > 1e4 and float(row["steps"]) > 100 for row in table), str(table))
    with open(f("out", "rve", "summary.csv"), newline="", encoding="utf-8") as stream:
        summary = list(csv.DictReader(stream))
    expect([row["runs [-]"] for row in summary] == ["2", "2"], str(summary))
    middle = sum(float(row["p.value"]) for row in table if row["deps"] == "0.0001") / 2
    expect(abs(float(summary[1]["p.value [-]"]) - middle) < 1e-9 * middle, str(summary))
