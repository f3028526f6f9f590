# timeout: 120
"""`tmdempm doctor` tries real things: what is taken away is missed, what hangs or crashes is said so, and nothing that it
has started is left."""
import uuid
from e2e import *

NEEDED = {"processor", "libconfig", "hdf5", "folder"}


def doctor(*arguments, code=0, cwd=None, **more):
    """What it says of each part: (works | missing | BROKEN, words and cure)."""
    mark = "TMDEMPM_TEST=%s" % uuid.uuid4()
    env = environment(**more)
    env["TMDEMPM_TEST"] = mark.split("=")[1]
    if more.get("DISPLAY") == "":
        del env["DISPLAY"]
    done = subprocess.run([TMDEMPM, "doctor", *arguments], capture_output=True, text=True, env=env, cwd=cwd, timeout=120)
    expect(done.returncode == code, "doctor ended with %d, expected %d\n%s\n%s" % (done.returncode, code, done.stdout, done.stderr))
    all_gone(mark, "doctor")
    parts, name = {}, None
    for line in done.stdout.splitlines():
        if line[2:9].strip() in ("works", "missing", "BROKEN"):
            name = line[11:22].strip()
            parts[name] = [line[2:9].strip(), line[23:]]
        elif name and line.startswith(" " * 20):
            parts[name][1] += " " + line.strip()
    return parts


def library(f, name, text):
    """A library that stands in for a driver, in a folder of its own."""
    folder = f(name)
    os.mkdir(folder)
    source = f.write(name + ".c", text)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", os.path.join(folder, "libcuda.so.1"), source], check=True)
    return {"LD_LIBRARY_PATH": folder}


def viewers(f):
    """Viewers that are not there, hang and crash."""
    parts = doctor(TMDEMPM_VIEWER=f("nobody"))
    for name in ("viewer", "gl", "images", "catalyst", "live"):
        expect(parts[name][0] == "missing" and "apt-get install" in parts[name][1] or name == "images", "%s: %s" % (name, parts[name]))
    expect(all(parts[name][0] == "works" for name in NEEDED), str(parts))
    script = f.write("viewer.sh", "#!/bin/sh\nsleep 1000 & sleep 1000\n")
    os.chmod(script, 0o755)
    parts = doctor("--timeout", "0.5", "gl", TMDEMPM_VIEWER=script)
    expect(parts["gl"] [0] == "missing" and "no answer within 0.5 s" in parts["gl"][1], str(parts["gl"]))
    f.write("viewer.sh", "#!/bin/sh\nkill -SEGV $$\n")
    parts = doctor("gl", TMDEMPM_VIEWER=script)
    expect(parts["gl"][0] == "missing" and "signal 11" in parts["gl"][1], str(parts["gl"]))


def devices(f):
    """Drivers that count devices, that fail and that hang."""
    if shutil.which("cc"):
        parts = doctor("cuda", **library(f, "good", """
            #include <string.h>
            int cuInit(unsigned flags) { return flags; }
            int cuDriverGetVersion(int *version) { *version = 12040; return 0; }
            int cuDeviceGetCount(int *n) { *n = 3; return 0; }
            int cuDeviceGetName(char *name, int size, int device) { strncpy(name, "Made Up 100", size); return device; }
            """))
        expect(parts["cuda"] == ["works", "CUDA 12.4, 3 devices: Made Up 100 ..."], str(parts["cuda"]))
        parts = doctor("cuda", **library(f, "bad", "int cuInit(unsigned flags) { return 100; }\n"))
        expect(parts["cuda"][0] == "missing" and "cuInit with 100" in parts["cuda"][1], str(parts["cuda"]))
        parts = doctor("--timeout", "1", "cuda", **library(f, "hangs", "#include <unistd.h>\nint cuInit(unsigned flags) { for (;;) sleep(1); }\n"))
        expect(parts["cuda"][0] == "missing" and "it hangs" in parts["cuda"][1], str(parts["cuda"]))
        parts = doctor("cuda", **library(f, "crashes", "int cuInit(unsigned flags) { return *(volatile int *)0; }\n"))
        expect(parts["cuda"][0] == "missing" and "signal 11" in parts["cuda"][1], str(parts["cuda"]))
    parts = doctor("opencl", OCL_ICD_VENDORS=f("none"))
    expect(parts["opencl"][0] == "missing" and "pocl-opencl-icd" in parts["opencl"][1], str(parts["opencl"]))


with Folder() as f:
    os.environ["TMDEMPM_VIEWER"] = f("nobody")  # the viewer's own parts are tried once, at the end
    viewers(f)
    devices(f)
    # a folder that cannot be written to breaks a run
    parts = doctor("folder", "hdf5", code=4, cwd="/proc")
    expect(parts["folder"][0] == "BROKEN", str(parts["folder"]))
    for arguments in (["--timeout", "0"], ["--timeout", "soon"], ["heart"], ["--cure"]):
        tmdempm("doctor", *arguments, code=2)
    del os.environ["TMDEMPM_VIEWER"]
    parts = doctor(*NEEDED, "viewer", "memory", "display", "xvfb", "gl", "images", DISPLAY="")
    expect(all(parts[name][0] == "works" for name in NEEDED), str(parts))
    if parts["viewer"][0] != "works":
        skip("no viewer: " + parts["viewer"][1])
    for name in ("xvfb", "gl", "images", "memory"):
        expect(parts[name][0] == "works", "%s: %s" % (name, parts[name]))
    expect("OpenGL" in parts["gl"][1] and "own" in parts["xvfb"][1], str(parts))
    # a display that is dead
    parts = doctor("display", "images", DISPLAY=":987")
    expect(parts["display"][0] == "works" and parts["images"][0] == "works", str(parts))
