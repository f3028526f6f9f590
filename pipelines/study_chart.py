#!/usr/bin/env python3
"""Draws the charts of a study: pipelines/study_chart.py [--norm NAME]... FOLDER...

FOLDER holds study.csv and study.json as `tmdempm study` writes them.  Of a study of errors: cost.png (error against
CPU and wall time, Pareto front ringed, gates as lines, bars over seeds) and convergence_KNOB.png (error against a
knob, with the observed order); of the norms that are named, or of all.  Of a study of stability: map.png.  Each also as .svg.
Exit code 77: matplotlib is missing.
"""
import csv
import json
import math
import os
import sys
import textwrap

from chart import COLOURS, Figure, FigureCanvasAgg  # first: it ends the script where matplotlib is missing
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

MARKERS = ["o", "s", "^", "D", "v", "P", "X", "<", ">", "*"]
SIZES = [5.0, 7.5, 10.0, 12.5, 4.0, 15.0]
LESS_THAN_A_TICK = 1e-4  # s: clocks do not tell shorter times apart


def number(cell):
    return float(cell) if cell not in ("", "none") else math.nan


def plain(text):
    """'cell [m]' -> 'cell'"""
    return text.split(" [")[0]


class Study:
    def __init__(self, folder, norms=()):
        self.folder = folder
        with open(os.path.join(folder, "study.json"), encoding="utf-8") as stream:
            self.about = json.load(stream)
        if norms:
            self.about["norms"] = [n for n in self.about["norms"] if n["name"] in norms]
        with open(os.path.join(folder, "study.csv"), newline="", encoding="utf-8") as stream:
            rows = list(csv.reader(stream))
        names = [plain(name) for name in rows[0]]
        self.rows = [dict(zip(names, row)) for row in rows[1:]]
        self.knobs = [k for k in self.about["knobs"] if not k["seed"]]

    def varied(self, rows):
        """Knobs that differ between these rows."""
        return [k for k in self.knobs if len({row[k["name"]] for row in rows}) > 1]

    def value(self, knob, row):
        value = knob["values"][knob["choices"].index(row[knob["name"]])]
        return math.nan if value is None else value

    def save(self, figure, name):
        FigureCanvasAgg(figure)
        for end, more in ((".png", {"dpi": 120}), (".svg", {"metadata": {"Date": None}})):
            path = os.path.join(self.folder, name + end)
            part = os.path.join(self.folder, "." + name + ".part" + end)
            figure.savefig(part, bbox_inches="tight", pad_inches=0.15, **more)
            os.replace(part, path)
            if end == ".png":
                print(path)


def text_of(knob, choice):
    unit = "" if knob["unit"] == "-" else " " + knob["unit"]
    try:
        return "%g%s" % (float(choice), unit)
    except ValueError:
        return choice


def label_of(thing):
    return thing["label"] + ("" if thing["unit"] == "-" else " [%s]" % thing["unit"])


def mean(values):
    values = [v for v in values if not math.isnan(v)]
    return sum(values) / len(values) if values else math.nan


def deviation(values):
    values = [v for v in values if not math.isnan(v)]
    if len(values) < 2:
        return 0.0
    middle = sum(values) / len(values)
    return math.sqrt(sum((v - middle) ** 2 for v in values) / (len(values) - 1))


def over_seeds(study, rows):
    """Rows that differ in their seeds only, together, in their order."""
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[k["name"]] for k in study.knobs), []).append(row)
    return list(groups.values())


# ---- what a point looks like: colour, marker, size and filling, a knob each ----

