#!/usr/bin/env python3
# What a run records of an RVE, replayed alone, gives the same bits.
# timeout: 120
import csv
import os
import subprocess
import unittest

from e2e import COLUMN, TMDEMPM, Folder


def rows_of(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


class Replay(unittest.TestCase):
    def tmdempm(self, folder, *arguments):
        done = subprocess.run([TMDEMPM, *map(str, arguments)], cwd=folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def compare(self, folder, set_options):
        """The run's history of point A against its path replayed."""
        self.tmdempm(folder, "run", "column.cfg", "--out", "out", "--threads", 1, "--quiet", *set_options)
        self.tmdempm(folder, "rve", "load", "--scene", "column.cfg", "--load", "path", "--path", "out/rve/A_path.csv",
                     "--out", "A.csv", *set_options)
        history, curve = rows_of(os.path.join(folder, "out", "history.csv")), rows_of(os.path.join(folder, "A.csv"))
        self.assertGreater(len(history), 50)
        flowing = 0
        for row in history:
            alone = curve[int(row["step [-]"])]
            for name in "stress_xx [Pa]", "stress_yy [Pa]", "stress_xy [Pa]", "void_ratio [-]", "coordination [-]":
                self.assertEqual(row["A." + name], alone[name], "step %s, %s" % (row["step [-]"], name))
            flowing += float(alone["sliding_fraction [-]"]) > 0.0
        self.assertGreater(flowing, 10)

    def test_replay_gives_the_same_bits(self):
        with Folder() as folder:
            with open(os.path.join(folder.path, "column.cfg"), "w") as stream:
                stream.write(COLUMN)
            self.compare(folder.path, [])

    def test_overrides_of_the_scene_are_followed(self):
        with Folder() as folder:
            with open(os.path.join(folder.path, "column.cfg"), "w") as stream:
                stream.write(COLUMN)
            self.compare(folder.path, ["--set", "materials.[0].law.strain_per_step=2e-5", "--set", "materials.[0].law.mu=0.3"])

    def test_wrong_laws_are_refused(self):
        with Folder() as folder:
            with open(os.path.join(folder.path, "column.cfg"), "w") as stream:
                stream.write(COLUMN)
            for law, code in ("sand", 0), ("clay", 2):
                done = subprocess.run(
                    [TMDEMPM, "rve", "load", "--scene", "column.cfg", "--law", law, "--load", "isochoric", "--rate", "1",
                     "--strain", "1e-4", "--out", "x.csv"], cwd=folder.path, capture_output=True, text=True)
                self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn('column.cfg has no RVE law "clay"', done.stderr)
            done = subprocess.run(
                [TMDEMPM, "rve", "load", "--scene", "column.cfg", "--set", "materials.[0].law.nu=1", "--load", "isochoric",
                 "--rate", "1", "--strain", "1e-4", "--out", "y.csv"], cwd=folder.path, capture_output=True, text=True)
            self.assertEqual(done.returncode, 2)
            self.assertFalse(os.path.exists(os.path.join(folder.path, "y.csv")))


if __name__ == "__main__":
    unittest.main()
