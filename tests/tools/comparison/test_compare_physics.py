#!/usr/bin/env python3
"""Runs tools/compare --physics with Brittle and with an adapter that has one fault after the other:
test_compare_physics.py PROGRAMS."""
import csv
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
STACK, BALL, SLOPE = "stack_20", "bounce_50", "slope_below"
# The fault, the scene that shows it, and what its row must say.
FAULTS = [
    ("sound", STACK, ""), ("sound", BALL, ""), ("sound", SLOPE, ""),
    ("still", BALL, "never bounces"),
    ("exploding", STACK, "falls within 0.1 s, gains energy"),
    ("exploding", SLOPE, "fixed body 1 moves"),
    ("sinking", STACK, "falls within 0.3 s, 20 bodies through the ground, by up to 60 m"),
    ("sinking", BALL, "1 body through the ground"),
    ("overlapping", STACK, "falls within"),
    ("overlapping", STACK, "bodies more than a fifth inside another"),
    ("drifting", STACK, "moves by 6.0 mm"),
    ("drifting", SLOPE, "fixed body 1 moves by"),
    ("lively", BALL, "restitution 1.300 by height, gains energy"),
    ("dull", BALL, "restitution 0.450 by height"),
    ("nowhere", STACK, "body 0 is nowhere after 1.10 s: its pose is not finite"),
    ("elsewhere", STACK, "body 0 begins 10.0 mm and 0.000 rad from its place"),
    ("turned", SLOPE, "rad from its place"),
    ("stretched", STACK, "the orientation of body 0 has length 2.000 after 0.00 s"),
    ("unfixing", SLOPE, "fixed body 1 moves by"),
    ("short", STACK, "300 records of 20 bodies, not 301 of 20"),
    ("truncated", STACK, "the poses cannot be read"),
    ("boasting", STACK, "the poses cannot be read"),
    ("mistaken", STACK, "does not begin with 'poses 1'"),
    ("silent", STACK, "the poses cannot be read"),
    ("hanging", STACK, "no end within 2 s"),
    ("crashing", STACK, "ended by signal 6"),
    ("refusing", STACK, "a box is too plain"),
    ("babbling", STACK, "answers 'done soon' instead of 'done MEDIAN P95 MAXIMUM'"),
    ("timeless", STACK, "answers 'done nan nan nan'"),
    ("absent", STACK, "cannot be started: No such file or directory"),
]


def compare(*words):
    return subprocess.run([sys.executable, ROOT / "tools" / "compare", "--physics", "--binaries", sys.argv[1], *words],
                          capture_output=True, text=True)


def main():
    wrong = []
    names = list(dict.fromkeys(fault for fault, _, _ in FAULTS))
    with tempfile.TemporaryDirectory() as folder:
        adapter = ROOT / "tests" / "tools" / "comparison" / "closed_forms.py"
        command = {fault: f"{sys.executable} {adapter} {fault}" for fault in names} | {"absent": "/nonexistent"}
        done = compare(*(word for scene in (STACK, BALL, SLOPE) for word in ("--scene", scene)), "--peer", "brittle",
                       "--peer", "forms", "--seconds", "0.01", "--limit", "2", "--output", folder,
                       *(word for fault in names for word in ("--adapter", f"forms {fault}={command[fault]}")))
        if done.returncode != 0:
            sys.exit(f"exit code {done.returncode}\n{done.stdout}{done.stderr}")
        with open(Path(folder) / "rows.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        page = (Path(folder) / "benchmark-physics.md").read_text(encoding="utf-8")
        samples = (Path(folder) / "samples.csv").read_text(encoding="utf-8")
    found = {(row["case"], row["peer"]): row["failure"] or row["reason"] for row in rows}
    for fault, scene, expected in FAULTS:
        reason = found.get((scene, f"forms {fault}"), "no row")
        if (reason != "") != (expected != "") or expected not in reason:
            wrong.append(f"{fault} in {scene} says '{reason}' instead of '{expected}'")
        if reason not in page.replace("&#x27;", "'"):
            wrong.append(f"the page lacks '{reason}'")
    own = [row for row in rows if row["peer"] == "Brittle"]
    if len(own) < 3 or any(row["failure"] or row["reason"] or not 0.0 < float(row["p50_ms"]) for row in own):
        wrong.append(f"Brittle's rows are missing or not sound: {own}")
    if "bounce_50,forms sound,1,0,0.25,0.5,1" not in samples or "{{" in page or '<i style="color:grey">' not in page:
        wrong.append("samples or page are incomplete")
    for words, part in ((("--scene", "nothing"), "there is no scene nothing"),
                        (("--peer", "x"), "no peer begins with x"),
                        (("--adapter", "x"), "wants NAME=COMMAND"), (("--adapter", "x[given]=y"), "has the options")):
        done = compare(*words)
        if done.returncode != 1 or part not in done.stderr:
            wrong.append(f"{words} gives {done.returncode} and '{done.stderr.strip()}'")
    if wrong:
        sys.exit("\n".join(wrong))


main()
