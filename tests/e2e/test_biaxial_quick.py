# labels: long
# timeout: 1800
"""Biaxial compression, dense and loose (TM-DEMPM section 5.3.1), quick: against the single RVE of the same packing."""
from e2e import *

CONFINING = 100e3  # Pa
HEIGHT, AREA = 2.0, 2.0  # m, m2


def single(f, mu):
    """-sigma_yy [Pa] and strain of one RVE of the scene's packing under the same load."""
    out = f("rve_%g.csv" % mu)
    tmdempm("rve", "load", "--pressure", CONFINING, "--mu-pack", mu, "--seed", 1, "--load", "biaxial", "--rate", 1,
            "--strain", 0.2, "--lateral", CONFINING, "--out", out)
    with open(out, newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    at = {name: k for k, name in enumerate(rows[0])}
    return ([-float(r[at["stress_yy [Pa]"]]) for r in rows[1:]], [-float(r[at["strain_yy [-]"]]) for r in rows[1:]])


def mean(values):
    return sum(values) / len(values)


def smooth(values, strain):
    """Means over 1% of strain: one RVE rattles by tens of kPa from row to row."""
    return [mean([v for v, e in zip(values, strain) if abs(e - at) <= 0.005]) for at in strain]


def specimen(f, name):
    """Stress on the plate per current width [Pa], strain, volume strain; checks what holds for any specimen."""
    out = f(name)
    tmdempm("run", os.path.join(SOURCE_DIR, "scenarios", "tm_dempm", name + ".cfg"), "--set", "images=()", "--out", out,
            threads=None)
    strain = [0.02 * t / HEIGHT for t in column(out, "time [s]")]
    volume = [v / AREA for v in column(out, "region.specimen.volume [m3]")]
    force = column(out, "wall.plate.force_y [N]")
    # the mean width: volume over height
    stress = [p / (v * AREA / (HEIGHT * (1.0 - e))) for p, v, e in zip(force, volume, strain)]
    base = column(out, "wall.base.force_y [N]")
    worst = max(abs(a + b) for a, b in list(zip(force, base))[20:]) / max(force)
    expect(worst < 0.05, "plate and base differ by %.1f %% of the largest force" % (100 * worst))

    work, heat = column(out, "work_boundary [J]")[-1], column(out, "heat_rve_friction [J]")[-1]
    residual = max(abs(r) for r in column(out, "energy_residual [J]"))
    expect(0.5 * work < heat < work, "%g J of heat from %g J of work" % (heat, work))
    expect(residual < 1e-3 * work, "the energy ledger is open by %g J of %g J" % (residual, work))
    warm, cool = column(out, "centre.temperature [C]")[-1] - 20.0, column(out, "top.temperature [C]")[-1] - 20.0
    expect(warm > 10.0 * cool > 0.0, "the band warms by %g K, the wedge under the plate by %g K" % (warm, cool))
    return stress, strain, [v - 1.0 for v in volume]


with Folder() as f:
    found = {}
    for name, mu in (("dense", 0.01), ("loose", 0.5)):
        rve_stress, rve_strain = single(f, mu)
        stress, strain, volume = specimen(f, "biaxial_%s_quick" % name)
        late = [s for s, e in zip(stress, strain) if e > 0.1]
        rve_late = [s for s, e in zip(rve_stress, rve_strain) if e > 0.1]
        peak = max(s for s, e in zip(smooth(stress, strain), strain) if e < 0.1)
        rve_peak = max(s for s, e in zip(smooth(rve_stress, rve_strain), rve_strain) if e < 0.1)
        print("%s: peak %.1f kPa (RVE %.1f), residual %.1f (%.1f), volume %+.2f %%"
              % (name, 1e-3 * peak, 1e-3 * rve_peak, 1e-3 * mean(late), 1e-3 * mean(rve_late), 100 * volume[-1]))
        found[name] = (peak, mean(late), volume[-1])
        # a specimen that bulges is wider in the middle, where it yields, than on the mean: it carries less than the RVE
        expect(0.8 < peak / rve_peak < 1.1, "%s: peak %g Pa, of the RVE %g Pa" % (name, peak, rve_peak))
        expect(0.8 < mean(late) / mean(rve_late) < 1.1, "%s: residual %g Pa, of the RVE %g Pa"
               % (name, mean(late), mean(rve_late)))
    expect(found["dense"][0] > 1.3 * found["dense"][1], "the dense specimen does not soften")
    expect(found["loose"][0] < 1.25 * found["loose"][1], "the loose specimen softens")
    expect(found["dense"][2] > found["loose"][2], "the dense specimen dilates no more than the loose one")
