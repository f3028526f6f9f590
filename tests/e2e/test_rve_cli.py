#!/usr/bin/env python3
# `tmdempm rve pack|load|info` as a user has it.
# timeout: 300
import csv
import math
import os
import re
import signal
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ.get("TMDEMPM", "tmdempm")
COLUMNS = (
    "strain_xx [-],strain_yy [-],strain_vol [-],stress_xx [Pa],stress_yy [Pa],stress_xy [Pa],void_ratio [-],"
    "coordination [-],sliding_fraction [-],work [J],friction_heat [J],dashpot [J],bond [J],elastic [J],kinetic [J],"
    "conductivity_xx [W/(m K)],conductivity_yy [W/(m K)]"
).split(",")

folder = tempfile.TemporaryDirectory(prefix="tmdempm-rve-cli-")
os.environ["XDG_CACHE_HOME"] = os.path.join(folder.name, "cache")


def path(name):
    return os.path.join(folder.name, "work", name)


def contents(name):
    with open(path(name), "rb") as stream:
        return stream.read()


def put(name, text):
    with open(path(name), "w") as stream:
        stream.write(text)


def rve(*arguments):
    return subprocess.run(
        [PROGRAM, "rve", *map(str, arguments)], capture_output=True, text=True, cwd=os.path.join(folder.name, "work")
    )


def read_curve(name):
    with open(path(name), newline="") as stream:
        rows = list(csv.reader(stream))
    assert rows[0] == COLUMNS, rows[0]
    names = [cell.split(" ")[0] for cell in rows[0]]
    return [dict(zip(names, map(float, row))) for row in rows[1:]]


def work_folder():
    return sorted(os.listdir(os.path.join(folder.name, "work")))