class Look:
    def __init__(self, study, rows):
        self.ways = study.varied(rows)[:4]
        # names are told apart best by colour
        self.ways.sort(key=lambda k: all(v is not None for v in k["values"]))
        self.used = [[c for c in k["choices"] if any(row[k["name"]] == c for row in rows)] for k in self.ways]

    def of(self, row):
        style = {"color": COLOURS[0], "marker": "o", "markersize": 6.0, "markerfacecolor": COLOURS[0],
                 "markeredgecolor": "white"}
        for way, (knob, used) in enumerate(zip(self.ways, self.used)):
            k = used.index(row[knob["name"]])
            if way == 0:
                style["color"] = style["markerfacecolor"] = COLOURS[k % len(COLOURS)]
            elif way == 1:
                style["marker"] = MARKERS[k % len(MARKERS)]
            elif way == 2:
                style["markersize"] = SIZES[k % len(SIZES)]
            elif k > 0:
                style["markerfacecolor"], style["markeredgecolor"] = "white", style["color"]
        return style

    def legend(self):
        handles = []
        for way, (knob, used) in enumerate(zip(self.ways, self.used)):
            handles.append(Line2D([], [], linestyle="none", label=r"$\bf{%s}$" % knob["label"].replace(" ", r"\ ").replace("_", r"\_")))
            for choice in used:
                style = self.of({**{k["name"]: u[0] for k, u in zip(self.ways, self.used)}, knob["name"]: choice})
                if way > 0:
                    style["color"] = "0.4"
                    style["markerfacecolor"] = "white" if style["markerfacecolor"] == "white" else "0.4"
                    style["markeredgecolor"] = "0.4" if style["markerfacecolor"] == "white" else "white"
                handles.append(Line2D([], [], linestyle="none", label=text_of(knob, choice), **style))
        return handles


def log_axis(axis, low, high):
    """Labels at 1, 2, 5 where decades alone would leave the axis bare."""
    if high / low < 100.0:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: "%g" % value))
    axis.set_minor_formatter(NullFormatter())


def set_log_limits(ax, which, values):
    values = [v for v in values if v > 0 and math.isfinite(v)]
    if not values:
        return
    low, high = min(values), max(values)
    margin = max((high / low) ** 0.08, 1.3)
    (ax.set_xlim if which == "x" else ax.set_ylim)(low / margin, high * margin)
    log_axis(ax.xaxis if which == "x" else ax.yaxis, low / margin, high * margin)


def finish(study, figure, handles, note=""):
    figure.suptitle(study.about["title"] or os.path.basename(study.folder), x=0.0, ha="left", fontsize=11, fontweight="bold")
    if handles:
        figure.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), borderaxespad=1.0)
    figure.text(0.0, -0.02, note, fontsize=7, color="0.4", va="top", ha="left")


def drawable(study):
    """Norms that have errors, and the runs that have one of these."""
    done = [row for row in study.rows if row["outcome"] == "done"]
    norms = [n for n in study.about["norms"] if any(number(row[n["name"] + ".error"]) > 0 for row in done)]
    return norms, [row for row in done if any(number(row[n["name"] + ".error"]) > 0 for n in norms)]


# ---- error against cost ----

def pareto(points):
    """Those that no other beats in both."""
    best, front = math.inf, []
    for x, y, k in sorted(points):
        if y < best:
            front.append((x, y, k))
            best = y
    return front


def draw_gates(ax, norm, values):
    for bound in sorted(set(norm["gates"])):
        if bound > 0:
            ax.axhline(bound, color="#c00000", linestyle="--", linewidth=1.0, zorder=1)
            ax.annotate("gate %.3g" % bound, (1.0, bound), xycoords=("axes fraction", "data"), xytext=(-2, 2),
                        textcoords="offset points", ha="right", va="bottom", color="#c00000", fontsize=7)
            values.append(bound)


