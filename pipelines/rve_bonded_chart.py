#!/usr/bin/env python3
"""Draws the curves of scenarios/tm_dempm/rve_bonded: pipelines/rve_bonded_chart.py FOLDER

Above: axial over lateral stress against axial strain at each lateral pressure, means over the packings with a band of
one standard deviation.  Below: peak and residual ratio against lateral pressure, with the reference values.
Writes bonded.png and bonded.svg into the folder.  Exit code 77: matplotlib is missing.
"""
import csv
import glob
import os
import sys

from chart import Figure, FigureCanvasAgg, matplotlib  # first: it ends the script where matplotlib is missing
from matplotlib.lines import Line2D

matplotlib.rcParams["legend.fontsize"] = "medium"
COLOURS = ["#0072b2", "#009e73", "#d55e00"]
MARKERS = ["o", "s", "^"]


def read(path):
    """Columns of a CSV file by their names without units."""
    with open(path, newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    return {name.split(" [")[0]: [float(row[k]) for row in rows[1:]] for k, name in enumerate(rows[0])}


def ratios(folder, pressure, beta):
    """Axial strains (%) and, of each of them, the stress ratios of all packings."""
    name = "lateral_%dkPa_beta_%g.csv" % (pressure, beta)
    curves = [read(path) for path in [os.path.join(folder, name)] + sorted(glob.glob(os.path.join(folder, "seed_*", name)))]
    strain = [-100.0 * e for e in curves[0]["strain_yy"]]
    return strain, [[c["stress_yy"][k] / c["stress_xx"][k] for c in curves] for k in range(len(strain))]


def mean(values):
    return sum(values) / len(values)


def deviation(values):
    middle = mean(values)
    return (sum((v - middle) ** 2 for v in values) / max(len(values) - 1, 1)) ** 0.5


def curves_panel(ax, folder, pressure, betas):
    for beta, colour in zip(betas, COLOURS):
        strain, values = ratios(folder, pressure, beta)
        middle, wide = [mean(v) for v in values], [deviation(v) for v in values]
        ax.plot(strain, middle, color=colour, linewidth=1.3, zorder=3)
        ax.fill_between(strain, [m - w for m, w in zip(middle, wide)], [m + w for m, w in zip(middle, wide)], color=colour,
                        alpha=0.15, linewidth=0, zorder=2)
    ax.set_title("lateral %g kPa" % pressure, fontsize=9, loc="left")
    ax.set_xlabel("axial strain [%]")
    ax.set_xlim(0, 30)
    ax.set_ylim(bottom=1.0)


def summary_panel(ax, summary, betas, name, reference, factor, label):
    for beta, colour, marker in zip(betas, COLOURS, MARKERS):
        at = [k for k, b in enumerate(summary["beta"]) if b == beta]
        x = [summary["lateral"][k] / 1e3 for k in at]
        ax.errorbar(x, [factor * summary[name][k] for k in at], yerr=[factor * summary[name + "_deviation"][k] for k in at],
                    color=colour, marker=marker, markersize=5, linewidth=1.2, capsize=3, zorder=3)
        ax.plot(x, [factor * summary[reference][k] for k in at], linestyle="none", marker=marker, markersize=10,
                markerfacecolor="none", markeredgecolor=colour, zorder=2)
    ax.set_xlabel("lateral pressure [kPa]")
    ax.set_ylabel(label)
    ax.set_xlim(0, 55)


def main(folder):
    summary = read(os.path.join(folder, "summary.csv"))
    pressures, betas = sorted(set(summary["lateral"])), sorted(set(summary["beta"]))
    figure = Figure(figsize=(9.6, 6.0), layout="constrained")
    axes = figure.subplots(2, 3)
    for ax, pressure in zip(axes[0], pressures):
        curves_panel(ax, folder, round(pressure / 1e3), betas)
    axes[0][0].set_ylabel("axial / lateral stress [-]")
    summary_panel(axes[1][0], summary, betas, "peak", "reference_peak", 1e-3, "peak axial stress [kPa]")
    axes[1][0].set_ylim(bottom=0)
    summary_panel(axes[1][1], summary, betas, "residual_ratio", "reference_residual_ratio", 1.0, "residual stress ratio [-]")
    axes[1][2].axis("off")
    handles = [Line2D([], [], color=c, marker=m, markersize=5, label="bonds of beta = %g" % b if b else "no bonds")
               for b, c, m in zip(betas, COLOURS, MARKERS)]
    handles.append(Line2D([], [], linestyle="none", marker="o", markersize=10, markerfacecolor="none", markeredgecolor="0.4",
                          label="reference"))
    axes[1][2].legend(handles=handles, loc="center left", title="%d packings of 400 discs,\nband and bars: one standard deviation"
                      % summary["seeds"][0], alignment="left")
    figure.suptitle("Biaxial compression of a bonded RVE", x=0.0, ha="left", fontsize=11, fontweight="bold")
    FigureCanvasAgg(figure)
    for end, more in ((".png", {"dpi": 120}), (".svg", {"metadata": {"Date": None}})):
        figure.savefig(os.path.join(folder, "bonded" + end), **more)
    print(os.path.join(folder, "bonded.png"))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
