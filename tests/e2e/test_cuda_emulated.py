# timeout: 300
"""The driver of NVIDIA's GPUs, in the shape of a library that computes on this processor (tests/emulated): the bits are
the serial path's, whoever computes how many RVEs; every way in which a device can fail ends in words, on the processor
under `auto`, with exit code 4 otherwise, and the last checkpoint goes on."""
import json
from e2e import *

PROGRAM = os.path.join(os.path.dirname(TMDEMPM), "..", "tests", "tmdempm_emulated")
DRIVERS = os.path.join(os.path.dirname(TMDEMPM), "..", "tests")
SCENE = COLUMN.replace("discs = 64", "discs = 48").replace("end = 0.1;", "end = 0.01;").replace(
    "history_every = 0.001; snapshot_every = 0.02; checkpoint_every = 0.01;",
    "history_every = 0.001; snapshot_every = 0.005; checkpoint_every = 0.002;")
SKIP = {"run.json", "log.txt"}


def settings(trouble="", driver="emulated"):
    return environment(FAKE_CUDA=trouble, LD_LIBRARY_PATH=os.path.join(DRIVERS, driver) if driver else "")


def run(device, *arguments, trouble="", driver="emulated", code=0):
    """Everything that the program says."""
    command = [PROGRAM, "run", *map(str, arguments), "--device", device, "--threads", "1"]
    done = subprocess.run(command, capture_output=True, text=True, env=settings(trouble, driver), timeout=120)
    said = done.stdout + done.stderr
    expect(done.returncode == code, "%s (%s) ended with %d, expected %d\n%s" % (command, trouble, done.returncode, code, said))
    return said


def says(said, *words):
    for word in words:
        expect(word in said, "expected `%s` in:\n%s" % (word, said))


def compare(reference, out):
    """The same files but for the names of who computed."""
    expect(files_below(reference) == files_below(out), "other files in %s" % out)
    for name in files_below(reference):
        if name not in SKIP:
            same_file(os.path.join(reference, name), os.path.join(out, name), name)


def report(out):
    with open(os.path.join(out, "run.json"), encoding="utf-8") as stream:
        return json.load(stream)


if not os.path.exists(PROGRAM):
    skip("this build has no devices (TMDEMPM_GPU is off)")

with Folder() as f:
    cfg = f.write("s.cfg", SCENE)
    serial = f.write("serial.cfg", SCENE.replace('type = "rve";', 'type = "rve"; path = "serial";'))
    run("cpu", serial, "--out", f("serial"), driver="")

    # it works, alone, as two, and with the processor
    for number, (device, trouble) in enumerate((("cuda", ""), ("cuda:0,cuda:1", "devices=2"), ("cuda:0,cpu", ""),
                                                ("cuda:1,cpu,cuda:0", "devices=2"))):
        out = f("good%d" % number)
        says(run(device, serial, "--out", out, trouble=trouble), "emulated")
        compare(f("serial"), out)
        expect("emulated" in report(out)["code_path"], report(out)["code_path"])

    # auto: what cannot be used is named, and the processor does all
    for trouble, driver, words in (("", "", "there is no libcuda.so.1"),
                                   ("", "emulated_old", "libcuda.so.1 lacks cuOccupancyMaxActiveBlocksPerMultiprocessor"),
                                   ("init=100", "emulated", "the driver does not start: no CUDA-capable device is detected"),
                                   ("init=803", "emulated", "unsupported display driver / cuda driver combination"),
                                   ("devices=0", "emulated", "the driver has no device"),
                                   ("capability=70", "emulated", "its compute capability is 7.0, expected at least 7.5"),
                                   ("module=209", "emulated", "loading the kernel: no kernel image"),
                                   ("memory=50000", "emulated", "for the states of RVEs are not to be had: out of memory")):
        out = f("none")
        says(run("auto", serial, "--out", out, "--force", trouble=trouble, driver=driver), words)
        compare(f("serial"), out)
        says(run("cuda", serial, "--out", f("never"), trouble=trouble, driver=driver, code=4), words)
        expect(not os.path.exists(f("never", "history.csv")), "a run began that could not")

    # a launch is refused in the middle of the run: the states are fetched back
    out = f("refused")
    says(run("auto", serial, "--out", out, trouble="launch=37"), "starting the kernel: too many resources",
         "the RVEs go on on the processor, with the same bits")
    compare(f("serial"), out)
    out = f("stopped")
    says(run("cuda", serial, "--out", out, trouble="launch=37", code=4), "starting the kernel: too many resources", "--restart")
    run("cuda", serial, "--out", out, "--restart", os.path.join(out, "checkpoint.h5"))
    compare(f("serial"), out)

    # a device is lost with all that it held: the last checkpoint goes on, here or there, from one or two of them
    for device, trouble, then in (("cuda", "lost=37", "cpu"), ("auto", "lost=64", "cuda"),
                                  ("cuda:0,cuda:1", "devices=2,lost=77", "cuda:0,cpu")):
        out = f("lost-" + then)
        says(run(device, serial, "--out", out, trouble=trouble, code=4), "CUDA device emulated", "what it held is lost with it",
             "go on from the last checkpoint")
        run(then, serial, "--out", out, "--restart", os.path.join(out, "checkpoint.h5"))
        compare(f("serial"), out)

    # kill -9 while a device computes
    out = f("killed")
    child = start([PROGRAM, "run", serial, "--out", out, "--device", "cuda", "--threads", "1"], env=settings("slow=10"),
                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 60
    while not os.path.exists(os.path.join(out, "checkpoint.h5")) and time.monotonic() < end:
        time.sleep(0.01)
    child.kill()
    expect(child.wait() == -9, "it ended before it was killed")
    run("cuda", serial, "--out", out, "--restart", os.path.join(out, "checkpoint.h5"))
    compare(f("serial"), out)

    # a scene that leaves its path open computes on a device what the serial path does
    run("cuda", cfg, "--out", f("open"))
    same_file(f("serial", "history.csv"), f("open", "history.csv"), "histories")
