# timeout: 120
"""A box of RVEs, held on all sides and heated: a square lattice of discs of radius r (1 + beta dT) presses with
kn/z beta dT more, to first order (methods-rve.md); the run's wall and points feel it, and the books of energy close."""
from e2e import *

SCENE = """
grid = { origin = [0.0, 0.0]; size = [0.6, 0.6]; cell = 0.1; };
time = { end = 0.3; step = 2e-4; };
materials = ( {
	name = "lattice"; heat_capacity = 1.0; conductivity = 100.0;
	law = { type = "rve"; mu = 0.001;
		packing = { lattice = "square"; discs = 16; radius_max = 5e-3; radius_min = 5e-3; pressure = 100e3; mu = 0.0; }; };
} );
bodies = ( { name = "block"; material = "lattice"; box = [0.2, 0.2, 0.4, 0.4]; points_per_cell = 1; temperature = 300.0; } );
walls = (
	{ name = "floor"; line = ([0.0, 0.2], [0.6, 0.2]); contact = "slip"; },
	{ name = "roof"; line = ([0.6, 0.4], [0.0, 0.4]); contact = "slip"; },
	{ name = "left"; line = ([0.2, 0.6], [0.2, 0.0]); contact = "slip"; },
	{ name = "right"; line = ([0.4, 0.0], [0.4, 0.6]); contact = "slip"; }
);
boundaries = ( { name = "hot"; box = [0.0, 0.0, 0.6, 0.6]; temperature = 350.0; from = 0.1; } );
probes = ( { name = "A"; id = 0; } );
output = { snapshot_every = 0.0; history_every = 0.01; vtk = false; };
"""

with Folder() as f:
    tmdempm("run", f.write("s.cfg", SCENE), "--out", f("out"))
    for name in ("stress_xx", "stress_yy"):
        stress = column(f("out"), "A." + name + " [Pa]")
        change = stress[-1] - stress[5]
        print("%s: %.0f Pa cold, %.0f Pa more when hot" % (name, stress[5], change))
        expect(abs(stress[5] + 100e3) < 1e3, "it starts at the pressure of its packing: %g" % stress[5])
        # -kn/z beta dT = -66.7 kPa; the discs alone give -67.2 kPa (tests/verification/test_rve_physics.c)
        expect(abs(change + 67.2e3) < 0.2e3, "%s changes by %g" % (name, change))
    roof, T = column(f("out"), "wall.roof.force_y [N]"), column(f("out"), "A.temperature [K]")
    expect(abs(T[-1] - 350.0) < 0.01, "not heated through: %g" % T[-1])
    expect(abs(roof[-1] / 0.2 + stress[-1]) < 1e3, "the roof feels %g Pa" % (roof[-1] / 0.2))
    residual, expansion = column(f("out"), "energy_residual [J]")[-1], column(f("out"), "work_expansion [J]")[-1]
    expect(abs(residual) < 1e-3 * expansion, "energy residual %g of %g J" % (residual, expansion))
