"""Kalthoff's plate on coarse cells: cracks and their angle, symmetry, heat, energy; restart, threads, pieces."""
import csv
import math
import os

from e2e import Folder, SOURCE_DIR, column, expect, same_file, tmdempm

SCENE = os.path.join(SOURCE_DIR, "scenarios", "dp_mpm", "kalthoff_33_quick.cfg")


def last(folder, name):
    return column(folder, name)[-1]


with Folder() as folder:
    # cracks leave both notches at 60 to 72 degrees, at 1 to 2 km/s, not before 22 microseconds, and mirror each other
    tmdempm("run", SCENE, "--out", folder("a"), threads=2)
    upper, lower = last(folder("a"), "crack.upper.angle [deg]"), last(folder("a"), "crack.lower.angle [deg]")
    print("angles %.2f, %.2f deg; length %.4g m" % (upper, lower, last(folder("a"), "crack.upper.length [m]")))
    expect(60.0 < upper < 72.0, "the upper crack is at %g degrees" % upper)
    expect(abs(upper + lower) < 1.0, "the cracks do not mirror: %g and %g degrees" % (upper, lower))
    lengths, times = column(folder("a"), "crack.upper.length [m]"), column(folder("a"), "time [s]")
    expect(all(t > 22e-6 for t, l in zip(times, lengths) if l > 0.0), "the crack starts too early")
    expect(0.015 < lengths[-1] < 0.04, "the crack is %g m long" % lengths[-1])
    speed = (lengths[-1] - lengths[-21]) / (times[-1] - times[-21])
    expect(1000.0 < speed < 2500.0, "the crack runs at %g m/s" % speed)

    # the ledger closes, fracture takes its share, and heat is what laws gave
    work = last(folder("a"), "work_boundary [J]")
    expect(abs(last(folder("a"), "energy_residual [J]")) < 1e-3 * work, "energy is missing")
    expect(0.02 * work < last(folder("a"), "loss_fracture [J]") < 0.2 * work, "fracture took an odd share")
    expect(abs(last(folder("a"), "heat_residual [J]")) < 1e-6 * work, "heat is missing")

    # stopped half way and taken up again on one thread: the same bits
    tmdempm("run", SCENE, "--out", folder("b"), "--until", 24e-6)
    tmdempm("run", SCENE, "--restart", folder("b", "checkpoint.h5"))
    same_file(folder("a", "checkpoint.h5"), folder("b", "checkpoint.h5"), "states of two threads, and of one and a restart,")
    same_file(folder("a", "history.csv"), folder("b", "history.csv"), "histories")

    # pieces of it
    tmdempm("fragments", folder("a"))
    with open(folder("a", "fragments", "series.csv"), newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))[1:]
    expect(len(rows) == 8, "%d rows for 8 snapshots" % len(rows))
    expect(math.isclose(float(rows[-1][6]), last(folder("a"), "fragments.broken [m2]")), "broken area differs from the history's")
    expect(os.path.getsize(folder("a", "fragments", "cracks.vtp")) > 500, "there are no crack lines")
    told = tmdempm("fragments", folder("b", "nowhere"), code=2).stderr
    expect("expected the folder of a run" in told, told)

    # cells too large for the fracture energy are refused with the size that would do
    told = tmdempm("check", SCENE, "--set", "materials.steel.law.fracture_energy=3000", code=2).stderr
    expect("would snap back, expected cells of" in told, told)
