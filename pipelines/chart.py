"""How charts look: what study_chart.py, fragments_chart.py and rve_bonded_chart.py share.

Exit code 77: matplotlib is missing.
"""
import sys

try:
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
except ImportError:
    sys.exit(77)

matplotlib.rcParams.update({
    "font.size": 9, "axes.grid": True, "grid.color": "0.9", "axes.axisbelow": True, "svg.hashsalt": "tmdempm",
    "legend.frameon": False, "axes.spines.top": False, "axes.spines.right": False, "legend.fontsize": 8,
})
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c564b", "#7f7f7f", "#bcbd22"]
