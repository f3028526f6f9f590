"""What three grains between plates must show (DP-MPM section 4.5), at any size of cell."""
import csv
import os

from e2e import SOURCE_DIR, column, expect, files_below, tmdempm
from h5 import H5


class Crushed:
    """A run of one of the scenes and what its pieces say."""

    def __init__(self, folder, scene, *sets):
        self.full = not scene.endswith("quick")
        self.out = folder("_".join((scene,) + sets).translate(str.maketrans("=./[]", "_____")))
        tmdempm("run", os.path.join(SOURCE_DIR, "scenarios", "dp_mpm", scene + ".cfg"), "--out", self.out,
                *[word for text in ("images=()",) + sets for word in ("--set", text)], threads=os.cpu_count())
        tmdempm("fragments", self.out)
        with open(os.path.join(self.out, "fragments", "series.csv"), newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        self.series = {name.split(" ")[0]: [float(row[name]) for row in rows] for name in rows[0]}
        self.peak = max(abs(force) for force in column(self.out, "wall.plate.force_y [N]"))
        name = os.path.basename(self.out)
        print("%s: peak %.0f N, %d pieces, by area %.2f +- %.2f mm" % (name, self.peak, self.series["count"][-1],
              1e3 * self.series["diameter_mean_by_area"][-1], 1e3 * self.series["diameter_deviation_by_area"][-1]))

    def check(self):
        mean, spread = self.series["diameter_mean_by_area"], self.series["diameter_deviation_by_area"]
        # three whole grains first, then smaller ones of more sizes (by area: by number the dust decides)
        expect(self.series["count"][0] == 3 and self.series["count"][-1] > 10, "pieces: %s" % self.series["count"])
        expect(mean[-1] < 0.9 * mean[0], "the mean diameter does not fall: %s" % mean)
        expect(spread[-1] > 0.1 * mean[0], "the diameters are not spread: %s" % spread)
        if self.full: # coarse cells tear once
            expect(mean[-1] < mean[1] and spread[-1] > spread[1], "the pieces do not break further: %s, %s" % (mean, spread))
        expect(self.series["roundness"][0] > 0.97 and min(self.series["roundness"]) < 0.85, "pieces are as round as grains")
        residual = abs(column(self.out, "energy_residual [J]")[-1])
        expect(residual < 0.01 * column(self.out, "work_boundary [J]")[-1], "energy is missing: %g J" % residual)

    def check_first_cracks(self):
        """Where it is torn first between its contacts, the upper grain is torn from top to bottom."""
        for name in sorted(name for name in files_below(self.out) if name.startswith("snap" + os.sep)):
            snapshot = H5(os.path.join(self.out, name))
            x, damage = snapshot["points/position"], snapshot["points/damage"]
            torn = [(x[2 * i], x[2 * i + 1]) for i in range(len(damage)) if damage[i] > 0.9999
                    and abs(x[2 * i] - 4e-3) < 2e-3 and abs(x[2 * i + 1] - 15.8e-3) < 2e-3]
            if len(torn) > 20:
                break
        heights, columns = [y for _, y in torn], {round(place / 0.4e-3) for place, _ in torn}
        print("first cracks: %.2f mm high, in %d columns of 0.4 mm" % (1e3 * (max(heights) - min(heights)), len(columns)))
        expect(max(heights) - min(heights) > 2e-3, "the first cracks are not vertical")
        expect(len(columns) <= 6, "the grain is torn all over")

    def check_heat(self):
        """Warm where it is torn or touched, elsewhere as before."""
        name = sorted(name for name in files_below(self.out) if name.startswith("snap" + os.sep))[-1]
        snapshot = H5(os.path.join(self.out, name))
        warming = [t - 293.15 for t in snapshot["points/temperature"]]
        damage = snapshot["points/damage"]
        torn = [t for t, d in zip(warming, damage) if d > 0.9999]
        whole = sorted(abs(t) for t, d in zip(warming, damage) if d == 0.0)
        print("torn: %.2f K on average; whole: 90%% below %.2f K" % (sum(torn) / len(torn), whole[9 * len(whole) // 10]))
        expect(sum(torn) / len(torn) > 0.2, "what is torn is not warm")
        expect(whole[9 * len(whole) // 10] < 0.1 * sum(torn) / len(torn), "what is whole is warm")
