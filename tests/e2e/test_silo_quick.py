# labels: slow
# timeout: 900
"""The quick forced silo discharge, whole: the material runs out under the plate, mass and energy are accounted for."""
import json
from e2e import *


def last(folder, name):
    return column(folder, name)[-1]


with Folder() as f:
    scene = os.path.join(SOURCE_DIR, "scenarios", "tm_dempm", "silo_forced_quick.cfg")
    out = f("out")
    tmdempm("run", scene, "--out", out, threads=None)
    with open(os.path.join(out, "run.json"), encoding="utf-8") as stream:
        run = json.load(stream)
    expect(run["state"] == "done", str(run["state"]))

    silo, ground = column(out, "region.silo.mass [kg]"), column(out, "region.ground.mass [kg]")
    for a, b in zip(silo, ground):
        expect(abs(a + b - silo[0]) <= 1e-9 * silo[0], "mass in the silo %r + on the ground %r is not %r" % (a, b, silo[0]))
    expect(ground[-1] > 0.15 * silo[0], "only %g of %g kg have left" % (ground[-1], silo[0]))
    expect(all(a >= b - 1e-9 for a, b in zip(silo, silo[1:])), "material returns into the silo")

    put_in = column(out, "energy_gravity [J]")[0] - last(out, "energy_gravity [J]") + last(out, "work_boundary [J]")
    residual = max(abs(r) for r in column(out, "energy_residual [J]"))
    expect(residual < 0.02 * put_in, "energy residual %g J of %g J of work" % (residual, put_in))
    expect(last(out, "heat_rve_friction [J]") > 0.05 * put_in, "friction does not heat")
    warmed = last(out, "energy_thermal [J]") - column(out, "energy_thermal [J]")[0]
    expect(abs(warmed - last(out, "heat_rve_friction [J]")) < 1e-3 * warmed, "heat %g J of friction %g J"
           % (warmed, last(out, "heat_rve_friction [J]")))
    print("%.0f s, %.3g disc-steps/s, %.1f kg out, residual %.2f %%"
          % (run["seconds"]["total"], run["rates"]["disc_steps_per_second"], ground[-1], 100 * residual / put_in))
