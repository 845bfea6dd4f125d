"""Tables of a run: CSV, and the page docs/benchmark.md from page.md."""
import csv
import html
from pathlib import Path

FIELDS = ["case", "task", "mesh", "triangles", "site_set", "sites", "peer", "version", "threads", "given_cells",
          "cold_ms", "warm_runs", "min_ms", "p50_ms", "p99_ms", "max_ms", "memory_mb", "memory_ready_mb", "pieces",
          "open", "open_exactly", "crossing", "joined_islands", "negative", "wrong_cells", "worst_cell",
          "volume_error", "wrong_caps", "equal_caps", "reason", "failure", "others_share", "loaded", "load_before",
          "oracle"]
LOADED = "**The machine was loaded by others during this run. Rows with a star are not to be relied on.**\n\n"
TEMPLATE = Path(__file__).parent / "page.md"


def write_csv(folder, rows, samples):
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "rows.csv", "w", newline="", encoding="utf-8") as out:
        table = csv.DictWriter(out, FIELDS, extrasaction="ignore", lineterminator="\n")
        table.writeheader()
        table.writerows({key: f"{value:.6g}" if isinstance(value, float) else value for key, value in row.items()}
                        for row in rows)
    with open(folder / "samples.csv", "w", newline="", encoding="utf-8") as out:
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["case", "task", "peer", "threads", "repetition", "ms"])
        table.writerows([*sample[:5], f"{sample[5]:.6g}"] for sample in samples)


def milliseconds(value):
    if value is None or value == "":
        return ""
    return f"{value:,.0f}" if value >= 100 else f"{value:.1f}" if value >= 1 else f"{value:.2f}"


def is_sound(row):
    return not row["failure"] and not row["reason"]


def time_cell(row, key="p50_ms"):
    """A time; grey where the pieces are not sound, with a star where others used the machine."""
    if row["failure"] or row.get(key) is None:
        return "-"
    text = milliseconds(row[key]) + ("*" if row["loaded"] else "")
    return text if is_sound(row) else f'<i style="color:grey">{text}</i>'


def verdict(row):
    if row["failure"]:
        return html.escape(row["failure"])
    return "sound" if is_sound(row) else html.escape(row["reason"])


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
                     + f" | {verdict(row)} |")
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
                    lines.append(f"- {case}: {row['peer']} with {row['threads']} threads: {verdict(row)}.")
                continue
            mine = own.get(row["threads"])
            if mine and is_sound(row) and mine.get("p50_ms") and row["p50_ms"] < mine["p50_ms"]:
                lines.append(f"- {case}: {row['peer']} takes {milliseconds(row['p50_ms'])} ms, {mine['peer']} "
                             f"{milliseconds(mine['p50_ms'])} ms, with {row['threads']} threads.")
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
    text = TEMPLATE.read_text(encoding="utf-8")
    for key, value in values.items():
        text = text.replace("{{" + key + "}}", str(value))
    return text