class RveCommands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        os.mkdir(os.path.join(folder.name, "work"))
        for arguments in (
            ["--discs", 400, "--pressure", "100e3", "--mu", 0.5, "--seed", 1, "--out", "P.h5"],
            ["--discs", 100, "--pressure", "20e3", "--mu", 0.3, "--seed", 2, "--out", "small.csv"],
        ):
            done = rve("pack", *arguments)
            assert done.returncode == 0, done.stderr
            assert arguments[-1] in done.stdout, done.stdout

    def curve(self, *arguments, packing="P.h5", out="curve.csv"):
        done = rve("load", "--packing", packing, *arguments, "--out", out)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return read_curve(out)

    def closes(self, rows, bound):
        """What the stress did is stored, moving, or turned into heat, in every row."""
        done = rows[-1]["work"] - rows[0]["work"]
        for row in rows:
            ends = sum(row[k] for k in ("elastic", "kinetic", "friction_heat", "dashpot", "bond"))
            self.assertLess(abs(row["work"] - ends), bound * done)

    # ---- pack ----

    def test_a_packing_is_a_function_of_its_options(self):
        options = ["--discs", 100, "--pressure", "20e3", "--mu", 0.3]
        for out, seed in ("a.csv", 2), ("b.csv", 3):
            self.assertEqual(rve("pack", *options, "--seed", seed, "--out", out).returncode, 0)
        cache = os.environ["XDG_CACHE_HOME"]
        os.environ["XDG_CACHE_HOME"] = os.path.join(folder.name, "another")  # made again, not found again
        self.assertEqual(rve("pack", *options, "--seed", 2, "--out", "c.csv").returncode, 0)
        os.environ["XDG_CACHE_HOME"] = cache
        texts = [contents(name) for name in ("a.csv", "b.csv", "c.csv", "small.csv")]
        self.assertEqual(texts[0], texts[2])
        self.assertEqual(texts[0], texts[3])
        self.assertNotEqual(texts[0], texts[1])

    def test_a_square_lattice_and_a_void_ratio_can_be_asked_for(self):
        done = rve("pack", "--discs", 100, "--pressure", "100e3", "--lattice", "square", "--radius-max", "5e-3",
                   "--out", "square.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        info = rve("info", "square.h5").stdout
        self.assertIn("radii 0.005 to 0.005", info)
        self.assertIn("coordination 4.0000", info)
        done = rve("pack", "--discs", 100, "--pressure", "50e3", "--void-ratio", "0.20", "--out", "e.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        info = rve("info", "e.h5").stdout
        line = [line for line in info.splitlines() if line.startswith("void ratio")][0]
        self.assertAlmostEqual(float(line.split()[2]), 0.20, delta=0.002)

    # ---- info ----

    def test_info_says_what_is_in_a_packing(self):
        done = rve("info", "P.h5")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        facts = {line[:14].strip(): line[15:] for line in done.stdout.splitlines()}
        self.assertTrue(facts["discs"].startswith("400,"))
        self.assertAlmostEqual(float(facts["pressure"].split()[0]), 100e3, delta=1e3)
        self.assertTrue(0.19 < float(facts["void ratio"]) < 0.25)
        for name in "cell", "made", "stress", "contacts", "conductivity", "elastic tensor", "anisotropy":
            self.assertIn(name, facts)
        self.assertIn("discs          100", rve("info", "small.csv").stdout)

    # ---- load ----

    def test_isochoric(self):
        rows = self.curve("--load", "isochoric", "--rate", 1, "--strain", 0.02, "--rows", 50)
        self.assertEqual(len(rows), 51)
        self.assertEqual(rows[0]["strain_xx"], 0.0)
        self.assertAlmostEqual(rows[-1]["strain_xx"], 0.02, places=10)
        for row in rows:
            self.assertAlmostEqual(row["strain_vol"], 0.0, places=12)
            self.assertAlmostEqual(row["void_ratio"], rows[0]["void_ratio"], places=9)
            self.assertLess(row["stress_yy"], 0.0)
        self.assertGreater(rows[-1]["friction_heat"], 0.0)
        self.closes(rows, 5e-3)

    def test_biaxial_holds_its_lateral_stress(self):
        rows = self.curve("--load", "biaxial", "--rate", 1, "--strain", 0.03, "--strain-per-step", 2e-5)
        self.assertEqual(len(rows), 201)
        for row in rows:
            self.assertLess(abs(row["stress_xx"] + 100e3), 1e3)
        self.assertAlmostEqual(rows[-1]["strain_yy"], -0.03, places=9)
        self.assertGreater(max(-row["stress_yy"] for row in rows), 150e3)

    def test_biaxial_at_another_pressure_consolidates_first(self):
        rows = self.curve("--load", "biaxial", "--lateral", "50e3", "--rate", 1, "--strain", 0.002)
        self.assertAlmostEqual(rows[0]["strain_yy"], 0.0, places=14)
        self.assertEqual(rows[0]["friction_heat"], 0.0)
        self.assertAlmostEqual(rows[0]["work"], rows[0]["elastic"] + rows[0]["kinetic"], places=15)
        for row in rows:
            self.assertLess(abs(row["stress_xx"] + 50e3), 500)
        self.assertLess(abs(rows[0]["stress_yy"] + 50e3), 500)

    def test_shear_keeps_the_volume(self):
        rows = self.curve("--load", "shear", "--rate", 10, "--strain", 0.1, packing="small.csv")
        self.assertAlmostEqual(rows[-1]["strain_vol"], 0.0, places=12)
        # ln U of [1 g; 0 1]: its eigenvalues are +- asinh(g/2)
        # and the stretched direction lies at atan(2/g)/2 from x, so xx = -asinh(g/2) cos(atan(2/g))
        last = rows[-1]
        self.assertAlmostEqual(last["strain_xx"], -math.asinh(0.05) * math.cos(math.atan2(2.0, 0.1)), places=8)
        self.assertGreater(last["stress_xy"], 0.0)

    def test_iso_reaches_its_pressure(self):
        rows = self.curve("--load", "iso", "--lateral", "200e3", "--rate", 1, "--strain", 0.05)
        for name in "stress_xx", "stress_yy":
            self.assertAlmostEqual(rows[-1][name], -200e3, delta=2e3)
        self.assertLess(rows[-1]["strain_vol"], 0.0)

    def test_iso_says_when_it_does_not_get_there(self):
        done = rve("load", "--packing", "P.h5", "--load", "iso", "--lateral", "1e6", "--rate", 1, "--strain", 1e-3, "--out",
                   "short.csv")
        self.assertEqual(done.returncode, 0)
        self.assertIn("warning: the pressure is not reached", done.stderr)

    def test_a_guard_ends_the_curve_and_says_so(self):
        done = rve("load", "--packing", "P.h5", "--load", "iso", "--lateral", "2e8", "--rate", 100, "--strain", 2, "--out",
                   "crushed.csv")
        self.assertEqual(done.returncode, 3)
        rows = read_curve("crushed.csv")
        self.assertIn("crushed.csv ends after %d rows" % len(rows), done.stderr)
        self.assertLess(len(rows), 201)

    def test_heat_before_the_load_raises_the_pressure(self):
        cold = self.curve("--load", "isochoric", "--rate", 1, "--strain", 0)
        warm = self.curve("--load", "isochoric", "--rate", 1, "--strain", 0, "--temperature", 20)
        self.assertEqual((len(cold), len(warm)), (1, 1))
        self.assertLess(warm[0]["stress_xx"], cold[0]["stress_xx"])
        # eq. 37: area grows by 2 beta dT
        self.assertAlmostEqual(1 + warm[0]["void_ratio"], (1 + cold[0]["void_ratio"]) / (1 + 20e-4) ** 2, places=9)

    def test_a_path_is_replayed_to_the_bit_and_row_by_row(self):
        with open(path("path.csv"), "w") as stream:
            stream.write("duration [s],L11 [1/s],L12 [1/s],L21 [1/s],L22 [1/s],dT [K]\n")
            for k in range(30):
                stream.write("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n" % (1e-4, 0.3, -1.0 / 3, 2.0, -0.3, 0.01))
        rows = self.curve("--load", "path", "--path", "path.csv")
        self.assertEqual(len(rows), 31)
        self.curve("--load", "path", "--path", "path.csv", out="again.csv")
        self.assertEqual(contents("curve.csv"), contents("again.csv"))
        few = self.curve("--load", "path", "--path", "path.csv", "--rows", 3)
        self.assertEqual([few[1], few[3]], [rows[10], rows[30]])

    def test_bonds_bear_and_melt(self):
        arguments = ["load", "--packing", "P.h5", "--load", "isochoric", "--rate", 1, "--strain", 0.02, "--out", "bonded.csv"]

        def bonded(*more):
            done = rve(*arguments, *more)
            self.assertEqual(done.returncode, 0, done.stderr)
            intact, installed = re.search("bonds: ([0-9]+) of ([0-9]+) intact", done.stdout).groups()
            return int(intact), int(installed), read_curve("bonded.csv")

        loose = self.curve(*arguments[3:-2])
        intact, installed, strong = bonded("--bond-beta", 0.1)
        self.assertGreater(intact, 0.5 * installed)
        self.assertGreater(strong[-1]["stress_xx"] - strong[-1]["stress_yy"], 2 * (loose[-1]["stress_xx"] - loose[-1]["stress_yy"]))
        self.assertGreater(bonded("--bond-beta", 0.1, "--bond-melting", 5, "--temperature", 4)[0], 0)
        intact, installed, melted = bonded("--bond-beta", 0.1, "--bond-melting", 5, "--temperature", 6)
        self.assertEqual(intact, 0)
        warm = self.curve(*arguments[3:-2], "--temperature", 6)
        self.assertAlmostEqual(melted[-1]["stress_yy"] / warm[-1]["stress_yy"], 1, delta=0.5)
        self.assertEqual(bonded("--bond-beta", 0.1, "--mu-bond", 0)[0], 0)
        put("plain.csv", "1e-4,0,0,0,0,0\n")
        self.refused("plain.csv has no column that says when", "load", "--packing", "P.h5", "--load", "path", "--path", "plain.csv",
                     "--out", "x.csv", "--bond-beta", 0.1)
        put("short.csv", "1e-4,0,0,0,0\n")
        self.refused("short.csv:1: 5 cells, expected duration,L11", "load", "--packing", "P.h5", "--load", "path", "--path",
                     "short.csv", "--out", "x.csv")

    def test_a_packing_can_be_made_on_the_way(self):
        done = rve("load", "--discs", 100, "--pressure", "20e3", "--mu-pack", 0.3, "--seed", 2, "--load", "isochoric",
                   "--rate", 1, "--strain", 1e-3, "--out", "made.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(read_curve("made.csv")), 201)

    def test_the_curve_is_the_same_every_time(self):
        arguments = ["--load", "biaxial", "--rate", 1, "--strain", 0.002]
        self.curve(*arguments, out="first.csv")
        self.curve(*arguments, out="second.csv")
        self.assertEqual(contents("first.csv"), contents("second.csv"))

    # ---- bad usage ----

    def refused(self, words, *arguments, code=2):
        before = work_folder()
        done = rve(*arguments)
        self.assertEqual(done.returncode, code, "%s: %s" % (arguments, done.stderr))
        self.assertIn(words, done.stderr)
        self.assertEqual(done.stdout, "")
        self.assertEqual(work_folder(), before)

    def test_help(self):
        for arguments in ["--help"], ["pack", "--help"], ["load", "-h"], ["info", "--help"]:
            done = rve(*arguments)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn("usage: tmdempm rve", done.stdout)

    def test_bad_usage(self):
        self.refused("usage: tmdempm rve pack|load|info")
        self.refused('unknown verb "unpack"', "unpack")
        pack = ["pack", "--pressure", "10e3", "--mu", "0.5", "--discs", "100"]
        self.refused("--out is missing", *pack)
        self.refused("expected a name that ends in .h5 or .csv", *pack, "--out", "P.vtk")
        self.refused("--pressure is missing", "pack", "--mu", "0.5", "--out", "x.h5")
        self.refused("--mu is missing", "pack", "--pressure", "1e4", "--out", "x.h5")
        self.refused('--discs is "4.5", expected a whole number', *pack, "--discs", "4.5", "--out", "x.h5")
        self.refused('--pressure is "-1", expected a pressure above 0', *pack, "--pressure", "-1", "--out", "x.h5")
        self.refused('--pressure is "10 kPa"', *pack, "--pressure", "10 kPa", "--out", "x.h5")
        self.refused('--mu is "nan"', *pack, "--mu", "nan", "--out", "x.h5")
        self.refused("--radius-min 0.001 is above --radius-max 0.0005", *pack, "--radius-min", "1e-3", "--out", "x.h5")
        self.refused('--lattice is "hexagonal", expected square', *pack, "--lattice", "hexagonal", "--out", "x.h5")
        self.refused("expected one", *pack, "--void-ratio", "0.2", "--out", "x.h5")
        self.refused("unknown option --colour", *pack, "--colour", "red")
        self.refused("--seed has no value", *pack, "--seed")
        self.refused('unexpected argument "P.h5"', *pack, "P.h5")
        self.refused("a square number", *pack, "--lattice", "square", "--discs", "99", "--out", "x.h5")
        self.refused("No such file", *pack, "--out", "no/such/x.h5", code=4)

    def test_bad_usage_of_load(self):
        load = ["load", "--packing", "small.csv", "--out", "x.csv"]
        iso = [*load, "--load", "isochoric"]
        self.refused("--load is missing", *load)
        self.refused('--load is "triaxial", expected isochoric, biaxial, shear, iso or path', *load, "--load", "triaxial")
        self.refused("--rate is missing", *iso, "--strain", 1)
        self.refused("--strain is missing", *iso, "--rate", 1)
        self.refused('--rate is "0", expected a strain rate above 0', *iso, "--rate", 0, "--strain", 1)
        self.refused("--lateral is given with --load isochoric", *iso, "--rate", 1, "--strain", 1, "--lateral", 1)
        self.refused("--path is given with --load isochoric", *iso, "--rate", 1, "--strain", 1, "--path", "p.csv")
        self.refused("--path is missing", *load, "--load", "path")
        self.refused("the file says them", *load, "--load", "path", "--path", "p.csv", "--rate", 1)
        self.refused("--lateral is missing", *load, "--load", "biaxial", "--rate", 1, "--strain", 0.1)
        self.refused('--rows is "0"', *iso, "--rate", 1, "--strain", 1, "--rows", 0)
        self.refused("--bond-beta is 0.2, expected less than the skin of 0.2", *iso, "--rate", 1, "--strain", 1, "--bond-beta", 0.2)
        self.refused('--mu-bond is "-1", expected a ratio', *iso, "--rate", 1, "--strain", 1, "--mu-bond", -1)
        self.refused("--packing is missing", "load", "--load", "isochoric", "--rate", 1, "--strain", 1, "--out", "x.csv")
        self.refused("expected a name that ends in .csv", "load", "--packing", "small.csv", "--load", "isochoric", "--rate",
                     1, "--strain", 1, "--out", "x.h5")
        self.refused("--law is given without --scene", *iso, "--rate", 1, "--strain", 1, "--law", "sand")
        self.refused("absent.csv: No such file", "load", "--packing", "absent.csv", "--load", "isochoric", "--rate", 1,
                     "--strain", 1, "--out", "x.csv", code=4)
        self.refused("expected one packing", "info")
        self.refused("expected one packing", "info", "a", "b")

    def test_bad_files_are_told_with_their_line(self):
        put("bad.csv", "# H 1e-2 0 0 1e-2\n1,0,0,1e-3\n2,0,0,-1e-3\n")
        put("badpath.csv", "1e-4,0,0,0,0,0\n-1,0,0,0,0,0\n")
        put("empty.csv", "duration,L11,L12,L21,L22,dT\n")
        self.refused("bad.csv:3: its radius is -0.001, expected a positive number", "info", "bad.csv")
        path_load = ["load", "--packing", "small.csv", "--load", "path", "--out", "x.csv", "--path"]
        self.refused("badpath.csv:2: the duration is -1, expected a positive number", *path_load, "badpath.csv")
        self.refused("empty.csv: no rows", *path_load, "empty.csv")

    def test_an_interrupt_leaves_the_old_curve(self):
        put("kept.csv", "old")
        before = work_folder()
        run = start(
            [PROGRAM, "rve", "load", "--packing", "P.h5", "--load", "isochoric", "--rate", "1", "--strain", "1000",
             "--out", "kept.csv"], cwd=path(""), stderr=subprocess.PIPE, text=True)
        while work_folder() == before and run.poll() is None:
            time.sleep(0.01)  # until its temporary file is there
        run.send_signal(signal.SIGINT)
        self.assertIn("interrupted", run.communicate()[1])
        self.assertEqual(run.returncode, 130)
        self.assertEqual(contents("kept.csv"), b"old")
        self.assertEqual(work_folder(), before)


if __name__ == "__main__":
    unittest.main(verbosity=1)
