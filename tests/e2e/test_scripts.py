"""scenarios/run, tests/run and .ci/setup in a copy of the tree, with stand-ins for the programs that they start."""
from e2e import *

STAND_IN = '#!/usr/bin/env bash\necho "%s: $*" >>"$SAID"\n%s\n'


def program(path, code=""):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as stream:
        stream.write(STAND_IN % (os.path.basename(path), code))
    os.chmod(path, 0o755)


def script(f, *words, code=0, **environment):
    """Runs a script of the copy from a folder elsewhere; returns what its stand-ins were asked, and its own words."""
    if os.path.exists(f("said")):
        os.remove(f("said"))
    done = subprocess.run([f("tree", words[0])] + list(words[1:]), cwd=f("elsewhere"), capture_output=True, text=True, timeout=60,
                          env=dict(os.environ, SAID=f("said"), PATH=f("bin") + ":" + os.environ["PATH"], **environment))
    expect(done.returncode == code, "%s ended with %d, expected %d: %s" % (words, done.returncode, code, done.stderr))
    said = open(f("said"), encoding="utf-8").read().splitlines() if os.path.exists(f("said")) else []
    return said, done.stdout + done.stderr


def scenes(f):
    """scenarios/run finds scenes by name or as files, numbers its folders and passes options on."""
    silo = f("tree", "scenarios", "tm_dempm", "silo_forced.cfg")
    program(f("tree", ".ci", "setup"))
    program(f("tree", "build", "bin", "tmdempm"), 'while [ $# -gt 0 ]; do [ "$1" != --out ] || mkdir -p "$2"; shift; done')
    for number in ("001", "002"):
        said, _ = script(f, "scenarios/run", "silo_forced", "--until", "1")
        expect(said == ["setup: ", "tmdempm: run %s --out out/silo_forced_%s --until 1" % (silo, number)], str(said))
    shutil.copy(silo, f("elsewhere", "my own.cfg"))
    said, _ = script(f, "scenarios/run", "my own.cfg", "--out", "here")
    expect(said[1] == "tmdempm: run my own.cfg --out here", str(said))
    said, _ = script(f, "scenarios/run", "silo_forced", "--restart", "out/silo_forced_001/checkpoint.h5")
    expect(said[1] == "tmdempm: run %s --restart out/silo_forced_001/checkpoint.h5" % silo, str(said))
    for unknown in ("silo", "mine/silo_forced.cfg", "steel"):
        said, words = script(f, "scenarios/run", unknown, code=2)
        expect(not said and "'%s'" % unknown in words, words)
    said, words = script(f, "scenarios/run", "rve_bonded", "--help")  # a script beside the scenes
    expect(not said and "usage: rve_bonded" in words, words)
    said, words = script(f, "scenarios/run")
    for name in ("silo_free", "silo_forced", "silo_forced_quick", "column_quick", "rve_bonded               Nine biaxial"):
        expect(name in words and "steel" not in words and not said, words)


def studies(f):
    """scenarios/study finds studies by name or as files, all of them on demand, and wants matplotlib set up."""
    program(f("tree", ".ci", "setup"))
    program(f("tree", "build", "bin", "tmdempm"))
    of = lambda name: f("tree", "scenarios", "studies", name + ".cfg")
    said, _ = script(f, "scenarios/study", "rve_size", "column_quick.cfg", "--jobs", "3")
    expect(said == ["setup: --charts", "tmdempm: study %s %s --out out/studies --jobs 3" % (of("rve_size"), of("column_quick"))], str(said))
    said, _ = script(f, "scenarios/study", "all", "--out", "here", "--jobs=1")
    every = sorted(name for name in os.listdir(f("tree", "scenarios", "studies")) if name.endswith(".cfg"))
    expect(said[1].startswith("tmdempm: study ") and said[1].count(".cfg") == len(every), str(said))
    for unknown in ("rve", "silo_forced"):
        said, words = script(f, "scenarios/study", unknown, code=2)
        expect(not said and "'%s'" % unknown in words, words)
    _, words = script(f, "scenarios/study")
    expect("rve_size" in words, words)
    said, words = script(f, "scenarios/run", "column_quick")  # a study's name is not in a scene's way
    expect(said[1].startswith("tmdempm: run " + f("tree", "scenarios", "tm_dempm", "column_quick.cfg")), str(said) + words)


