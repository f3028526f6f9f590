# labels: slow
# timeout: 400
"""Ten clients in a row."""
from live_cycles_run import cycles

cycles(10, 300)
