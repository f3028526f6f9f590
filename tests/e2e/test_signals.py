# timeout: 120
"""SIGINT and SIGTERM finish the step, save and leave; SIGUSR1 saves a checkpoint and goes on; a guard stops a
run with its reason and a checkpoint."""
import json
import signal
import time
from e2e import *


def started(cfg, out):
    """A run that is certainly in its loop."""
    run = start([TMDEMPM, "run", cfg, "--out", out, "--threads", "1", "--set", "time.end=1000",
                            "--set", "output.history_every=0.01", "--set", "output.snapshot_every=0"],
                           env=environment(), stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    wait(lambda: os.path.exists(os.path.join(out, "history.csv")) and len(history(out)[1]) > 2, run)
    return run


def wait(condition, run):
    for _ in range(600):
        if condition():
            return
        expect(run.poll() is None, "the run has ended")
        time.sleep(0.05)
    sys.exit("FAILED: waited for 30 s")


def stopped(f, cfg, number, name):
    out = f(name)
    run = started(cfg, out)
    run.send_signal(number)
    time.sleep(0.01)
    run.send_signal(number)  # as timeout(1) does: one wish, said twice
    said = run.communicate(timeout=30)[1]
    expect(run.returncode == 130, "%s ends with %d" % (name, run.returncode))
    expect("interrupted at step" in said and "--restart" in said, said)
    with open(os.path.join(out, "run.json"), encoding="utf-8") as stream:
        state = json.load(stream)
    expect(state["state"] == "interrupted" and state["step"] > 0, str(state["state"]))
    end = (state["step"] + 50) * 1e-4
    tmdempm("run", cfg, "--restart", os.path.join(out, "checkpoint.h5"), "--set", "time.end=1000", "--set",
            "output.history_every=0.01", "--set", "output.snapshot_every=0", "--until", end)
    with open(os.path.join(out, "run.json"), encoding="utf-8") as stream:
        expect(json.load(stream)["step"] == state["step"] + 50, "the restart went elsewhere")


def saved(f, cfg):
    out = f("user")
    checkpoint = os.path.join(out, "checkpoint.h5")
    run = started(cfg, out)
    expect(not os.path.exists(checkpoint), "there is a checkpoint already")
    run.send_signal(signal.SIGUSR1)
    wait(lambda: os.path.exists(checkpoint), run)
    rows = len(history(out)[1])
    wait(lambda: len(history(out)[1]) > rows + 2, run)
    run.send_signal(signal.SIGTERM)
    run.communicate(timeout=30)
    expect(run.returncode == 130, "SIGTERM ends with %d" % run.returncode)


def guarded(f, cfg):
    """The block flies sideways out of the grid: the state is kept, the last checkpoint too, and goes on with other guards."""
    out = f("guard")
    scene = [cfg, "--set", "time.end=10", "--set", "gravity.[0]=50", "--set", "walls.[0].friction=0",
             "--set", "output.checkpoint_every=0.05"]
    said = tmdempm("run", *scene, "--out", out, code=3).stderr
    for word in ("step", "point", "grid"):
        expect(word in said, "`%s` is not in: %s" % (word, said))
    checkpoint, at_guard = os.path.join(out, "checkpoint.h5"), os.path.join(out, "guard.h5")
    expect(os.path.exists(checkpoint), "no checkpoint")
    with open(os.path.join(out, "run.json"), encoding="utf-8") as stream:
        report = json.load(stream)
    expect(report["state"] == "guard" and "grid" in report["reason"] and "guard.h5" in report["files"], str(report))
    said = tmdempm("run", *scene, "--restart", at_guard, code=2).stderr
    expect("in the middle of a step" in said, said)
    end = report["time"] + 0.001
    free = ["--set", "guards.points_leaving=false", "--until", end]
    tmdempm("run", *scene, "--restart", checkpoint, *free)
    tmdempm("run", *scene, "--out", f("free"), *free)
    same_file(checkpoint.replace("checkpoint.h5", "history.csv"), f("free", "history.csv"), "histories")


def guarded_within(f, cfg):
    """With USF a step's guards may fire when points have strained already: that is no state to go on from."""
    out = f("within")
    scene = [cfg, "--set", "mpm.order=usf", "--set", "materials.[0].law.young=2e4", "--set", "gravity.[1]=-500",
             "--set", "output.checkpoint_every=0.002"]
    said = tmdempm("run", *scene, "--out", out, code=3).stderr
    expect("within the step" in said, said)
    said = tmdempm("run", *scene, "--restart", os.path.join(out, "guard.h5"), code=2).stderr
    expect("in the middle of a step" in said, said)
    end = column(out, "time [s]")[-1]
    whole = ["--until", end - 0.5e-4]
    tmdempm("run", *scene, "--restart", os.path.join(out, "checkpoint.h5"), *whole)
    tmdempm("run", *scene, "--out", f("straight"), *whole)
    same_file(os.path.join(out, "checkpoint.h5"), f("straight", "checkpoint.h5"), "checkpoints")


with Folder() as f:
    cfg = f.write("s.cfg", BLOCK)
    stopped(f, cfg, signal.SIGINT, "int")
    stopped(f, cfg, signal.SIGTERM, "term")
    saved(f, cfg)
    guarded(f, cfg)
    guarded_within(f, cfg)