def tests(f):
    """tests/run leaves the long ones out unless tests are chosen."""
    program(f("bin", "ctest"))
    usual = ["setup: --tests --preset release", "ctest: --test-dir %s --output-on-failure --parallel %d"
             % (f("tree", "build"), len(os.sched_getaffinity(0)))]
    for options, choice in (([], "-LE long|gui|device"), (["-j", "2"], "-LE long|gui|device -j 2"), (["-L", "long"], "-L long"),
                            (["-R", "mpm"], "-R mpm")):
        said, _ = script(f, "tests/run", *options)
        expect(said == [usual[0], usual[1] + " " + choice], str(said))
    said, _ = script(f, "tests/run", "--preset", "asan")
    expect(said[0].endswith("asan") and "build-asan" in said[1] and "-L unit" in said[1], str(said))


def setup(f):
    """.ci/setup configures once, again where that was interrupted or something else is wanted, and always builds."""
    shutil.copy(os.path.join(SOURCE_DIR, ".ci", "setup"), f("tree", ".ci", "setup"))
    program(f("bin", "dpkg-query"), "echo installed")
    build = f("tree", "build")
    program(f("bin", "cmake"), """case $1 in --preset)
	mkdir -p build; rm -f build/CMakeCache.txt
	for option; do case $option in -D*) echo "${option#-D}" | sed s/=/:BOOL=/ >>build/CMakeCache.txt; esac; done
	[ -z "${INTERRUPTED:-}" ] || exit 1
	touch build/Makefile ;; esac""")

    def configures(options, before, code=0, **environment):
        said, words = script(f, ".ci/setup", *options, code=code, **environment)
        said = [line for line in said if line.startswith("cmake: ")]
        expect(sum("--preset" in line for line in said) == before, "%s %s: %s" % (options, environment, said))
        expect(code or said[-1].startswith("cmake: --build " + build), str(said))
        return said, words

    configures([], 1, code=4, INTERRUPTED="yes")
    said, _ = configures([], 1)
    expect("-DTMDEMPM_TESTS=OFF -DTMDEMPM_INSITU=ON" in said[0], str(said))
    _, words = configures([], 0)
    expect(words == "", "not quiet with nothing to do: " + words)
    os.remove(os.path.join(build, "CMakeCache.txt"))
    said, _ = configures(["--tests"], 1)
    expect("-DTMDEMPM_TESTS=ON" in said[0], str(said))
    configures([], 0)  # once built with tests, a build stays with tests
    os.remove(os.path.join(build, "CMakeCache.txt"))
    said, _ = configures([], 1, TMDEMPM_INSITU="OFF")
    expect("-DTMDEMPM_INSITU=OFF" in said[0], str(said))
    program(f("bin", "dpkg-query"), "echo deinstalled")
    program(f("bin", "apt-get"), "echo out of disk; exit 100")
    program(f("bin", "sudo"), '"$@"')
    said, words = configures([], 0, code=4)
    expect("installing" in words and "libhdf5-dev (writes results)" in words and "out of disk" in words, words)


with Folder() as f:
    for part in (".ci", "scenarios", "tests/run"):
        at = os.path.join(SOURCE_DIR, part)
        if os.path.isdir(at):
            shutil.copytree(at, f("tree", part))
        else:
            os.makedirs(f("tree", os.path.dirname(part)), exist_ok=True)
            shutil.copy(at, f("tree", part))
    os.mkdir(f("elsewhere"))
    scenes(f)
    studies(f)
    tests(f)
    setup(f)