def draw_scatter(ax, study, norm, values):
    """How far single runs of the reference are from their own mean."""
    if not study.about["reference_mean"]:
        return
    own = [number(row[norm["name"] + ".error"]) for row in study.rows if row["reference"] == "yes"]
    own += [number(row[norm["name"] + ".error"]) for row in study.rows
            if row["reference"] != "yes" and any(all(row[k["name"]] == r[k["name"]] for k in study.knobs)
                                                 for r in study.rows if r["reference"] == "yes")]
    scatter = mean(own)
    if scatter > 0:
        ax.axhspan(1e-300, scatter, color="0.93", zorder=0)
        ax.annotate("seed-to-seed scatter", (0.0, scatter), xycoords=("axes fraction", "data"), xytext=(3, -2),
                    textcoords="offset points", va="top", color="0.4", fontsize=7, zorder=1.2,
                    bbox={"facecolor": "0.93", "edgecolor": "none", "pad": 0.8})
        values.append(scatter)


def cost_panel(ax, study, look, groups, norm, cost):
    points, xs, ys = [], [], []
    for k, group in enumerate(groups):
        errors = [number(row[norm["name"] + ".error"]) for row in group]
        costs = [max(number(row[cost]), LESS_THAN_A_TICK) for row in group]
        x, y = mean(costs), mean(errors)
        if not (y > 0 and math.isfinite(y) and x > 0):
            continue
        points.append((x, y, k))
        dx, dy = deviation(costs), deviation(errors)
        if dy > 0:
            ax.errorbar([x], [y], yerr=[[min(dy, 0.9 * y)], [dy]], xerr=[[min(dx, 0.9 * x)], [dx]], color="0.6",
                        linewidth=0.8, capsize=2, zorder=2)
        ax.plot([x], [y], linestyle="none", zorder=4, **look.of(group[0]))
        xs.append(x)
        ys += [y, y + dy]
    front = pareto(points)
    ax.plot([p[0] for p in front], [p[1] for p in front], color="0.3", linewidth=1.0, zorder=1.5)
    ax.plot([p[0] for p in front], [p[1] for p in front], linestyle="none", marker="o", markersize=18,
            markerfacecolor="none", markeredgecolor="0.3", markeredgewidth=0.8, zorder=3)
    draw_gates(ax, norm, ys)
    draw_scatter(ax, study, norm, ys)
    ax.set_xscale("log")
    ax.set_yscale("log")
    set_log_limits(ax, "x", xs)
    set_log_limits(ax, "y", ys)


def chart_cost(study):
    norms, rows = drawable(study)
    if not norms:
        return
    look, groups = Look(study, rows), over_seeds(study, rows)
    figure = Figure(figsize=(9.0, 3.1 * len(norms)), layout="constrained")
    axes = figure.subplots(len(norms), 2, squeeze=False)
    for i, norm in enumerate(norms):
        for j, (cost, name) in enumerate((("cpu", "CPU time [s]"), ("wall", "wall time [s]"))):
            ax = axes[i][j]
            cost_panel(ax, study, look, groups, norm, cost)
            ax.set_ylabel("error: " + label_of(norm) if j == 0 else "")
            if i + 1 == len(norms):
                ax.set_xlabel(name)
    handles = look.legend() + [Line2D([], [], linestyle="none", label=""),
                               Line2D([], [], color="0.3", marker="o", markersize=12, markerfacecolor="none",
                                      linewidth=1.0, label="Pareto front")]
    finish(study, figure, handles, "time of the loop, without set-up; " + study.about["processor"])
    study.save(figure, "cost")


# ---- error against a knob ----

def slope(points):
    points = [(math.log(x), math.log(y)) for x, y in points if x > 0 and y > 0]
    n = len(points)
    if n < 2:
        return math.nan
    mx, my = sum(p[0] for p in points) / n, sum(p[1] for p in points) / n
    below = sum((p[0] - mx) ** 2 for p in points)
    return sum((p[0] - mx) * (p[1] - my) for p in points) / below if below else math.nan


