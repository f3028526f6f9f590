"""For pvpython: live_watch.py PORT PIPELINES: a client that looks at every frame, for ever."""
import sys

sys.path.insert(0, sys.argv[2])
from tmdempm_live import Run

run = Run(int(sys.argv[1]), 60)
run.source("points")
while True:
    print("frame", run.next(1000), flush=True)
