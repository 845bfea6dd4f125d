#!/usr/bin/env python3
"""Draws the cost of a blow against the size of the mesh (docs/images/blows.svg) from the output of the benchmark:

    brittle_bench --benchmark_filter='^blow/ball_[0-9]+k/(iter|as_many)' --benchmark_out=blows.json
    tools/bench/plot_blows.py blows.json docs/images/blows.svg

Both axes are logarithmic. Lines: a cut of the whole mesh (where it was measured); blows with damage of a tenth of the
size, which holds a fixed share of the triangles; and blows whose damage holds as many triangles at every size.
"""
import json
import math
import sys

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 720, 400, 64, 170, 24, 52
SERIES = [("whole", "whole mesh cut", "#b4532a"), ("share", "blow, a fixed share", "#2a6fb4"),
          ("number", "blow, a fixed number", "#3a8f5a")]  # of triangles


def read(path):
    """Returns {series: [(triangles, milliseconds), ...]} by ascending size."""
    with open(path, encoding="utf-8") as file:
        runs = json.load(file)["benchmarks"]
    as_many = [run for run in runs if "/as_many" in run["name"]]
    tenth = [run for run in runs if run not in as_many]
    smallest = min(tenth, key=lambda run: run["triangles"])

    def line(some, key):
        return sorted((run["triangles"], run[key]) for run in some if run.get(key, 0.0) > 0.0)

    return {"whole": line(tenth, "whole"), "share": line(tenth, "first"), "number": line([smallest, *as_many], "first")}


def text(x, y, words, anchor="middle", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{words}</text>'


def plot(lines):
    """Returns the SVG."""
    points = [point for line in lines.values() for point in line]
    low = [10 ** math.floor(math.log10(min(p[k] for p in points))) for k in (0, 1)]
    high = [10 ** math.ceil(math.log10(max(p[k] for p in points))) for k in (0, 1)]

    def at(k, value):
        share = math.log(value / low[k]) / math.log(high[k] / low[k])
        return LEFT + share * (WIDTH - LEFT - RIGHT) if k == 0 else HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" '
           f'font-size="13" fill="#333">', f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>']
    for k in (0, 1):
        value = low[k]
        while value <= high[k] * 1.001:
            label = f"{value:,.0f}"
            if k == 0:
                svg.append(f'<path d="M{at(0, value):.1f} {TOP}V{HEIGHT - BOTTOM}" stroke="#ddd"/>')
                svg.append(text(at(0, value), HEIGHT - BOTTOM + 18, label))
            else:
                svg.append(f'<path d="M{LEFT} {at(1, value):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>')
                svg.append(text(LEFT - 8, at(1, value) + 4, label, "end"))
            value *= 10
    svg.append(text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 12, "triangles"))
    svg.append(text(18, (TOP + HEIGHT - BOTTOM) / 2, "milliseconds",
                    more=f' transform="rotate(-90 18 {(TOP + HEIGHT - BOTTOM) / 2:.1f})"'))
    ends = []  # labels of lines, which must not cover each other
    for key, name, colour in SERIES:
        line = [(at(0, x), at(1, y)) for x, y in lines[key]]
        if not line:
            continue
        svg.append(f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in line)}" fill="none" '
                   f'stroke="{colour}" stroke-width="2"/>')
        svg.extend(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>' for x, y in line)
        ends.append([line[-1][0], line[-1][1], name, colour])
    ends.sort(key=lambda end: end[1])
    for before, end in zip(ends, ends[1:]):
        if abs(end[0] - before[0]) < 100:
            end[1] = max(end[1], before[1] + 16)
    svg.extend(text(x + 10, y + 4, name, "start", f' style="fill:{colour}"') for x, y, name, colour in ends)
    return "\n".join(svg) + "\n</svg>\n"


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: plot_blows.py BENCHMARK.json PLOT.svg")
    with open(sys.argv[2], "w", encoding="utf-8") as out:
        out.write(plot(read(sys.argv[1])))
