# labels: slow
# timeout: 180
"""What can befall a live connection: nobody listens, a host that swallows packets, a client that hangs, a viewer that is
killed, once and again.  The run neither ends nor waits, and nothing of it is left."""
import json
import signal
import socket
from live import *

needs_catalyst()
SLOW = COLUMN.replace("end = 0.1", "end = 1000.0").replace("snapshot_every = 0.02; checkpoint_every = 0.01",
                                                           "snapshot_every = 0; checkpoint_every = 0")


def steps(f, name):
    """The step that the run is at."""
    return int(tmdempm("steer", f(name)).stdout.split("step")[1].split()[0])


def goes_on(f, name, what):
    """The run makes steps, and many, in the next half second."""
    before = steps(f, name)
    wait(0.5)
    expect(steps(f, name) > before + 20, "%s: %d steps in half a second" % (what, steps(f, name) - before))


class Silent:
    """A port at which connections are never made: the queue of those that wait is full, further packets are dropped."""

    def __enter__(self):
        self.listener, self.waiting = socket.socket(), []
        self.listener.bind(("127.0.0.1", 0))
        self.listener.listen(0)
        self.port = self.listener.getsockname()[1]
        for _ in range(4):
            one = socket.socket()
            one.setblocking(False)
            one.connect_ex(("127.0.0.1", self.port))
            self.waiting.append(one)
        return self

    def __exit__(self, *unused):
        for one in self.waiting + [self.listener]:
            one.close()


def swallowed(f, cfg):
    """A host that swallows packets holds up the viewer for two seconds at a time, the run never."""
    with Silent() as silent:
        run = Simulation(cfg, f("swallowed"), "--live", "127.0.0.1:%d" % silent.port)
        run.wait_for("waits for a ParaView")
        run.wait_for("steps of")
        for _ in range(3):
            goes_on(f, "swallowed", "a host that swallows packets")
        run.end(code=130, signal=signal.SIGTERM, seconds=15)


def nobody(f, cfg):
    """Names that do not exist, and ports at which nobody listens."""
    run = Simulation(cfg, f("nobody"), "--live", "no-such-host.invalid:22222")
    run.wait_for("steps of")
    goes_on(f, "nobody", "a host that does not exist")
    run.end(code=130, signal=signal.SIGTERM, seconds=15)
    said = tmdempm("run", cfg, "--out", f("bad"), "--live=some/where", code=2).stderr
    expect("expected a port (1 .. 65534) or host:port" in said, said)


def hangs(f, cfg):
    """A client that is stopped: the run goes on, says so, and ends although the client does not answer."""
    port = free_port()
    run = Simulation(cfg, f("hangs"), "--live", port, "--set", "catalyst.live.share=1.0")
    client = pvpython(os.path.join(HERE, "live_watch.py"), port, PIPELINES)
    for line in client.stdout:
        if line.startswith("frame"):
            break
    client.send_signal(signal.SIGSTOP)
    run.wait_for("ParaView does not answer")
    goes_on(f, "hangs", "a client that hangs")
    client.send_signal(signal.SIGCONT)
    run.wait_for("ParaView answers again")
    client.send_signal(signal.SIGSTOP)
    wait(0.5)
    run.end(code=130, signal=signal.SIGTERM, seconds=15)
    client.kill()
    client.wait()
    with open(f("hangs", "run.json"), encoding="utf-8") as stream:
        expect(json.load(stream)["viewers"]["live"]["dropped"] > 0, "no frame was dropped")


def killed(f, cfg):
    """A viewer that is killed is started once more; killed again, it is left."""
    run = Simulation(cfg, f("killed"), "--live", free_port())
    run.wait_for("steps of")
    for notice in ("starting it again", "no more live connection"):
        for _ in range(100):
            if run.children():
                break
            wait(0.05)
        os.kill(run.viewer(), signal.SIGKILL)
        run.wait_for(notice)
        goes_on(f, "killed", "a viewer that was killed")
    # the engine killed with its viewer at work: nothing is left
    run = Simulation(cfg, f("gone"), "--live", free_port())
    run.wait_for("steps of")
    run.end(code=-9, signal=signal.SIGKILL)


with Folder() as f:
    cfg = f.write("s.cfg", SLOW)
    swallowed(f, cfg)
    nobody(f, cfg)
    hangs(f, cfg)
    killed(f, cfg)
