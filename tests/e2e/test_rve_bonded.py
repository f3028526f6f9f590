# labels: long
# timeout: 900
"""scenarios/tm_dempm/rve_bonded makes its nine curves, and what they must show is there."""
from e2e import *

with Folder() as f:
    script = os.path.join(SOURCE_DIR, "scenarios", "tm_dempm", "rve_bonded")
    done = subprocess.run([sys.executable, script, "--no-setup", "--tmdempm", TMDEMPM, "--out", f("out")], capture_output=True,
                          text=True, env=environment(), timeout=800)
    expect(done.returncode == 0, done.stdout + done.stderr)
    print(done.stdout)
    expect(done.stdout.count("  ok ") == 18 + 1 + 18 and "FAILED" not in done.stdout, done.stdout)
    with open(f("out", "summary.csv"), newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    expect(rows[0][:4] == ["lateral [Pa]", "beta [-]", "seeds [-]", "peak [Pa]"] and len(rows) == 10, str(rows))
    names = files_below(f("out"))
    expect(sum(name.endswith("kPa_beta_0.02.csv") for name in names) == 3 * 16, str(names))
    if "bonded.png" in names:
        expect(os.path.getsize(f("out", "bonded.png")) > 20000, "the chart is empty")