def chart_against(study, name):
    knob = next(k for k in study.about["knobs"] if k["name"] == name)
    norms, rows = drawable(study)
    if not norms:
        return
    numeric = all(v is not None and v > 0 for v in knob["values"])
    others = [k for k in study.varied(rows) if k["name"] != name]
    figure = Figure(figsize=(7.2, 3.3 * len(norms)), layout="constrained")
    for i, ax in enumerate(figure.subplots(len(norms), 1, squeeze=False)[:, 0]):
        norm, lines, xs, ys = norms[i], {}, [], []
        for group in over_seeds(study, rows):
            x = study.value(knob, group[0]) if numeric else knob["choices"].index(group[0][name])
            errors = [number(row[norm["name"] + ".error"]) for row in group]
            if mean(errors) > 0:
                key = tuple(group[0][k["name"]] for k in others)
                lines.setdefault(key, []).append((x, mean(errors), deviation(errors)))
        for k, (key, line) in enumerate(sorted(lines.items(), key=lambda item: [o["choices"].index(c) for o, c in zip(others, item[0])])):
            line.sort()
            order = slope([p[:2] for p in line]) if numeric else math.nan
            what = ", ".join(text_of(o, c) if o["unit"] != "-" or math.isnan(float_or_nan(c)) else o["label"] + " " + c
                             for o, c in zip(others, key)) or norm["label"]
            if not math.isnan(order):
                what += "  (order %.2f)" % order
            ax.errorbar([p[0] for p in line], [p[1] for p in line],
                        yerr=[[min(p[2], 0.9 * p[1]) for p in line], [p[2] for p in line]], capsize=2, linewidth=1.2, linestyle="-" if numeric else "none",
                        color=COLOURS[k % len(COLOURS)], marker=MARKERS[k % len(MARKERS)],
                        markersize=max(9.0 - 1.5 * k, 4.0), label=what)  # of lines that coincide all show
            xs += [p[0] for p in line]
            ys += [p[1] for p in line] + [p[1] + p[2] for p in line]
        draw_gates(ax, norm, ys)
        draw_scatter(ax, study, norm, ys)
        ax.set_yscale("log")
        set_log_limits(ax, "y", ys)
        if numeric:
            ax.set_xscale("log")
            set_log_limits(ax, "x", xs)
        else:
            ax.set_xticks(range(len(knob["choices"])))
            ax.set_xticklabels([textwrap.fill(text_of(knob, c), 12) for c in knob["choices"]])
        ax.set_ylabel("error: " + label_of(norm))
        ax.set_xlabel(label_of(knob) if i + 1 == len(norms) else "")
        if len(lines) > 1 or numeric:
            ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    finish(study, figure, [])
    study.save(figure, "convergence_" + name)


def float_or_nan(text):
    try:
        return float(text)
    except ValueError:
        return math.nan


# ---- stability ----

VERDICTS = [("stable", "stable, no guard minds", "#009e73", "o"),
            ("conservative", "guarded though sound", "#56b4e9", "^"),
            ("guarded", "guarded before garbage", "#e69f00", "s"),
            ("guarded late", "GUARDED LATE: garbage already", "#cc79a7", "P"),
            ("garbage unguarded", "GARBAGE, UNGUARDED", "#c00000", "X")]


def unevenness(values):
    """Widest gap over the narrowest."""
    gaps = [b - a for a, b in zip(values, values[1:])]
    return max(gaps) / min(gaps) if gaps else 1.0


def map_axis(study, ax, name, which):
    """Places of the knob's choices on an axis."""
    knob = next(k for k in study.about["knobs"] if k["name"] == name)
    numeric = all(v is not None for v in knob["values"])
    places = dict(zip(knob["choices"], knob["values"] if numeric else range(len(knob["choices"]))))
    (ax.set_xlabel if which == "x" else ax.set_ylabel)(label_of(knob))
    values = sorted(places.values())
    if numeric and values[0] > 0 and unevenness([math.log(v) for v in values]) < unevenness(values):
        (ax.set_xscale if which == "x" else ax.set_yscale)("log")
        set_log_limits(ax, which, values)
    elif not numeric:
        (ax.set_xticks if which == "x" else ax.set_yticks)(list(places.values()))
        (ax.set_xticklabels if which == "x" else ax.set_yticklabels)([text_of(knob, c) for c in knob["choices"]])
        (ax.set_xlim if which == "x" else ax.set_ylim)(-0.6, len(values) - 0.4)
    return places


