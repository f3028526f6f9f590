# timeout: 300
"""What a crack takes of energy in bars that are pulled in two, over fracture_energy times the width: near 1 with the band's
width by the crack's direction, whatever the angle to the grid; and less along its rows with the cell's diagonal."""
import math
import os

from e2e import Folder, SOURCE_DIR, column, expect, tmdempm

SCENE = os.path.join(SOURCE_DIR, "scenarios", "dp_mpm", "fracture_energy_bar.cfg")
BODIES = ("left", "middle", "right", "holder", "puller")


def taken(folder, band, angle):
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    sets = ["bodies.%s.angle=%d" % (body, angle) for body in BODIES]
    sets += ["materials.%s.law.band=%s" % (material, band) for material in ("steel", "weak")]
    sets += ["bodies.puller.drive=[%.12g, %.12g]" % (c, s), "output.snapshot_every=0"]
    out = folder("%s_%d" % (band, angle))
    tmdempm("run", SCENE, "--out", out, *[word for text in sets for word in ("--set", text)])
    energy = column(out, "loss_fracture [J]")[-1] / (22.13e3 * 0.01 * 1e-3)
    residual = column(out, "energy_residual [J]")[-1] / column(out, "work_boundary [J]")[-1]
    print("%s, %d degrees: %.3f of the fracture energy, residual %.2g of the work" % (band, angle, energy, residual))
    expect(abs(residual) < 1e-3, "%g of the work is missing" % residual)
    expect(column(out, "energy_elastic [J]")[-1] < 0.1 * 22.13e3 * 0.01 * 1e-3, "the bar is not torn")
    return energy


with Folder() as folder:
    projected = {angle: taken(folder, "projected", angle) for angle in (0, 15, 30, 45)}
    # bands along a row of cells are one cell wide or two, as they happen to lie (scenarios/studies/fracture_energy.cfg)
    expect(0.75 < projected[0] < 1.15, "along the grid %g of the fracture energy" % projected[0])
    for angle in (15, 30, 45):
        expect(0.88 < projected[angle] < 1.12, "at %d degrees %g of the fracture energy" % (angle, projected[angle]))
    expect(taken(folder, "diagonal", 0) < 0.85 * projected[0], "the diagonal does not take less along the grid")
