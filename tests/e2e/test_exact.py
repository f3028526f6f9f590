# timeout: 120
"""`tmdempm exact` prints the table and its values; a scene whose body follows an exact motion does so, also across a
restart."""
from e2e import *

SCENE = """
grid = { origin = [-0.125, -0.125]; size = [1.25, 1.25]; cell = 0.0625; };
time = { end = 0.004; step = 2e-5; };
materials = ( { name = "m"; density = 1.0; law = { type = "thermoelastic"; young = 1e4; poisson = 0.3; elasticity = "neo_hookean"; }; } );
bodies = ( { name = "square"; material = "m"; box = [0.0, 0.0, 1.0, 1.0];
	motion = { solution = "axis_aligned"; parameters = ("amplitude=0.01", "length=1"); }; } );
walls = (
	{ name = "floor"; line = ([-0.125, 0.0], [1.125, 0.0]); contact = "slip"; },
	{ name = "roof"; line = ([1.125, 1.0], [-0.125, 1.0]); contact = "slip"; },
	{ name = "left"; line = ([0.0, 1.125], [0.0, -0.125]); contact = "slip"; },
	{ name = "right"; line = ([1.0, -0.125], [1.0, 1.125]); contact = "slip"; }
);
probes = ( { name = "A"; id = 300; } );
output = { snapshot_every = 0.0; history_every = 0.0004; checkpoint_every = 0.002; vtk = false; };
"""


def rows(*arguments):
    lines = tmdempm("exact", *arguments).stdout.splitlines()
    return lines[0].split(","), [[float(cell) for cell in line.split(",")] for line in lines[1:]]


def table():
    listed = tmdempm("exact").stdout
    for name in ("danilovskaya", "rod", "square", "vortex", "column"):
        expect("  " + name in listed, listed)
        expect("fields" in tmdempm("exact", name).stdout, name)
    names, values = rows("danilovskaya", "--set", "expansion=1", "--set", "shock=1", "--at", "1,0", "--times", "0.5,0.9,1.5,3")
    expect(names == ["time [s]", "temperature [K]", "displacement_x [m]", "velocity_x [m/s]", "stress_xx [Pa]"], str(names))
    for row, (T, sigma) in zip(values, [(.317311, -.405224), (.456057, -.778878), (.563703, .077180), (.683091, .035836)]):
        expect(abs(row[1] - T) < 1e-6 and abs(row[4] - sigma) < 1e-6, str(row))
    names, values = rows("plate", "--at", "0.5,0", "--times", "0:1:4")
    expect([row[0] for row in values] == [0, .25, .5, .75, 1], str(values))
    for wrong, said in ((["rods"], "no solution"), (["rod", "--at", "1"], "--at 1: expected x,y"),
                        (["rod", "--at", "1,0"], "--at and --times together"),
                        (["rod", "--at", "1,0", "--times", "1:0:3"], "from:to:n"),
                        (["rod", "--set", "lenght=2"], "length, diffusivity")):
        message = tmdempm("exact", *wrong, code=2).stderr
        expect(said in message, message)


def motion(f):
    cfg = f.write("s.cfg", SCENE)
    tmdempm("run", cfg, "--out", f("whole"))
    tmdempm("run", cfg, "--out", f("part"), "--until", 0.002)
    tmdempm("run", cfg, "--restart", f("part", "checkpoint.h5"))
    same_file(f("whole", "history.csv"), f("part", "history.csv"), "a run with a motion and the same in two parts")
    out = f("whole")
    x, y = ([p - d for p, d in zip(column(out, "A.position_%s [m]" % c), column(out, "A.displacement_%s [m]" % c))][0] for c in "xy")
    times = ",".join("%.17g" % t for t in column(out, "time [s]"))
    names, values = rows("axis_aligned", "--set", "amplitude=0.01", "--at", "%.17g,%.17g" % (x, y), "--times", times)
    for c in "xy":
        at = names.index("displacement_%s [m]" % c)
        worst = max(abs(row[at] - u) for row, u in zip(values, column(out, "A.displacement_%s [m]" % c)))
        print("displacement_%s is off by %.2g of the amplitude" % (c, worst / 0.01))
        expect(worst < 0.01 * 0.01, "displacement_%s is off by %g m" % (c, worst))


with Folder() as f:
    table()
    motion(f)
