# timeout: 240
"""Bodies of different laws that touch: a block of RVEs slides on an elastic plate, another on that; momentum between them,
friction's heat in the points, the ledger; and what a scene may not say about contacts."""
from e2e import *

SCENE = """
grid = { origin = [0.0, 0.0]; size = [0.6, 0.5]; cell = 0.02; };
time = { end = 0.01; step = 2e-5; };
gravity = [0.0, -9.81];
materials = (
	{ name = "sand"; heat_capacity = 800.0; conductivity = 1.0;
	  law = { type = "rve"; packing = { discs = 64; pressure = 10e3; mu = 0.5; seed = 3; }; }; },
	{ name = "plate"; density = 2000.0; heat_capacity = 800.0; conductivity = 1.0;
	  law = { type = "thermoelastic"; young = 1e7; poisson = 0.2; }; }
);
bodies = (
	{ name = "plate"; material = "plate"; box = [0.06, 0.04, 0.54, 0.12]; },
	{ name = "lower"; material = "sand"; points_per_cell = 1; box = [0.16, 0.12, 0.36, 0.22]; velocity = [1.0, 0.0]; },
	{ name = "upper"; material = "sand"; points_per_cell = 1; box = [0.16, 0.22, 0.36, 0.32]; velocity = [2.0, 0.0]; }
);
walls = ( { name = "floor"; line = ([0.0, 0.04], [0.6, 0.04]); contact = "stick"; } );
contacts = ( { friction = 0.3; } );
probes = ( { name = "L"; material = [0.26, 0.17]; }, { name = "U"; material = [0.26, 0.27]; } );
output = { vtk = false; snapshot_every = 0.0; };
"""

with Folder() as f:
    tmdempm("run", f.write("s.cfg", SCENE), "--out", f("out"))
    friction, warmed = column(f("out"), "work_contact_friction [J]")[-1], column(f("out"), "energy_thermal [J]")[-1]
    discs, kinetic = column(f("out"), "heat_rve_friction [J]")[-1], column(f("out"), "energy_kinetic [J]")
    residual = column(f("out"), "energy_residual [J]")[-1]
    lower, upper = column(f("out"), "L.velocity_x [m/s]"), column(f("out"), "U.velocity_x [m/s]")
    print("friction %.3f J, points warmed by %.3f J, discs %.3f J; speeds %.3f and %.3f m/s" %
          (friction, warmed, discs, lower[-1], upper[-1]))
    expect(friction > 0.1, "nothing rubs: %g J" % friction)
    # the heat of the last step waits in the points
    expect(abs(warmed - friction - discs) < 1e-3 * warmed, "heat %g J of %g J" % (warmed, friction + discs))
    expect(abs(residual) < 0.01 * kinetic[0], "energy residual %g J" % residual)
    expect(upper[-1] < 2.0 and upper[-1] > lower[-1], "the upper block is not slowed by the lower one")

    def refused(sets, words):
        done = tmdempm("check", f("s.cfg"), *[a for s in sets for a in ("--set", s)], code=2, threads=0)
        text = done.stdout + done.stderr
        for word in words:
            expect(word in text, "%r is not in %r" % (word, text))

    refused(['contacts=({ bodies = ("lower", "lower"); })'], ["names body 'lower' twice"])
    refused(['contacts=({ bodies = ("lower", "upper", "plate"); })'], ["has 3 names"])
    refused(['contacts=({ friction = 0.1; }, { friction = 0.2; })'], ["same pair as contacts.[0]"])
    refused(['contacts=({ softening = [800.0, 300.0]; })'], ["does not rise"])
    refused(['thermal.on=false', 'contacts=({ conductance = 1.0; })'], ["without heat"])
    refused(['time.thermal_every=2'], ["time.thermal_every", "with contacts heat flows in every step"])
    refused(['mpm.confining_pressure=10.0'], ["mpm.confining_pressure", "expected 0 with contacts"])
    refused(['walls.floor.contact="penalty"', 'walls.floor.friction=0.1'], ["penalty walls are smooth"])
