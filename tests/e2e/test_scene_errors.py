"""Twenty wrong scenes, twenty clear messages: exit 2, file and line, what is wrong, what was expected, nothing
written.  Each case replaces one piece of a good scene; the message is due on the line of the replacement."""
# timeout: 120
import os
import re
import subprocess
import sys
import tempfile

TMDEMPM = os.path.abspath(os.environ["TMDEMPM"])

GOOD = """\
units = { temperature = "C"; };
grid = {
	origin = [-0.2, -0.2];
	size = [1.4, 1.2];
	cell = 0.1;
};
time = {
	end = 0.01;
	step = 1e-4;
};
gravity = [0.0, -9.8];
materials = (
	{
		name = "rubber";
		density = 1000.0;
		heat_capacity = 1500.0;
		conductivity = 0.2;
		law = { type = "thermoelastic"; young = 1e6; poisson = 0.3; };
	}
);
bodies = (
	{ name = "block"; material = "rubber"; box = [0.0, 0.0, 0.5, 0.5]; temperature = 20.0; }
);
walls = (
	{ name = "ground"; line = ([-0.2, 0.0], [1.2, 0.0]); friction = 0.5; },
	{ name = "post"; box = [0.6, 0.0, 0.8, 0.4]; }
);
probes = ( { name = "middle"; material = [0.25, 0.25]; } );
output = { snapshot_every = 0.0; };
images = ( );
"""

# piece of the good scene, what stands there instead, what the message says
WRONG = [
    ("cell = 0.1;", "cel = 0.1;", r"grid\.cel is not known, expected .*did you mean 'cell'"),
    ("density = 1000.0;", "density = -1000.0;", r"density is -1000, expected a number > 0 \(kg/m3\)"),
    ("density = 1000.0;", 'density = "heavy";', r"density is a string, expected a number > 0 \(kg/m3\)"),
    ("density = 1000.0;", "density = 1e999;", r"density is inf, expected a finite number"),
    ("poisson = 0.3;", "poisson = 0.6;", r"poisson is 0\.6, expected a number between -1 and 0\.5"),
    ("poisson = 0.3;", "", r"poisson is missing, expected a number between -1 and 0\.5"),
    ("poisson = 0.3;", 'poisson = 0.3; elasticity = "neo_hookean"; plane = "stress";',
     r'plane is "stress", expected "strain" with elasticity = "neo_hookean"'),
    ("step = 1e-4;", "step = 0.0;", r"time\.step is 0, expected a number > 0 \(s\)"),
    ("step = 1e-4;", "step = 5e-3;", r"time\.step is 0\.005 s, over the limit of material 'rubber', expected at most"),
    ("end = 0.01;", "end = 1e-6;", r"time\.end is 1e-06 s, expected at least one step"),
    ("size = [1.4, 1.2];", "size = [1.45, 1.2];", r"grid\.size is 1\.45 m in x, expected a whole number of cells"),
    ("box = [0.0, 0.0, 0.5, 0.5]", "box = [0.0, 0.0, 0.5, 1.5]", r"box reaches y = 1\.5 m, outside the grid, expected"),
    ("box = [0.0, 0.0, 0.5, 0.5]", "polygon = ([0,0], [0.5,0.5], [0.5,0], [0,0.5])", r"cuts or touches itself"),
    ("box = [0.0, 0.0, 0.5, 0.5]", "ring = [0.3, 0.3, 0.3, 0.2]", r"ring has radii 0\.3 and 0\.2, expected .*inner < outer"),
    ("box = [0.0, 0.0, 0.5, 0.5]", "disc = [0.3, 0.3, 0.0]", r"disc has radius 0, expected .* radius > 0"),
    ("box = [0.0, 0.0, 0.5, 0.5]", "disc = [0.3, 0.3, 2.0]", r"disc reaches x = 2\.3 m, outside the grid"),
    ("temperature = 20.0;", 'motion = { solution = "rod"; };', r'solution is "rod", expected one of .*axis_aligned, vortex'),
    ("temperature = 20.0;", 'motion = { solution = "vortex"; parameters = ("amplitud=1"); };',
     r"parameters has amplitud=1: expected parameter=value .*inner, outer, amplitude"),
    ("temperature = 20.0;", 'motion = { parameters = ("amplitude=1"); };', r"parameters are given without a solution"),
    ("temperature = 20.0;", 'motion = { solution = "expanding_ring"; };', r"motion is not defined at \(0\.025, 0\.025\), expected"),
    ("box = [0.6, 0.0, 0.8, 0.4]", "box = [0.4, 0.0, 0.8, 0.4]", r"stands in body 'block' at the start: 16 of its points"),
    ("box = [0.6, 0.0, 0.8, 0.4]", "wedge = [0.6, 0.0, 0.0, 0.4]", r"cuts or touches itself|has no area"),
    ('material = "rubber"', 'material = "ruber"', r'"ruber" is not defined, expected .*did you mean "rubber"'),
    ('name = "post"', 'name = "ground"', r'name is "ground" again, expected a name of its own'),
    ("temperature = 20.0;", "temperature = -300.0;", r"is -300, below absolute zero, expected at least -273\.15 C"),
    ("temperature = 20.0;", "points_per_cell = 6;", r"points_per_cell is 6, expected 1, 4, 9 or 16"),
    ("material = [0.25, 0.25]", "material = [0.75, 0.25]", r"is \(0\.75, 0\.25\), in no body, expected a place in one"),
    ("images = ( );", 'images = ( { name = "T"; field = "temperature"; range = [30.0, 10.0]; } );',
     r"range is \[30, 10\], expected min < max"),
    ("images = ( );", 'images = ( { name = "T"; field = "temprature"; } );',
     r'field is "temprature", expected one of velocity, .*temperature'),
    ("images = ( );", 'images = ( { name = "T"; field = "temperature"; unit = "kPa"; } );',
     r'\.unit is "kPa", in which temperature cannot be shown, expected C, the scene\'s unit'),
    ("images = ( );", 'images = ( { name = "S"; field = "stress"; component = "xy"; unit = "m"; } );',
     r'\.unit is "m", in which stress cannot be shown, expected Pa'),
    ("images = ( );", 'images = ( { name = "T"; field = "temperature"; component = "xy"; } );',
     r"component is no component of the scalar temperature, expected magnitude"),
    ("cell = 0.1;", "cell = 0.1; cell = 0.2;", r"'cell' is defined twice, expected once"),
    ("friction = 0.5;", "friction = 99999999999999999999;", r"does not fit 64 bits, expected"),
    ('units = { temperature = "C"; };', '@include "units.cfg"', r"cannot read '.*units\.cfg' .*, expected a scene file"),
    ("gravity = [0.0, -9.8];", "gravity = [0.0, -9.8;", r"expected"),
]


