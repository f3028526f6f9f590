# timeout: 180
"""A running silo that a real ParaView client watches and steers: late, with the values of the run's files; it has another
RVE inspected, pauses, steps, goes on, and is killed in a pause: the run goes on, and a second client stops it."""
import csv as table
import json
from live import *

needs_catalyst()
SILO = """
base = "%s/scenarios/tm_dempm/silo_forced_quick.cfg";
set = ("images=()", "bodies.[0].points_per_cell=1", "time.end=1000.0", "output.history_every=0.04", "output.vtk=false",
       "output.snapshot_every=0.002", "output.checkpoint_every=0", "catalyst.live.every=5", "catalyst.live.share=1.0");
""" % SOURCE_DIR

with Folder() as f:
    port, out = free_port(), f("out")
    run = Simulation(f.write("silo.cfg", SILO), out, "--live", port)
    run.wait_for("waits for a ParaView")
    run.wait_for("steps of")
    wait(1.0)
    client = os.path.join(HERE, "live_client.py")
    first = pvpython(client, "first", port, out)
    said = first.communicate(timeout=120)[0]
    expect(first.returncode == -9, "the first client was not killed but ended with %d:\n%s\n%s" % (first.returncode, said, run.text()))
    expect(all(word in said for word in ("compared", "inspected", "paused")), said)
    run.wait_for("ParaView has gone")
    second = pvpython(client, "second", port, out)
    said = second.communicate(timeout=60)[0]
    expect(second.returncode == 0 and "second" in said, said + run.text())
    run.end(code=130)
    with open(os.path.join(out, "run.json"), encoding="utf-8") as stream:
        report = json.load(stream)
    live = report["viewers"]["live"]
    expect(live["clients"] == 2 and live["shown"] > 5 and 0 < report["viewers"]["share"] < 1, str(report["viewers"]))
    expect(report["state"] == "interrupted", report["state"])
    with open(os.path.join(out, "steering.csv"), newline="", encoding="utf-8") as stream:
        rows = [row[2:] for row in table.reader(stream)][1:]
    expect(["paraview", "inspect.A=point:30"] in rows and ["paraview", "stop=1"] in rows, str(rows))
