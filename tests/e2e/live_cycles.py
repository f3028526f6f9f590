"""For pvpython: live_cycles.py PORT N PIPELINES, N clients one after the other, each a process of its own that looks at some frames and
ends in another way: by leaving, by exit, killed, killed while it pauses the simulation, killed while it connects.
Prints a line for each."""
import os
import signal
import sys
import time

port, cycles = int(sys.argv[1]), int(sys.argv[2])
sys.path.insert(0, sys.argv[3])
from tmdempm_live import Run, listen

ENDS = ("leaves", "exits", "killed", "killed in a pause", "killed early")


def client(how):
    run = Run(port, 60)
    if how == "killed early":
        os.kill(os.getpid(), signal.SIGKILL)
    run.source("points")
    run.source("rve_A_contacts")
    run.next()
    points, step = run.data("points"), run.step
    if points.GetFieldData().GetArray("step").GetValue(0) != step or points.GetPointData().GetArray("id") is None:
        os._exit(3)
    if how == "killed in a pause":
        run.pause()
        listen(0.5)
    if how.startswith("killed"):
        os.kill(os.getpid(), signal.SIGKILL)
    if how == "leaves":
        run.link = None
        from paraview.simple import Disconnect
        Disconnect()
    os._exit(0)


for k in range(cycles):
    how, start = ENDS[k % len(ENDS)], time.time()
    child = os.fork()
    if child == 0:
        client(how)
    status = os.waitpid(child, 0)[1]
    print("cycle", k, how.replace(" ", "_"), status, "%.2f" % (time.time() - start), flush=True)
