# timeout: 180
"""Scripts of ParaView Catalyst: the ready ones write what they say; one that raises, one that leaves and one that crashes do not harm the
run; a script as ParaView exports it runs."""
import json
import struct
from live import *

needs_catalyst()

EXPORTED = """# script-version: 2.0
# Catalyst state generated using paraview version 5.11.0
import paraview
paraview.compatibility.major = 5
paraview.compatibility.minor = 11
from paraview.simple import *
paraview.simple._DisableFirstRenderCameraReset()
renderView1 = CreateView('RenderView')
renderView1.ViewSize = [400, 300]
points = PVDReader(registrationName='points', FileName='/somewhere/else/points.pvd')
pointsDisplay = Show(points, renderView1, 'GeometryRepresentation')
ColorBy(pointsDisplay, ('POINTS', 'velocity', 'Magnitude'))
pNG1 = CreateExtractor('PNG', renderView1, registrationName='PNG1')
pNG1.Trigger = 'TimeStep'
pNG1.Writer.FileName = 'view_{timestep:06d}{camera}.png'
pNG1.Writer.ImageResolution = [400, 300]
from paraview import catalyst
options = catalyst.Options()
options.GlobalTrigger = 'TimeStep'
options.EnableCatalystLive = 1
options.CatalystLiveTrigger = 'TimeStep'
if __name__ == '__main__':
    from paraview.simple import SaveExtractsUsingCatalystOptions
    SaveExtractsUsingCatalystOptions(options)
"""
RAISES = """# script-version: 2.0
def innermost(info):
    raise ValueError("the user's mistake")
def catalyst_execute(info):
    print("seen step", info.timestep, flush=True)
    if info.timestep >= 200:
        innermost(info)
"""
LEAVES = "# script-version: 2.0\nimport sys\ndef catalyst_execute(info):\n    sys.exit(3)\n"
CRASHES = "# script-version: 2.0\nimport os, signal\ndef catalyst_execute(info):\n    os.kill(os.getpid(), signal.SIGSEGV)\n"


def run(f, name, *options, code=0):
    said = tmdempm("run", f("s.cfg"), "--out", f(name), "--until", 0.04, *options, code=code)
    with open(f(name, "run.json"), encoding="utf-8") as stream:
        return said.stderr, json.load(stream)


def png_size(path):
    with open(path, "rb") as stream:
        return struct.unpack(">II", stream.read(24)[16:])


def ready(f):
    """pipelines/extracts.py and images.py, and an exported script, side by side."""
    f.write("exported.py", EXPORTED)
    said, report = run(f, "ready", "--pipeline", os.path.join(PIPELINES, "extracts.py"), "--pipeline",
                       os.path.join(PIPELINES, "images.py"), "--pipeline", f("exported.py"), "--pipeline",
                       os.path.join(PIPELINES, "cinema.py"))
    expect(not any("dropped" in w for w in report["warnings"]), said)
    expect("exported.py asks for a live connection" in said, said)
    files = os.listdir(f("ready", "catalyst"))
    for step in (0, 200, 400):
        for name in ("points", "domains", "walls", "rve_A_discs", "rve_A_contacts", "rve_B_discs"):
            expect("%s_%08d.vtp" % (name, step) in files, "no %s of step %d in %s" % (name, step, files))
        expect("grid_%08d.vti" % step in files, "no grid of step %d" % step)
        for name in ("temperature", "velocity", "strain_deviatoric", "rve_A", "rve_B"):
            size = png_size(f("ready", "catalyst", "%s_%08d.png" % (name, step)))
            expect(size == ((900, 800) if name.startswith("rve") else (1100, 850)), "%s is %s" % (name, size))
        expect(os.path.exists(f("ready", "catalyst", "datasets", "view_%06d.png" % step)) or
               os.path.exists(f("ready", "catalyst", "view_%06d.png" % step)), "the exported script has drawn nothing: %s" % files)
    expect(not [name for name in files if name.startswith(".")], "left over: %s" % files)
    with open(f("ready", "catalyst", "cinema.cdb", "data.csv"), encoding="utf-8") as stream:
        table = [line.split(",") for line in stream.read().splitlines()]
    expect(table[0][-1] == "FILE" and len(table) == 1 + 3 * 3, str(table))
    for row in table[1:]:
        expect(png_size(f("ready", "catalyst", "cinema.cdb", row[-1])) == (1100, 850), str(row))
    with open(f("ready", "catalyst", "points.vtp.series"), encoding="utf-8") as stream:
        times = [entry["time"] for entry in json.load(stream)["files"]]
    expect(len(times) == 3 and abs(times[-1] - 0.04) < 1e-9, str(times))
    with open(f("ready", "catalyst", "points_00000400.vtp"), "rb") as stream:
        mine = stream.read()
    expect(b"strain_deviatoric" in mine and b"void_ratio" in mine and b"units" in mine, "fields are missing")


def failing(f):
    """Each is dropped with its traceback; the good one goes on."""
    for name, text in (("raises.py", RAISES), ("leaves.py", LEAVES)):
        f.write(name, text)
    said, report = run(f, "failing", "--pipeline", f("raises.py"), "--pipeline", f("leaves.py"), "--pipeline",
                       os.path.join(PIPELINES, "extracts.py"))
    for words in ("raises.py dropped: Traceback", "in innermost", "ValueError: the user's mistake", "leaves.py dropped: Traceback",
                  "SystemExit: 3"):
        expect(words in said, "\"%s\" was not said:\n%s" % (words, said))
    expect("points_00000400.vtp" in os.listdir(f("failing", "catalyst")), "the good script has stopped")
    with open(f("failing", "log.txt"), encoding="utf-8") as stream:
        log = stream.read()
    expect("seen step 200" in log and "seen step 400" not in log, "what scripts print is not in the log, or it was not dropped")
    expect(report["state"] == "done", report["state"])


def crashing(f):
    """Started once more, then left; the run is done all the same, with the same bits."""
    f.write("crashes.py", CRASHES)
    said, report = run(f, "crashing", "--pipeline", f("crashes.py"))
    expect("starting it again" in said and "no more scripts" in said and report["state"] == "done", said)
    same_file(f("ready", "checkpoint.h5"), f("crashing", "checkpoint.h5"), "checkpoints")
    tmdempm("run", f("s.cfg"), "--out", f("nothing"), "--pipeline", f("no_such.py"), code=2)


with Folder() as f:
    f.write("s.cfg", COLUMN)
    ready(f)
    failing(f)
    crashing(f)
