"""tools/compare --physics: the same scenes of rigid bodies in Brittle and in other engines, judged, then timed.

    tools/compare --physics --install    installs the peers (Debian, npm) and compiles their adapters; once
    tools/compare --physics --page       a quarter of an hour; writes docs/benchmark-physics.md, with data beside it
    tools/compare --physics --scene arch_09 --peer Brittle --peer Rapier

docs/benchmark-physics.md says what is compared and how to add a peer. Results are in build/compare/physics.
"""
import argparse
import json
import math
import os
import subprocess
import time
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from . import machine, peers, report
from .measure import LOADED
from .session import Failed, Session

COMMAND = "tools/compare --physics"
TARGETS = ("compare_physics", "compare_brittle_physics")
MAX_RUNS = 25        # of a peer in a scene
JUDGE_SECONDS = 300
TEMPLATE = Path(__file__).parent / "physics_page.md"
FIELDS = ["case", "task", "bodies", "steps", "step_seconds", "peer", "version", "threads", "runs", "p50_ms", "p95_ms",
          "max_ms", "memory_mb", "truth", "result", "reason", "failure", "others_share", "loaded", "load_before"]
SAMPLE_FIELDS = ["case", "peer", "threads", "repetition", "p50_ms", "p95_ms", "max_ms"]


def known(binaries):
    """All peers, installed or not."""
    own, node = binaries / "compare_brittle_physics", peers.BUILD / "node"
    return [
        peers.Peer("Brittle", [own], ["solver"], threads=tuple(sorted({1, peers.CORES})), source="this commit",
                   needs=own),
        peers.Peer("stock Bullet in Brittle", [own], ["bullet"], source="this commit, on Debian's Bullet", needs=own),
        peers.Peer("Bullet", **peers.compiled(
            "bullet", "-lBulletDynamics", "-lBulletCollision", "-lLinearMath", flags=("-I/usr/include/bullet",),
            source="Debian", packages=("libbullet-dev",), version="3.24+dfsg-2")),
        *(peers.Peer(name, ["node", script], folder=node, source="npm", packages=("nodejs",),
                     needs=node / "node_modules" / package)
          for name, script, package in (("Rapier", "rapier.mjs", "@dimforge"), ("Jolt", "jolt.mjs", "jolt-physics"))),
    ]


@dataclass
class Scene:
    name: str
    title: str
    file: Path
    bodies: int
    steps: int
    step_seconds: float


