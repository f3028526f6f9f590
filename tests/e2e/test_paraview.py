"""ParaView opens what a run has written: every .pvd, with all its times, cells and arrays."""
import shutil as sh
from e2e import *

READ = r"""
import sys
from paraview import servermanager
from paraview.simple import *

def read(name):
    reader = OpenDataFile(name)
    reader.UpdatePipelineInformation()
    times = list(reader.TimestepValues)
    reader.UpdatePipeline(times[-1])
    data = servermanager.Fetch(reader)
    while data.IsA('vtkCompositeDataSet'):
        data = data.GetBlock(0)
    arrays = data.GetPointData() if data.GetPointData().GetNumberOfArrays() > 1 else data.GetCellData()
    names = {}
    for i in range(arrays.GetNumberOfArrays()):
        a = arrays.GetArray(i)
        names[a.GetName()] = (a.GetNumberOfComponents(), a.GetNumberOfTuples(), a.GetRange(-1))
    for field in ('units', 'note'):
        texts = data.GetFieldData().GetAbstractArray(field)
        names[field] = [texts.GetValue(i) for i in range(texts.GetNumberOfValues())] if texts else []
    return times, data.GetNumberOfPoints(), data.GetNumberOfCells(), names, data.GetBounds()

for name in sys.argv[1:]:
    print(name.split('/')[-1], *read(name), sep='|')
"""

if not sh.which("pvpython"):
    skip("pvpython is not installed (python3-paraview)")

with Folder() as f:
    cfg = f.write("s.cfg", COLUMN)
    tmdempm("run", cfg, "--out", f("out"), "--until", 0.04)
    script = f.write("read.py", READ)
    series = ["points", "domains", "walls", "grid", "rve_A_discs", "rve_A_contacts", "rve_B_discs", "rve_B_contacts"]
    done = subprocess.run(["pvpython", script] + [f("out", name + ".pvd") for name in series], capture_output=True, text=True,
                          timeout=100)
    expect(done.returncode == 0, done.stdout + done.stderr)
    seen = {}
    for line in done.stdout.splitlines():
        if line.count("|") == 5:
            name, times, points, cells, arrays, bounds = line.split("|")
            seen[name.split(".")[0]] = (eval(times), int(points), int(cells), eval(arrays, {"nan": float("nan"), "inf": float("inf")}),
                                        eval(bounds))
    expect(sorted(seen) == sorted(series), done.stdout + done.stderr)
    for name, (times, points, cells, arrays, bounds) in seen.items():
        expect(len(times) == 3 and abs(times[-1] - 0.04) < 1e-12, "%s: times %s" % (name, times))
    times, points, cells, arrays, bounds = seen["points"]
    expect(points == cells == 16, "%d points in %d cells" % (points, cells))
    for name, components in (("velocity", 3), ("stress", 6), ("temperature", 1), ("void_ratio", 1), ("id", 1)):
        expect(arrays[name][0] == components and arrays[name][1] == 16, "%s: %s" % (name, arrays[name]))
    expect(19.9 < arrays["temperature"][2][0] < 21, "temperatures are not in C: %s" % (arrays["temperature"],))
    expect(0.39 < bounds[0] < bounds[1] < 0.61 and 0.1 < bounds[2], "the column is elsewhere: %s" % (bounds,))
    for word in ("velocity=m/s", "temperature=C", "stress=Pa"):
        expect(word in arrays["units"], "units: %s" % arrays["units"])
    times, points, cells, arrays, bounds = seen["domains"]
    expect(points == 64 and cells == 16 and arrays["stress"][:2] == (6, 16), "domains: %d %d %s" % (points, cells, arrays))
    times, points, cells, arrays, bounds = seen["grid"]
    expect(arrays["mass"][1] == points and arrays["mass"][2][1] > 0, "grid: %s" % (arrays,))
    times, points, cells, arrays, bounds = seen["rve_A_discs"]
    expect(len(arrays["note"]) == 1 and "kPa" in arrays["note"][0], "note of RVE A: %s" % arrays["note"])
    expect(points == 64 and 0.25e-3 <= arrays["radius"][2][0] < arrays["radius"][2][1] <= 0.51e-3, "discs: %s" % (arrays,))
    times, points, cells, arrays, bounds = seen["rve_A_contacts"]
    expect(cells > 30 and points == 2 * cells and arrays["normal_force"][2][1] > 0, "contacts: %d %s" % (cells, arrays))