def map_panel(study, ax, rows):
    about = study.about
    two = len(about["map"]) > 1
    xs = map_axis(study, ax, about["map"][0], "x")
    ys = map_axis(study, ax, about["map"][1], "y") if two else None
    worst = {}
    for row in rows:  # of several seeds the worst counts
        place = (xs[row[about["map"][0]]], ys[row[about["map"][1]]] if two else 0.0)
        ranks = [v[0] for v in VERDICTS]
        if row["verdict"] in ranks:
            worst[place] = max(worst.get(place, 0), ranks.index(row["verdict"]))
    for (x, y), verdict in worst.items():
        ax.plot([x], [y], linestyle="none", color=VERDICTS[verdict][2], marker=VERDICTS[verdict][3], markersize=9,
                markeredgecolor="black", markeredgewidth=0.6, zorder=3)
    if not two:
        ax.set_yticks([])
        ax.set_ylim(-1.0, 1.0)
        ax.spines["left"].set_visible(False)
    limits = ax.get_xlim(), ax.get_ylim()
    for k, curve in enumerate(about["curves"]):
        style = {"color": "0.2", "linestyle": ["-", "--", ":", "-."][k % 4], "linewidth": 1.2, "label": curve["label"]}
        if two:
            pairs = [(x, y) for x, y in zip(curve["x"], curve["y"]) if x is not None and y is not None]
            ax.plot([p[0] for p in pairs], [p[1] for p in pairs], zorder=2, **style)
        elif curve["y"] and curve["y"][0] is not None:
            ax.axvline(curve["y"][0], zorder=2, **style)
    ax.set_xlim(limits[0])
    ax.set_ylim(limits[1])


def chart_map(study):
    rows = [row for row in study.rows if row["guards"] == "on"]
    others = [k for k in study.varied(rows) if k["name"] not in study.about["map"]]
    panels = {}
    for row in rows:
        panels.setdefault(tuple(row[k["name"]] for k in others), []).append(row)
    two = len(study.about["map"]) > 1
    columns = 1 if not two else min(3, len(panels))
    lines = (len(panels) + columns - 1) // columns
    figure = Figure(figsize=(6.4 if columns == 1 else 4.2 * columns, (3.8 if two else 1.7) * lines), layout="constrained")
    axes = figure.subplots(lines, columns, squeeze=False).ravel()
    for ax in axes[len(panels):]:
        ax.set_visible(False)
    for ax, (key, of_panel) in zip(axes, panels.items()):
        map_panel(study, ax, of_panel)
        if key:
            ax.set_title(", ".join("%s = %s" % (k["label"], text_of(k, c)) for k, c in zip(others, key)), fontsize=9, loc="left")
    seen = {row["verdict"] for row in rows}
    handles = [Line2D([], [], linestyle="none", color=c, marker=m, markersize=9, markeredgecolor="black", label=text)
               for name, text, c, m in VERDICTS if name in seen]
    handles += [line for line in axes[0].get_lines() if not line.get_label().startswith("_")]
    finish(study, figure, handles)
    study.save(figure, "map")


def main(words):
    norms, folders = [], []
    while words:
        word = words.pop(0)
        if word == "--norm" and words:
            norms.append(words.pop(0))
        else:
            folders.append(word)
    if not folders:
        sys.exit(__doc__)
    for folder in folders:
        study = Study(folder.rstrip("/"), norms)
        if study.about["kind"] == "stability":
            chart_map(study)
            continue
        chart_cost(study)
        for name in study.about["against"]:
            chart_against(study, name)


if __name__ == "__main__":
    main(sys.argv[1:])
