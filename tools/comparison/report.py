"""Tables of a run: CSV, and the page docs/benchmark.md from page.md."""
import csv
import html
import io
import subprocess
import time
from pathlib import Path

from . import machine
from .peers import ROOT

FIELDS = ["case", "task", "mesh", "triangles", "site_set", "sites", "peer", "version", "threads", "given_cells",
          "cold_ms", "warm_runs", "min_ms", "p50_ms", "p99_ms", "max_ms", "memory_mb", "memory_ready_mb", "pieces",
          "open", "open_exactly", "crossing", "joined_islands", "negative", "wrong_cells", "worst_cell",
          "volume_error", "wrong_caps", "equal_caps", "reason", "failure", "others_share", "loaded", "load_before",
          "oracle"]
SAMPLE_FIELDS = ["case", "task", "peer", "threads", "repetition", "ms"]
LOADED = "**The machine was loaded by others during this run. Rows with a star are not to be relied on.**\n\n"
TEMPLATE = Path(__file__).parent / "page.md"


def begin(command):
    """What is known about a run at its start."""
    done = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=10"], cwd=ROOT, capture_output=True,
                          text=True)
    about = {**machine.describe(), "load_before": f"{machine.load():.2f}", "command": command,
             "commit": done.stdout.strip() or "unknown", "date": time.strftime("%Y-%m-%d", time.gmtime())}
    print(f"compare: {about['processor']}, {about['cores']} cores, governor {about['governor']}, "
          f"load {about['load_before']}", flush=True)
    return about


def end(about, rows, peers):
    about["load_after"] = f"{machine.load():.2f}"
    sources = {peer.name: peer.source for peer in peers}
    about["versions"] = list(dict.fromkeys((row["peer"], row["version"], sources[row["peer"]])
                                           for row in rows if row["version"]))
    if any(row["loaded"] for row in rows):
        print("compare: other processes used the machine; rows with a star are not to be relied on, "
              "nor to be committed", flush=True)


def draw(folder):
    """Pairs of file and title of the plots of rows.csv in the folder, which are drawn there."""
    drawn = subprocess.run(["/usr/bin/python3", Path(__file__).parent / "plots.py", folder / "rows.csv", folder],
                           capture_output=True, text=True)
    if drawn.returncode != 0:
        why = drawn.stderr.strip().splitlines()[-1:] or ["plots.py failed"]
        print(f"compare: no plots: {why[0]}", flush=True)
    return [tuple(line.split("\t")) for line in drawn.stdout.splitlines()]


def write(file, text):
    """Under a temporary name first, so that a file is whole or the one before."""
    new = file.with_name(file.name + ".new")
    new.write_text(text, encoding="utf-8")
    new.rename(file)


def write_csv(folder, rows, samples, fields=FIELDS, sample_fields=SAMPLE_FIELDS):
    def rounded(value):
        return f"{value:.6g}" if isinstance(value, float) else value

    folder.mkdir(parents=True, exist_ok=True)
    out = io.StringIO()
    table = csv.DictWriter(out, fields, extrasaction="ignore", lineterminator="\n")
    table.writeheader()
    table.writerows({key: rounded(value) for key, value in row.items()} for row in rows)
    write(folder / "rows.csv", out.getvalue())
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows([sample_fields, *([*map(rounded, sample)] for sample in samples)])
    write(folder / "samples.csv", out.getvalue())


def milliseconds(value):
    if value is None or value == "":
        return ""
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}" if value >= 1 else f"{value:.2g}"


def is_sound(row):
    return not row["failure"] and not row["reason"]


def time_cell(row, key="p50_ms"):
    """A time; grey where the pieces are not sound, with a star where others used the machine."""
    if row["failure"] or row.get(key) is None:
        return "-"
    text = milliseconds(row[key]) + ("*" if row["loaded"] else "")
    return text if is_sound(row) else f'<i style="color:grey">{text}</i>'


def verdict(row):
    return row["failure"] or row["reason"] or "sound"


def page_verdict(row):
    return html.escape(verdict(row), quote=False)


def threads_text(row):
    return f"{row['threads']} thread" + ("" if row["threads"] == 1 else "s")


