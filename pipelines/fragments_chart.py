#!/usr/bin/env python3
"""Draws how finely bodies have broken: pipelines/fragments_chart.py [--out FILE.png] FOLDER...

Each FOLDER holds distribution.csv and series.csv as `tmdempm fragments` writes them.  Left: the share of the area that lies
in pieces no wider than a diameter (full line), and the share of the pieces (dashed).  Right: number of pieces and their mean
diameter against time.  Writes FILE.png (the first FOLDER's distribution.png) and the same as .svg.
Exit code 77: matplotlib is missing.
"""
import csv
import os
import sys

from chart import COLOURS, Figure, FigureCanvasAgg


def table(path):
    with open(path, newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    names = [name.split(" [")[0] for name in rows[0]]
    return {name: [float(row[k]) for row in rows[1:]] for k, name in enumerate(names)}


def label(folder):
    """The run's name, where FOLDER is RUN/fragments."""
    folder = os.path.abspath(folder)
    return os.path.basename(os.path.dirname(folder) if os.path.basename(folder) == "fragments" else folder)


def draw(folders):
    figure = Figure(figsize=(9.0, 3.6))
    sizes, times = figure.subplots(1, 2)
    widths = times.twinx()
    widths.grid(False)
    widths.spines["right"].set_visible(True)
    for k, folder in enumerate(folders):
        colour = COLOURS[k % len(COLOURS)]
        d, s = table(os.path.join(folder, "distribution.csv")), table(os.path.join(folder, "series.csv"))
        width = [1e3 * x for x in d["diameter"]]
        sizes.step(width, d["share_of_area"], where="post", color=colour, label=label(folder))
        sizes.step(width, d["share_of_pieces"], where="post", color=colour, linestyle="--", linewidth=1.0)
        t = [1e6 * x for x in s["time"]]
        times.step(t, s["count"], where="post", color=colour)
        widths.plot(t, [1e3 * x for x in s["diameter_mean"]], color=colour, linestyle="--", linewidth=1.0)
    sizes.set_xscale("log")
    sizes.set_xlabel("diameter of equal area / mm")
    sizes.set_ylabel("share no wider: of area, of pieces (dashed)")
    sizes.set_ylim(0.0, 1.02)
    sizes.legend()
    times.set_xlabel("time / µs")
    times.set_ylabel("pieces")
    times.set_ylim(bottom=0.0)
    widths.set_ylabel("mean diameter / mm (dashed)")
    widths.set_ylim(bottom=0.0)
    figure.tight_layout()
    return figure


def main(arguments):
    out = None
    if len(arguments) > 1 and arguments[0] == "--out":
        out, arguments = arguments[1], arguments[2:]
    if not arguments or arguments[0] in ("-h", "--help"):
        sys.exit(__doc__ if not arguments else (print(__doc__) or 0))
    figure = draw(arguments)
    FigureCanvasAgg(figure)
    out = out or os.path.join(arguments[0], "distribution.png")
    for end, more in ((".png", {"dpi": 120}), (".svg", {"metadata": {"Date": None}})):
        figure.savefig(os.path.splitext(out)[0] + end, **more)
    print(out)


main(sys.argv[1:])
