# timeout: 300
"""kill -9 at twenty random moments: the last checkpoint always restarts, every named file is whole, and the
run that was killed twenty times is at last the run that never was."""
import random
import time
import xml.etree.ElementTree
from e2e import *

SKIP = {"run.json", "log.txt"}


def arguments(cfg, out, threads=1):
    return [TMDEMPM, "run", cfg, "--out", out, "--threads", str(threads), "--quiet"]


def whole_files(out):
    """Nothing under its own name is torn."""
    if os.path.exists(os.path.join(out, "history.csv")):
        with open(os.path.join(out, "history.csv"), "rb") as stream:
            lines = stream.read().split(b"\r\n")
        expect(lines[-1] == b"" and len({line.count(b",") for line in lines[:-1]}) <= 1, "history.csv is torn")
    for name in files_below(out):
        if name.endswith(".pvd"):
            for entry in xml.etree.ElementTree.parse(os.path.join(out, name)).iter("DataSet"):
                expect(os.path.exists(os.path.join(out, entry.get("file"))), "%s names %s" % (name, entry.get("file")))
        elif name.endswith((".vtp", ".vti")):
            with open(os.path.join(out, name), "rb") as stream:
                expect(stream.read().endswith(b"</VTKFile>\n"), name + " is torn")


def step_of(out):
    """The last row's step."""
    return int(history(out)[1][-1][1])


def killed(scene, kills, longest, seed):
    dice = random.Random(seed)
    with Folder() as f:
        cfg = f.write("s.cfg", scene)
        tmdempm("run", cfg, "--out", f("whole"))
        out, restarts, done = f("killed"), 0, False
        for kill in range(kills):
            checkpoint = os.path.join(out, "checkpoint.h5")
            more = ["--restart", checkpoint] if os.path.exists(checkpoint) else ["--force"]
            restarts += more[0] == "--restart"
            run = start(arguments(cfg, out) + more, env=environment(), stderr=subprocess.PIPE, text=True)
            try:
                run.wait(timeout=dice.uniform(0.02, longest))
            except subprocess.TimeoutExpired:
                run.kill()
            said = run.communicate()[1]
            expect(run.returncode in (0, -9), "ended with %d after %d kills: %s" % (run.returncode, kill, said))
            done |= run.returncode == 0
            whole_files(out)
        expect(restarts > 0, "no checkpoint in %d runs" % kills)
        tmdempm("run", cfg, "--restart", os.path.join(out, "checkpoint.h5"))
        expect(not [name for name in files_below(out) if name.endswith(".tmp")], "the killed left %s" % files_below(out))
        for name in files_below(f("whole")):
            if name not in SKIP:
                same_file(f("whole", name), os.path.join(out, name), name)
        print("%d restarts of %d, the end was reached %s" % (restarts, kills, "early" if done else "at last"))


# quick steps, a checkpoint every 20 of them
killed(BLOCK.replace("end = 0.2", "end = 1.0") + "output = { history_every = 0.0005; snapshot_every = 0.02; checkpoint_every = 0.002; };\n",
       12, 0.3, 1)
killed(COLUMN.replace("end = 0.1", "end = 0.3").replace("checkpoint_every = 0.01", "checkpoint_every = 0.001"), 8, 0.6, 2)