def run_own(binaries, *words):
    done = subprocess.run([binaries / "compare_physics", *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{COMMAND}: {done.stderr.strip() or f'compare_physics ended with {done.returncode}'}")
    return done.stdout


def prepare(name, title, binaries):
    folder = peers.BUILD / "scenes"
    folder.mkdir(parents=True, exist_ok=True)
    bodies, steps, step_seconds = run_own(binaries, "scene", name, file := folder / f"{name}.scene").split()
    return Scene(name, title, file, int(bodies), int(steps), float(step_seconds))


class Run(Session):
    """Milliseconds of a step, a triple a run: median, 95th percentile, maximum."""
    DONE = "done MEDIAN P95 MAXIMUM"

    def take(self, values):
        times = [float(value) for value in values[:3]]
        if len(times) < 3 or not all(0.0 <= ms < math.inf for ms in times):
            raise ValueError
        self.samples.append(times)


def judge(session, scene, binaries):
    """The verdict on the poses of the last run."""
    file = peers.BUILD / f"poses_{os.getpid()}"
    try:
        session.write(file)
        done = subprocess.run([binaries / "compare_physics", "judge", scene.name, scene.file, file],
                              capture_output=True, text=True, timeout=JUDGE_SECONDS)
        if done.returncode != 0:
            return {"reason": "the poses cannot be read: " + done.stderr.strip().replace(str(file), "the file")}
        return json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        return {"reason": f"the judge did not end within {JUDGE_SECONDS} s"}
    except Failed as failed:
        return {"reason": f"gave no poses: {failed}"}
    finally:
        for name in (file, file.with_name(file.name + ".new")):
            name.unlink(missing_ok=True)


def run_scene(scene, chosen, seconds, limit, binaries):
    """Rows, and samples as SAMPLE_FIELDS. All peers run in turns, each until its runs took `seconds`."""
    logs = peers.BUILD / "logs"
    logs.mkdir(parents=True, exist_ok=True)
    rows, sessions, watch, load_before = [], [], machine.Others(), machine.load()
    for peer in chosen:
        for threads in peer.threads:
            row = {"case": scene.name, "task": "physics", "bodies": scene.bodies, "steps": scene.steps,
                   "step_seconds": scene.step_seconds, "peer": peer.name, "threads": threads, "version": "",
                   "failure": "", "reason": "", "loaded": False}
            rows.append(row)
            try:
                log = logs / f"{scene.name}-{peer.name}-{threads}.log".replace("/", "_").replace(" ", "_")
                sessions.append((row, Run(peer, threads, (scene.file,), limit, log)))
            except Failed as failed:
                row["failure"] = str(failed)
    active, spent = list(sessions), {}
    while active:
        going = []
        for row, session in active:
            begin = time.monotonic()
            try:
                session.run()
                spent[session] = spent.get(session, 0.0) + time.monotonic() - begin
                if spent[session] < seconds and len(session.samples) < MAX_RUNS:
                    going.append((row, session))
            except Failed as failed:
                row["failure"] = str(failed)
                session.kill()
        active = going
    for _, session in sessions:
        if session.process:
            watch.note(session.process.pid)
    others, samples = watch.share(), []
    for row, session in sessions:
        row.update(version=session.version, runs=len(session.samples), memory_mb=round(session.memory, 1))
        if session.samples:
            p50, p95, most = zip(*session.samples)
            row.update(p50_ms=median(p50), p95_ms=median(p95), max_ms=max(most))
            samples += [(scene.name, row["peer"], row["threads"], k, *times) for k, times in enumerate(session.samples)]
        if not row["failure"]:
            row.update(judge(session, scene, binaries))
        session.end()
    for row in rows:
        row.update(others_share=round(others, 3), loaded=others > LOADED, load_before=load_before)
        times = f"{row['p50_ms']:9.3f} {row['p95_ms']:9.3f} ms" if row.get("p50_ms") is not None else " " * 22
        print(f"{row['case']:14} {row['peer']:24} {row['threads']:2} {times} {'*' if row['loaded'] else ' '} "
              f"{report.verdict(row)}", flush=True)
    return rows, samples


def cell(row):
    """Median and 95th percentile; grey where the judge found a fault."""
    if row["failure"]:
        return "-"
    text = " / ".join(report.milliseconds(row[key]) for key in ("p50_ms", "p95_ms")) + ("*" if row["loaded"] else "")
    return text if report.is_sound(row) else f'<i style="color:grey">{text}</i>'


def overview(rows, scenes):
    """A line a scene, a column a peer and count of threads."""
    columns = list(dict.fromkeys((row["peer"], row["threads"]) for row in rows))
    many = {peer for peer, threads in columns if threads > 1}
    names = [f"{peer}, {threads} thread{'s' if threads > 1 else ''}" if peer in many else peer
             for peer, threads in columns]
    lines = ["| scene | truth | " + " | ".join(names) + " |", "|---|---|" + "---|" * len(names)]
    for scene in scenes:
        here = {(row["peer"], row["threads"]): row for row in rows if row["case"] == scene.name}
        truth = next((row["truth"] for row in here.values() if row.get("truth")), "")
        lines.append(f"| {scene.title} | {truth} | "
                     + " | ".join(cell(here[column]) if column in here else "" for column in columns) + " |")
    return "\n".join(lines)


def table(rows):
    lines = ["| peer | threads | p50 | p95 | max | runs | peak MB | result | verdict |",
             "|---|---|---|---|---|---|---|---|---|"]
    for row in rows:
        times = " | ".join(report.time_cell(row, key) for key in ("p50_ms", "p95_ms", "max_ms"))
        lines.append(f"| {row['peer']} | {row['threads']} | {times} | {row.get('runs', '')} | "
                     f"{row.get('memory_mb') or 0:.0f} | {row.get('result', '')} | {report.page_verdict(row)} |")
    return "\n".join(lines)


def page(rows, about, plots, scenes):
    cases = []
    for scene in scenes:
        here = [row for row in rows if row["case"] == scene.name]
        truth = next((row["truth"] for row in here if row.get("truth")), "no peer gave poses")
        bodies = f"{scene.bodies:,} bod{'y' if scene.bodies == 1 else 'ies'}"
        cases.append(f"### {scene.name}: {scene.title}\n\n{bodies}, {scene.steps:,} steps of "
                     f"1/{round(1 / scene.step_seconds)} s. Truth: {truth}. Others used "
                     f"{100 * here[0]['others_share']:.0f} % of the machine.\n\n{table(here)}")
    versions = "\n".join(f"| {peer} | {version} | {source} |" for peer, version, source in about["versions"])
    return report.fill(TEMPLATE, {
        **about, "versions": versions, "overview": overview(rows, scenes), "losses": report.losses(rows),
        "loaded": report.LOADED if any(row["loaded"] for row in rows) else "", "cases": "\n\n".join(cases),
        "plots": "\n\n".join(f"![{title}](benchmark-physics/{name})" for name, title in plots)})


def options_of(words):
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--physics", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--install", action="store_true", help="install the peers, compile their adapters, and end")
    parser.add_argument("--list", action="store_true", help="list peers and scenes, and end")
    parser.add_argument("--page", action="store_true", help="write docs/benchmark-physics.md")
    parser.add_argument("--scene", action="append", metavar="NAME", help="only this scene; again for more")
    parser.add_argument("--peer", action="append", metavar="NAME",
                        help="only peers whose name begins so; again for more")
    parser.add_argument("--adapter", action="append", default=[], metavar="NAME=COMMAND", help="a peer of your own")
    parser.add_argument("--seconds", type=float, default=10.0,
                        help="of runs of a peer in a scene, in all; at least one run (default 10)")
    parser.add_argument("--limit", type=float, default=300.0,
                        help="seconds after which a run counts as without end (default 300)")
    parser.add_argument("--output", type=Path, default=peers.BUILD / "physics", metavar="FOLDER")
    parser.add_argument("--binaries", type=Path, metavar="FOLDER",
                        help="programs built elsewhere; nothing is built then")
    return parser.parse_args(words)


def main(words):
    options = options_of(words)
    binaries = options.binaries.resolve() if options.binaries else peers.ROOT / "build" / "release" / "bin"
    all_peers = known(binaries)
    if options.install:
        peers.install(all_peers)
        peers.installed([peer for peer in all_peers if peer.needs != all_peers[0].needs], COMMAND)
        return 0
    peers.build(options.binaries, TARGETS)
    titles = dict(line.split("\t") for line in run_own(binaries, "list").splitlines())
    if options.list:
        print("\n".join([*(f"{peer.name:24} {peer.source}" for peer in all_peers),
                         *(f"{name:24} {title}" for name, title in titles.items())]))
        return 0
    names = options.scene or list(titles)
    if unknown := [name for name in names if name not in titles]:
        raise SystemExit(f"{COMMAND}: there is no scene {', '.join(unknown)}, only {', '.join(titles)}")
    chosen = peers.choose(all_peers + [peers.of_command(text, ("threads",)) for text in options.adapter], options.peer,
                          COMMAND)
    about = report.begin("tools/compare " + " ".join(words))
    rows, samples, scenes = [], [], []
    for name in names:
        scenes.append(prepare(name, titles[name], binaries))
        new_rows, new_samples = run_scene(scenes[-1], chosen, options.seconds, options.limit, binaries)
        rows += new_rows
        samples += new_samples
        report.write_csv(options.output, rows, samples, FIELDS, SAMPLE_FIELDS)
    report.end(about, rows, chosen)
    folder = peers.ROOT / "docs" / "benchmark-physics" if options.page else options.output
    report.write_csv(folder, rows, samples, FIELDS, SAMPLE_FIELDS)
    file = peers.ROOT / "docs" / "benchmark-physics.md" if options.page else folder / "benchmark-physics.md"
    report.write(file, page(rows, about, report.draw(folder), scenes))
    print(f"compare: {file}, {folder / 'rows.csv'}, {folder / 'samples.csv'}", flush=True)
    return 1 if any(row["peer"].startswith("Brittle") and not report.is_sound(row) for row in rows) else 0
