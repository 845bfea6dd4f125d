#!/usr/bin/python3
"""Draws the rows of tools/compare as SVG, by Debian's matplotlib: plots.py ROWS.csv FOLDER. Prints a line a picture."""
import csv
import sys
from pathlib import Path

try:
    import matplotlib
except ImportError:
    sys.exit("plots.py: no matplotlib; tools/compare --install gets Debian's python3-matplotlib")
matplotlib.use("Agg")
matplotlib.rcParams.update({"svg.hashsalt": "compare", "svg.fonttype": "none", "font.size": 9, "axes.grid": True,
                            "grid.alpha": 0.3})
from matplotlib import pyplot  # noqa: E402

COLOURS = dict(zip(("Brittle", "Manifold", "CGAL corefinement", "CGAL clip", "three-bvh-csg", "three-pinata", "Blender",
                    "OpenVDB", "voro++", "stock Bullet", "Bullet", "Rapier",
                    "Jolt"),
                   ("#c0392b", "#2471a3", "#1e8449", "#82c99a", "#7d3c98", "#b9770e", "#d4ac0d", "#148f77", "#34495e",
                    "#1e8449", "#2471a3", "#b9770e", "#7d3c98")))


def colour(peer):
    return next((value for name, value in COLOURS.items() if peer.startswith(name)), "#555555")


def save(figure, folder, name, title):
    figure.tight_layout()
    figure.savefig(folder / name, metadata={"Date": None})
    pyplot.close(figure)
    print(f"{name}\t{title}")


def against_sites(rows, folder, task, mesh, key, label, name, title):
    chosen = [row for row in rows if row["task"] == task and row["mesh"] == mesh
              and row["site_set"].startswith("random") and row[key]]
    if len({row["sites"] for row in chosen}) < 2:
        return
    figure, axes = pyplot.subplots(figsize=(7.5, 4.5))
    for peer, threads in dict.fromkeys((row["peer"], row["threads"]) for row in chosen):
        own = sorted((row for row in chosen if (row["peer"], row["threads"]) == (peer, threads) and not row["failure"]),
                     key=lambda row: int(row["sites"]))
        if not own:
            continue
        xs, ys = [int(row["sites"]) for row in own], [float(row[key]) for row in own]
        axes.plot(xs, ys, color=colour(peer), linewidth=1, linestyle="-" if threads == "1" else "--",
                  label=f"{peer}, {threads} thread{'s' if threads != '1' else ''}")
        for x, y, row in zip(xs, ys, own):
            sound = not row["reason"]
            axes.plot([x], [y], marker="o", markersize=5, color=colour(peer) if sound else "#aaaaaa",
                      markerfacecolor=colour(peer) if sound else "white")
    axes.set(xscale="log", yscale="log", xlabel="sites", ylabel=label,
             title=title + "; grey rings: pieces are not sound")
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(figure, folder, name, title)


def by_case(rows, folder, name, title, label="median, ms"):
    """One line a case, one mark a peer, for the fastest of its thread counts."""
    chosen = [row for row in rows if row["p50_ms"] and not row["failure"]]
    best = {}
    for row in chosen:  # the fastest of a peer's thread counts
        key = row["case"], row["peer"]
        if key not in best or float(row["p50_ms"]) < float(best[key]["p50_ms"]):
            best[key] = row
    cases = list(dict.fromkeys(row["case"] for row in chosen))
    peers = list(dict.fromkeys(row["peer"] for row in chosen))
    if not cases:
        return
    figure, axes = pyplot.subplots(figsize=(7.5, 0.55 * len(cases) + 1.5))
    for k, peer in enumerate(peers):
        for y, case in enumerate(cases):
            row = best.get((case, peer))
            if row is None:
                continue
            sound = not row["reason"]
            axes.plot([float(row["p50_ms"])], [y + 0.09 * (k - len(peers) / 2)], marker="o", markersize=5,
                      color=colour(peer) if sound else "#aaaaaa", markerfacecolor=colour(peer) if sound else "white",
                      linestyle="")
        axes.plot([], [], marker="o", color=colour(peer), linestyle="", label=peer)
    axes.set(xscale="log", xlabel=label, yticks=range(len(cases)), title=title + "; grey rings: not sound")
    axes.set_yticklabels(cases)
    axes.invert_yaxis()
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(figure, folder, name, title)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    folder = Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    if rows and rows[0]["task"] == "physics":
        by_case(rows, folder, "steps.svg", "Scenes of rigid bodies", "median of a step, ms")
        return
    against_sites(rows, folder, "pieces", "bunny", "p50_ms", "median, ms", "bunny.svg", "The bunny broken")
    against_sites(rows, folder, "pieces", "bunny", "memory_mb", "peak memory of the process, MB", "memory.svg",
                  "Memory for the bunny")
    against_sites(rows, folder, "cells", "bunny", "p50_ms", "median, ms", "cells.svg",
                  "Voronoi cells in the bunny's box")
    others = [row for row in rows if row["task"] == "pieces" and row["mesh"] != "bunny"]
    by_case(others, folder, "meshes.svg", "Other meshes and sites")


main()
