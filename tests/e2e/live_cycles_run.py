"""Clients that come and go, leave, exit and are killed, in one run: the simulation ends well, with the bits of a run that
nobody has watched, and no process of it grows."""
from live import *


def cycles(n, seconds):
    needs_catalyst()
    with Folder() as f:
        cfg, port = f.write("s.cfg", COLUMN.replace("end = 0.1", "end = 1000.0").replace("history_every = 0.001", "history_every = 0.1")
                            .replace("snapshot_every = 0.02; checkpoint_every = 0.01", "snapshot_every = 0; checkpoint_every = 0")), free_port()
        run = Simulation(cfg, f("watched"), "--live", port)
        run.wait_for("waits for a ParaView")
        clients = pvpython(os.path.join(HERE, "live_cycles.py"), port, n, PIPELINES)
        sizes, ends = [], []
        for line in clients.stdout:
            if line.startswith("cycle "):
                ends.append(line.split()[2:4])
                sizes.append((resident(run.process.pid), resident(run.viewer())))
        expect(clients.wait(timeout=seconds) == 0 and len(ends) == n, "%d clients:\n%s" % (len(ends), run.text()))
        wrong = [end for end in ends if end[1] != ("9" if end[0].startswith("killed") else "0")]
        expect(not wrong, "clients ended otherwise: %s" % wrong)
        run.wait_for("ParaView has gone", count=n)
        tmdempm("steer", f("watched"), "stop=1")
        run.end(code=130)
        # what a ParaView session allocates once comes with the first clients
        settled, last = sizes[min(4, n // 2)], sizes[-1]
        print("resident MiB, engine and viewer:", sizes)
        expect(last[0] < settled[0] + 1 and last[1] < settled[1] + 1 + 0.2 * n, "memory grows: %s" % sizes)
        step = int(run.text().split("interrupted at step ")[1].split(",")[0])
        tmdempm("run", cfg, "--out", f("alone"), "--until", "%.9g" % (step * 1e-4))
        same_file(f("watched", "checkpoint.h5"), f("alone", "checkpoint.h5"), "checkpoints")
        with open(f("watched", "history.csv"), encoding="utf-8") as watched, open(f("alone", "history.csv"), encoding="utf-8") as alone:
            # the one that was done has a row more, of its end
            expect(alone.read().startswith(watched.read()), "histories differ")
