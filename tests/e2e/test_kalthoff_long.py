# labels: long
# timeout: 900
"""Kalthoff's plate at full size (DP-MPM section 4.3), straight and turned in the grid: angles, symmetry, heat, energy."""
import math
import os
import statistics

from e2e import Folder, SOURCE_DIR, column, expect, tmdempm, files_below
from h5 import H5


def run(folder, name):
    tmdempm("run", os.path.join(SOURCE_DIR, "scenarios", "dp_mpm", name + ".cfg"), "--out", folder(name), "--set", "images=()",
            threads=os.cpu_count())
    return folder(name)


def at(out, name, time):
    times = column(out, "time [s]")
    return column(out, name)[min(range(len(times)), key=lambda i: abs(times[i] - time))]


def heat(out):
    """How much colder than ambient it is around the upper tip, and how warm what has broken behind it, K."""
    newest = sorted(name for name in files_below(out) if name.startswith("snap" + os.sep))[-1]
    snapshot = H5(os.path.join(out, newest))
    x, temperature, damage = snapshot["points/position"], snapshot["points/temperature"], snapshot["points/damage"]
    tip = [column(out, "crack.upper.tip_%s [m]" % c)[-1] for c in "xy"]
    n, stride = len(temperature), len(x) // len(temperature)
    places = [(x[stride * i], x[stride * i + 1]) for i in range(n)]
    cold = min(temperature[i] for i in range(n) if damage[i] < 0.9 and math.dist(places[i], tip) < 3e-3)
    path = [temperature[i] for i in range(n) if damage[i] > 0.9999 and 0.05 < places[i][0] < tip[0] + 3e-3
            and 0.027 < places[i][1] < tip[1] - 3e-3]
    return cold - 293.15, statistics.median(path) - 293.15


with Folder() as folder:
    straight = run(folder, "kalthoff_33")
    angles = [at(straight, "crack.upper.angle [deg]", time) for time in (41.34e-6, 53.27e-6)]
    print("angles %.2f, %.2f deg" % tuple(angles))
    expect(64.0 <= angles[0] <= 71.0, "at 41.34 us the crack is at %g degrees" % angles[0])
    expect(63.0 <= angles[1] <= 71.0, "at 53.27 us the crack is at %g degrees" % angles[1])
    expect(abs(at(straight, "crack.lower.angle [deg]", 53.27e-6) + angles[1]) < 1.0, "the cracks do not mirror")
    work = column(straight, "work_boundary [J]")[-1]
    expect(abs(column(straight, "energy_residual [J]")[-1]) < 1e-3 * work, "energy is missing")
    cold, warm = heat(straight)
    print("tip %.2f K, path %+.2f K" % (cold, warm))
    expect(-1.5 < cold < -0.5, "the tip is at %g K" % cold)
    expect(2.0 < warm < 5.0, "the path is at %g K" % warm)
    turned = [at(run(folder, "kalthoff_33_turned%d" % turn), "crack.upper.angle [deg]", 53.27e-6) for turn in (30, 45)]
    print("turned by 30 and 45 degrees: %.2f, %.2f" % tuple(turned))
    spread = max(turned + angles[1:]) - min(turned + angles[1:])
    expect(spread <= 4.0, "the angle depends on the grid by %g degrees" % spread)
