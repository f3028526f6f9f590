"""For pvpython: live_client.py first|second PORT RUN_FOLDER: what a person and ParaView do with a running silo.

first: connects late; compares what it sees with the run's files; has another RVE inspected; pauses, steps, goes on;
pauses again and is killed.  second: comes after that, sees that the run goes on, and stops it.
"""
import os
import signal
import subprocess
import sys
import time

who, port, out = sys.argv[1], int(sys.argv[2]), sys.argv[3]
sys.path[:0] = [os.path.join(os.environ["SOURCE_DIR"], "pipelines"), os.path.dirname(os.path.abspath(__file__))]
from h5 import H5, equal
from tmdempm_live import Run, listen
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

FIELDS = ("temperature", "velocity", "stress", "strain", "strain_deviatoric", "heat_source", "void_ratio", "coordination",
          "sub_steps", "gas")


def expect(condition, message):
    if not condition:
        print("FAILED: " + message, flush=True)
        os._exit(1)


def values(attributes, name):
    array = attributes.GetArray(name)
    expect(array is not None, "no array " + name)
    return [array.GetComponent(i, c) for i in range(array.GetNumberOfTuples()) for c in range(array.GetNumberOfComponents())]


def places(data):
    return [x for i in range(data.GetNumberOfPoints()) for x in data.GetPoint(i)]


def snapshot(step):
    """The run's file of this step, which is written a moment after the frame has been handed over."""
    path = os.path.join(out, "snap", "%08d.h5" % step)
    for _ in range(200):
        if os.path.exists(path):
            return path
        time.sleep(0.05)
    expect(False, "no " + path)


def check_points(points, step):
    file = H5(snapshot(step))
    expect(points.GetNumberOfPoints() == points.GetNumberOfCells() == len(file["points/id"]), "another number of points")
    expect(equal(values(points.GetPointData(), "id"), file["points/id"]), "points: other ids")
    for field in FIELDS:
        seen = values(points.GetPointData(), field)
        expect(any(seen) or field in ("gas", "strain_deviatoric"), "%s is nothing but zeros" % field)
        expect(equal(seen, file["points/" + field]), "step %d: %s is not that of the run's file" % (step, field))
    file.close()


def check_contacts(contacts, step, which):
    """The network against that of the RVE's state in the snapshot."""
    stem = os.path.join(out, "seen")
    subprocess.run([os.environ["TMDEMPM"], "rve", "show", snapshot(step)] + which + ["--vtp", stem], check=True,
                   stdout=subprocess.DEVNULL)
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(stem + "_contacts.vtp")
    reader.Update()
    file = reader.GetOutput()
    for name in ("normal_force", "tangential_force", "sliding"):
        expect(equal(values(contacts.GetCellData(), name), values(file.GetCellData(), name)),
               "step %d, %s: %s is not that of the run's file" % (step, which, name))
    expect(equal(places(contacts), places(file)), "step %d, %s: contacts are elsewhere" % (step, which))


def same_step(run, *channels):
    """Data of several channels that belongs to one step."""
    for _ in range(50):
        data = [run.data(channel) for channel in channels]
        steps = {d.GetFieldData().GetArray("step").GetValue(0) for d in data}
        if len(steps) == 1:
            return [int(steps.pop())] + data
        listen(0.02)
    expect(False, "channels never come from one step")


def first():
    run = Run(port, 60)
    channels = run.channels()
    for name in ("points", "domains", "grid", "walls", "rve_A_discs", "rve_A_contacts", "rve_B_discs", "rve_B_contacts"):
        expect(name in channels, "no channel %s in %s" % (name, channels))
    for name in ("points", "rve_A_contacts"):
        run.source(name)
    for k in range(2):
        run.next()
        step, points, contacts = same_step(run, "points", "rve_A_contacts")
        expect(step > 0, "not late")
        check_points(points, step)
        check_contacts(contacts, step, ["--name", "A"])
    print("compared", step, flush=True)

    run.inspect("A", point=30)
    for _ in range(20):
        run.next()
        step, contacts = same_step(run, "rve_A_contacts")
        discs = run.data("rve_A_discs")
        if step_says_inspected(30):
            break
    run.next()
    step, contacts = same_step(run, "rve_A_contacts")
    check_contacts(contacts, step, ["--point", "30"])
    print("inspected", step, flush=True)

    run.pause()
    listen(1.5)
    paused = run.step
    listen(1.0)
    expect(run.step == paused, "the run goes on in a pause: %d, %d" % (paused, run.step))
    expect("paused" in state(), "the run says that it is not paused: " + state())
    run.step_on(3)
    for _ in range(100):
        if run.step == paused + 3:
            break
        listen(0.1)
    expect(run.step == paused + 3, "after step=3 from step %d, step %d is shown" % (paused, run.step))
    stepped = run.step
    listen(1.0)
    expect(run.step == stepped, "the run goes on after step=3: %d, %d" % (stepped, run.step))
    run.go_on()
    for _ in range(3):
        run.next()
    expect(run.step > stepped, "the run does not go on")
    print("paused", paused, stepped, run.step, flush=True)
    run.pause()
    listen(1.0)
    os.kill(os.getpid(), signal.SIGKILL)


def state():
    done = subprocess.run([os.environ["TMDEMPM"], "steer", out], capture_output=True, text=True)
    return done.stdout + done.stderr


def step_says_inspected(point):
    return "A=point:%d" % point in state()


def second():
    run = Run(port, 60)
    run.source("points")
    run.next()
    run.next()
    step, points = same_step(run, "points")
    check_points(points, step)
    print("second", step, flush=True)
    run.stop()
    listen(2.0)
    os._exit(0)


(first if who == "first" else second)()
