# labels: slow
# timeout: 400
"""The quick forced silo, its first steps with RVEs on an OpenCL device (PoCL compiles the kernel for this processor):
the same files, bit for bit, as the serial path computes here; alone, with the processor's help, and over a restart."""
import json
from e2e import *

DRIVER = "/usr/lib/x86_64-linux-gnu/libpocl.so.2"
SCENE = os.path.join(SOURCE_DIR, "scenarios", "tm_dempm", "silo_forced_quick.cfg")
BUILD = os.path.dirname(os.path.dirname(os.path.abspath(TMDEMPM)))
SKIP = {"run.json", "log.txt"}
STEPS, STEP = 40, 4e-4

if not os.path.exists(DRIVER):
    skip("there is no PoCL")

with Folder() as f:
    f.write("pocl.icd", DRIVER + "\n")
    os.environ.update(OCL_ICD_VENDORS=f("pocl.icd"), POCL_CACHE_DIR=os.path.join(BUILD, "test-pocl"))
    if "pthread" not in tmdempm("info").stdout:
        skip("PoCL finds no device, or this build has no OpenCL")

    def run(out, *arguments, until=STEPS):
        tmdempm("run", SCENE, "--out", f(out), "--until", until * STEP, "--set", "images=()", "--set", "materials.[0].law.path=serial",
                "--set", "output.history_every=%g" % (10 * STEP), *arguments)
        with open(f(out, "run.json"), encoding="utf-8") as stream:
            return json.load(stream)["code_path"]

    law = next(line for line in tmdempm("check", SCENE, "--device", "opencl:0").stdout.splitlines() if "RVEs of" in line)
    expect("opencl:0 pthread" in law and "cpu 0" in law, law)
    run("serial")
    expect("cpu 0" in run("device", "--device", "opencl:0"), "RVEs stay here")
    expect(files_below(f("serial")) == files_below(f("device")), "other files")
    for name in files_below(f("serial")):
        if name not in SKIP:
            same_file(f("serial", name), f("device", name), name)
    path = run("both", "--device", "opencl:0,cpu", until=STEPS // 2)
    expect("opencl:0 pthread" in path and "cpu 0" not in path, path)
    run("both", "--device", "opencl:0", "--restart", f("both", "checkpoint.h5"))
    for name in ("checkpoint.h5", "history.csv"):  # snapshots are more: one where the first part ended
        same_file(f("serial", name), f("both", name), name)
