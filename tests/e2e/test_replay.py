"""The recorded path of an inspected RVE, replayed alone, gives the same bits as in the run."""
from e2e import *


def cells(path, name):
    with open(path, newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    at = [column.split(" [")[0] for column in rows[0]].index(name)
    return [row[at] for row in rows[1:]]


with Folder() as f:
    cfg = f.write("s.cfg", COLUMN.replace("history_every = 0.001", "history_every = 1e-4"))
    tmdempm("run", cfg, "--out", f("out"), "--until", 0.08)
    # a restart in between changes nothing
    tmdempm("run", cfg, "--restart", f("out", "checkpoint.h5"), "--until", 0.1)
    tmdempm("rve", "load", "--scene", cfg, "--load", "path", "--path", f("out", "rve", "A_path.csv"), "--out", f("curve.csv"))
    expect(len(cells(f("out", "rve", "A_path.csv"), "duration")) == 1000, "a step is missing in the path")
    for name in ("stress_xx", "stress_yy", "stress_xy", "void_ratio", "coordination", "sliding_fraction"):
        run, alone = cells(f("out", "history.csv"), "A." + name), cells(f("curve.csv"), name)
        expect(len(run) == len(alone) == 1001, "%d rows in the run, %d alone" % (len(run), len(alone)))
        for step, (a, b) in enumerate(zip(run, alone)):
            expect(a == b, "%s at step %d: %s in the run, %s alone" % (name, step, a, b))
    expect(abs(float(run[-1]) - float(run[0])) > 0 or run[0] == "0", "nothing has happened")
