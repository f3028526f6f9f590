# timeout: 120
"""Pictures of a run, without a screen; and a run that goes on when there is nobody to draw them."""
import json
import struct
from e2e import *

IMAGES = """
images = ( { name = "heat"; field = "temperature"; map = "inferno"; size = [400, 300]; every = 0.02; },
           { name = "cell"; kind = "rve"; rve = "A"; field = "rotation"; map = "coolwarm"; size = [300, 320]; every = 0.04; },
           { name = "pair"; kind = "rve"; rve = "A"; before = true; field = "temperature"; size = [300, 320]; every = 0.04; } );
"""


def png_size(path):
    with open(path, "rb") as stream:
        data = stream.read()
    expect(data[:8] == b"\x89PNG\r\n\x1a\n" and data[-8:-4] == b"IEND", path + " is no whole PNG")
    return struct.unpack(">II", data[16:24])


with Folder() as f:
    cfg = f.write("s.cfg", COLUMN + IMAGES)

    # nobody to draw: one warning, what to install, and the run goes on
    os.environ["TMDEMPM_VIEWER"] = f("nobody")
    said = tmdempm("run", cfg, "--out", f("without"), "--until", 0.04).stderr
    expect(said.count("no pictures") == 1 and "install" in said, said)
    with open(f("without", "run.json"), encoding="utf-8") as stream:
        warnings = json.load(stream)["warnings"]
    expect(sum("no pictures" in w for w in warnings) == 1, "the warning is not in run.json: %s" % warnings)
    del os.environ["TMDEMPM_VIEWER"]

    sinks = {sink["name"]: sink for sink in json.loads(tmdempm("info", "--json").stdout)["sinks"]}
    if not sinks["images"]["available"]:
        skip("no viewer: " + sinks["images"]["install"])
    said = tmdempm("run", cfg, "--out", f("out"), "--until", 0.05).stdout
    names = ["heat_%08d" % step for step in (0, 200, 400, 500)] + ["%s_%08d" % (name, step) for name in ("cell", "pair") for step in (0, 400, 500)]
    expect(files_below(f("out", "images")) == sorted(name + ".png" for name in names), str(files_below(f("out", "images"))))
    for name in names:
        expect(png_size(f("out", "images", name + ".png")) == ((400, 300) if name.startswith("heat") else (300, 320)), name)
        expect("images/%s.png" % name in said, "%s is not announced:\n%s" % (name, said))
    expect(not [name for name in files_below(f("out")) if "birth" in name], "the start packing is written with every snapshot")
    # drawing changes nothing
    tmdempm("run", f.write("plain.cfg", COLUMN), "--out", f("plain"), "--until", 0.05)
    same_file(f("plain", "history.csv"), f("out", "history.csv"), "histories")