def case_table(rows):
    lines = ["| peer | threads | p50 | p99 | max | cold | runs | peak MB | pieces | worst cell | equal caps | verdict "
             "|",
             "|---|---|---|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        name = row["peer"] + (" †" if row["given_cells"] else "")
        checked = not row["failure"] and "worst_cell" in row
        lines.append(f"| {name} | {row['threads']} | "
                     + " | ".join(time_cell(row, key) for key in ("p50_ms", "p99_ms", "max_ms", "cold_ms"))
                     + f" | {row.get('warm_runs', '')} | {row.get('memory_mb') or 0:.0f} | {row.get('pieces', '')} | "
                     + (f"{row['worst_cell']:.0e} | {100 * row['equal_caps']:.0f} %" if checked else " | ")
                     + f" | {page_verdict(row)} |")
    return "\n".join(lines)


def overview(rows, task, mesh):
    """Medians: a line a peer, a column a count of random sites."""
    chosen = [row for row in rows if row["task"] == task and row["mesh"] == mesh
              and row["site_set"].startswith("random")]
    counts = sorted({row["sites"] for row in chosen})
    if not counts:
        return ""
    lines = ["| peer | threads | " + " | ".join(f"{count:,}" for count in counts) + " |",
             "|---|---|" + "---|" * len(counts)]
    for peer, threads in dict.fromkeys((row["peer"], row["threads"]) for row in chosen):
        own = {row["sites"]: row for row in chosen if (row["peer"], row["threads"]) == (peer, threads)}
        mark = " †" if any(row["given_cells"] for row in own.values()) else ""
        lines.append(f"| {peer}{mark} | {threads} | "
                     + " | ".join(time_cell(own[count]) if count in own else "" for count in counts) + " |")
    return "\n".join(lines)


def losses(rows):
    """Cases in which a sound peer was faster than Brittle with as many threads, and our own rows that fail."""
    lines = []
    for case, task in dict.fromkeys((row["case"], row["task"]) for row in rows):
        here = [row for row in rows if (row["case"], row["task"]) == (case, task)]
        own = {row["threads"]: row for row in here if row["peer"].startswith("Brittle")}
        for row in here:
            if row["peer"].startswith("Brittle"):
                if not is_sound(row):
                    lines.append(f"- {case}: {row['peer']} with {threads_text(row)}: {page_verdict(row)}.")
                continue
            mine = own.get(row["threads"])
            if mine and is_sound(row) and mine.get("p50_ms") and row["p50_ms"] < mine["p50_ms"]:
                lines.append(f"- {case}: {row['peer']} takes {milliseconds(row['p50_ms'])} ms, {mine['peer']} "
                             f"{milliseconds(mine['p50_ms'])} ms, with {threads_text(row)}.")
    return "\n".join(lines) or "None in this run."


def page(rows, about, plots):
    """The text of docs/benchmark.md. `about`: what is known about the run; `plots`: names of the pictures."""
    cases = []
    for case, task in dict.fromkeys((row["case"], row["task"]) for row in rows):
        here = [row for row in rows if (row["case"], row["task"]) == (case, task)]
        box = ", its box" if task == "cells" else ""
        title = f"{here[0]['mesh']}{box}, {here[0]['triangles']:,} triangles, {here[0]['site_set']}"
        cases.append(f"### {title}\n\nOracle: {here[0]['oracle']}. Others used "
                     f"{100 * here[0]['others_share']:.0f} % of the machine.\n\n{case_table(here)}")
    loaded = any(row["loaded"] for row in rows)
    versions = "\n".join(f"| {peer} | {version} | {source} |" for peer, version, source in about["versions"])
    values = {**about, "versions": versions, "cases": "\n\n".join(cases), "losses": losses(rows),
              "loaded": LOADED if loaded else "",
              "bunny": overview(rows, "pieces", "bunny"), "cells": overview(rows, "cells", "bunny"),
              "plots": "\n\n".join(f"![{title}](benchmark/{name})" for name, title in plots)}
    return fill(TEMPLATE, values)


def fill(template, values):
    text = template.read_text(encoding="utf-8")
    for key, value in values.items():
        text = text.replace("{{" + key + "}}", str(value))
    return text
