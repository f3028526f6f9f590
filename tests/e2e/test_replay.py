# timeout: 120
"""The recorded path of an inspected RVE, replayed alone, gives the same bits as in the run."""
from e2e import *


def cells(path, name):
    with open(path, newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    at = [column.split(" [")[0] for column in rows[0]].index(name)
    return [row[at] for row in rows[1:]]


def replayed(f, cfg, *options, before=0):
    """The run's history of point A, one row a step, against its path replayed, which has `before` rows more."""
    out, curve = f("out"), f("curve.csv")
    tmdempm("run", cfg, "--out", out, "--until", 0.08, "--force", *options)
    # a restart in between changes nothing
    tmdempm("run", cfg, "--restart", os.path.join(out, "checkpoint.h5"), "--until", 0.1, *options)
    tmdempm("rve", "load", "--scene", cfg, "--load", "path", "--path", os.path.join(out, "rve", "A_path.csv"), "--out", curve,
            *options)
    expect(len(cells(os.path.join(out, "rve", "A_path.csv"), "duration")) == 1000 + before, "a step is missing in the path")
    for name in ("stress_xx", "stress_yy", "stress_xy", "void_ratio", "coordination", "sliding_fraction"):
        run, alone = cells(os.path.join(out, "history.csv"), "A." + name), cells(curve, name)[before:]
        expect(len(run) == len(alone) == 1001, "%d rows in the run, %d alone" % (len(run), len(alone)))
        for step, (a, b) in enumerate(zip(run, alone)):
            expect(a == b, "%s at step %d: %s in the run, %s alone" % (name, step, a, b))
    expect(sum(float(share) > 0 for share in run) > 100, "nothing has happened")


def laws(f, cfg):
    """`rve load --scene` takes the law that is asked for, and checks it as a run does."""
    load = ["--load", "isochoric", "--rate", 1, "--strain", 1e-4, "--out", f("x.csv")]
    tmdempm("rve", "load", "--scene", cfg, "--law", "sand", *load)
    os.remove(f("x.csv"))
    said = tmdempm("rve", "load", "--scene", cfg, "--law", "clay", *load, code=2).stderr
    expect(cfg + ' has no RVE law "clay"' in said, said)
    tmdempm("rve", "load", "--scene", cfg, "--set", "materials.[0].law.nu=1", *load, code=2)
    expect(not os.path.exists(f("x.csv")), "a refused load has written")


def bonds(f):
    """Bonds that a stage installs, that soften (and then melt) as the column is heated from below."""
    cfg = f.write("bonded.cfg", """base = "s.cfg";
        set = ("materials.[0].law.bonds={ strength = 0.03; melting = 30.0; softening = \\"linear\\"; reference = 20.0; }",
               "materials.[0].conductivity=6e4",
               "boundaries=( { name = \\"hot\\"; box = [0.0, 0.1, 1.0, 0.1]; temperature = 40.0; from = 0.03; } )",
               "stages=( { name = \\"settle\\"; duration = 0.02; damping = 20.0; then = (\\"install_bonds\\"); }, { name = \\"go\\"; } )");
    """)
    for softening, melting in (("linear", 30.0), ("step", 27.5)):
        law = "materials.[0].law.bonds."
        replayed(f, cfg, "--set", law + "softening=" + softening, "--set", "%smelting=%g" % (law, melting))
        share = [float(cell) for cell in cells(f("out", "history.csv"), "A.bond_fraction")]
        path = f("out", "rve", "A_path.csv")
        expect([row for row, flag in enumerate(cells(path, "bonds")) if flag != "0"] == [199], "installed elsewhere in the path")
        expect(share[199] == 0.0 and share[200] == 1.0, "bonds are not there after their stage")
        if softening == "linear":
            expect(0.0 < share[-1] < 1.0, "no bond has broken, or all: %s" % share[::50])
        else:  # all at once, in the step in which the law's temperature passes the melting point
            hot = [T > melting + 273.15 for T in map(float, cells(path, "T"))].index(True) + 1
            expect(share[hot - 1] > 0.9 and share[hot] == 0.0 == share[-1], "not melted at step %d: %s" % (hot, share[hot - 3:hot + 3]))


with Folder() as f:
    cfg = f.write("s.cfg", COLUMN.replace("history_every = 0.001", "history_every = 1e-4"))
    replayed(f, cfg)
    replayed(f, cfg, "--set", "materials.[0].law.strain_per_step=2e-5", "--set", "materials.[0].law.mu=0.3")
    # discs that wait do so alone as in the run
    quiet = "materials.[0].law.economy.quiet."
    replayed(f, cfg, "--set", quiet + "change=0.3", "--set", quiet + "unbalanced=1.0")
    steps = [float(cell) for cell in cells(f("out", "history.csv"), "A.sub_steps")]
    expect(steps.count(0.0) > 50, "no disc has waited")
    # a body that is born warmer than its reference: the path begins with that
    replayed(f, cfg, "--set", "materials.[0].reference_temperature=15.0", before=1)
    # stress first: the law sees the warming of the step before
    warm = ["--set", "materials.[0].conductivity=6e4", "--set", "materials.[0].law.expansion=1e-4", "--set", "walls.[0].temperature=40.0"]
    replayed(f, cfg, "--set", "mpm.order=usf", *warm)
    laws(f, cfg)
    bonds(f)
