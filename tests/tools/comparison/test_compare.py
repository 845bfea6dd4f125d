#!/usr/bin/env python3
"""Runs tools/compare with Brittle and with an adapter that has one fault after the other: test_compare.py PROGRAMS."""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
# The fault and what its row must say.
FAULTS = {
    "sound": "",
    "open": "1 open",
    "inside-out": "1 inside out, 1 cells of wrong volume",
    "missing": "1 cells of wrong volume, 3 facets with unequal caps",
    "shifted": "3 facets with unequal caps",
    "islands": "1 hold several islands",
    "crossing": "1 cross themselves",
    "truncated": "the pieces cannot be read",
    "miscounting": "answers 9 pieces and writes 8",
    "hanging": "no end within 2 s",
    "crashing": "ended by signal 6",
    "refusing": "a cube is too plain",
    "babbling": "answers 'done soon'",
    "absent": "cannot be started: No such file or directory",
}


def compare(*words):
    return subprocess.run([sys.executable, ROOT / "tools" / "compare", "--binaries", sys.argv[1], *words],
                          capture_output=True, text=True)


def main():
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        adapter = ROOT / "tests" / "tools" / "comparison" / "octants.py"
        command = {fault: f"{sys.executable} {adapter} {fault}" for fault in FAULTS} | {"absent": "/nonexistent"}
        done = compare("--case", "cube/lattice_8", "--peer", "brittle", "--peer", "octants", "--seconds", "0.02",
                       "--limit", "2", "--output", folder,
                       *(word for fault in FAULTS for word in ("--adapter", f"octants {fault}={command[fault]}")))
        if done.returncode != 0:
            sys.exit(f"exit code {done.returncode}\n{done.stdout}{done.stderr}")
        with open(Path(folder) / "rows.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        page = (Path(folder) / "benchmark.md").read_text(encoding="utf-8")
        samples = (Path(folder) / "samples.csv").read_text(encoding="utf-8")
    for row in rows:
        expected = FAULTS[row["peer"][8:]] if row["peer"].startswith("octants") else ""
        found = row["failure"] or row["reason"]
        if (found != "") != (expected != "") or expected not in found:
            wrong.append(f"{row['peer']} says '{found}' instead of '{expected}'")
        if found not in page.replace("&#x27;", "'"):
            wrong.append(f"the page lacks '{found}'")
    if "babbling" not in done.stdout or "&" in done.stdout or "answers 'done soon'" not in done.stdout:
        wrong.append("the lines printed are those of the page")
    if {row["triangles"] for row in rows} != {"12"}:
        wrong.append("the triangles of the mesh are not 12")
    own = [row for row in rows if row["peer"] == "Brittle" and int(row["pieces"]) == 8
           and float(row["worst_cell"]) < 1e-15]
    if not own or len([row for row in rows if row["peer"].startswith("octants")]) != len(FAULTS):
        wrong.append(f"rows are missing among {len(rows)}")
    if "octants sound,1,0," not in samples or "{{" in page or '<i style="color:grey">' not in page:
        wrong.append("samples or page are incomplete")
    for words, part in ((("--case", "cube/nothing"), "there is no case 'cube/nothing'"),
                        (("--peer", "x"), "no peer begins with x"),
                        (("--adapter", "x"), "wants NAME=COMMAND"),
                        (("--adapter", "Brittle=y"), "two peers have the name Brittle"),
                        (("--adapter", "x[fast]=y"), "has the options")):
        done = compare(*words)
        if done.returncode != 1 or part not in done.stderr:
            wrong.append(f"{words} gives {done.returncode} and '{done.stderr.strip()}'")
    if wrong:
        sys.exit("\n".join(wrong))


main()
