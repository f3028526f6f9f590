# labels: long
# timeout: 900
"""Fifty clients in a row."""
from live_cycles_run import cycles

cycles(50, 600)