def tmdempm(folder, *arguments):
    return subprocess.run([TMDEMPM, *arguments], cwd=folder, capture_output=True, text=True, timeout=60)


def fail(what, result):
    sys.exit(f"{what}\nexit {result.returncode}\nstdout: {result.stdout}\nstderr: {result.stderr}")


def expect_refusal(folder, command, line, pattern):
    """Exit 2, the message at its line, and nothing written."""
    before = sorted(os.listdir(folder))
    result = tmdempm(folder, *command)
    if result.returncode != 2:
        fail(f"{command}: exit 2 expected", result)
    where = "wrong.cfg" + (f":{line}" if line else "")
    if not re.search(rf"^(\S*/)?{where}: .*({pattern})", result.stderr, re.MULTILINE):
        fail(f"{command}: expected {where}: {pattern}", result)
    if sorted(os.listdir(folder)) != before:
        sys.exit(f"{command} wrote {sorted(os.listdir(folder))}")


def main():
    with tempfile.TemporaryDirectory() as folder:
        scene = os.path.join(folder, "wrong.cfg")
        with open(scene, "w") as out:
            out.write(GOOD)
        result = tmdempm(folder, "check", "wrong.cfg")
        if result.returncode != 0 or os.listdir(folder) != ["wrong.cfg"]:
            fail("the good scene passes and check writes nothing", result)
        for old, new, pattern in WRONG:
            assert GOOD.count(old) == 1, old
            line = GOOD[: GOOD.index(old)].count("\n") + 1
            with open(scene, "w") as out:
                out.write(GOOD.replace(old, new))
            expect_refusal(folder, ["check", "wrong.cfg"], line, pattern)
            expect_refusal(folder, ["run", "wrong.cfg", "--out", "out"], line, pattern)
        with open(scene, "w") as out:
            out.write(GOOD)
        for assignment, pattern in [("grid.cel=0.1", r"grid\.cel is not known, .*grid\.cell"),
                                    ("walls.[5].friction=0.1", r"no entry '\[5\]'"),
                                    ("time.step=-1", r"time\.step is -1, expected a number > 0")]:
            result = tmdempm(folder, "run", "wrong.cfg", "--out", "out", "--set", assignment)
            if result.returncode != 2 or not re.search(f"--set {re.escape(assignment)}: .*{pattern}", result.stderr):
                fail(f"--set {assignment}: expected {pattern}", result)
        if os.listdir(folder) != ["wrong.cfg"]:
            sys.exit(f"written: {os.listdir(folder)}")
    print(f"{len(WRONG)} wrong scenes refused")


main()
