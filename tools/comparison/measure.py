"""Runs the peers of a case in turns, then checks the pieces of each."""
import json
import os
import subprocess

from . import machine
from .peers import BUILD
from .session import Failed, Session

LOADED = 0.05        # share of all cores that other processes may use before rows are marked
MAX_RUNS = 501       # of a peer in a case
GATE_SECONDS = 300


def percentile(samples, share):
    """The smallest sample that this share of them does not exceed."""
    ordered = sorted(samples)
    return ordered[max(0, -(-len(ordered) * share // 100) - 1)]


def check(session, case, binaries):
    """The verdict of the gate on the pieces of the last run."""
    file = BUILD / f"pieces_{os.getpid()}.parts"
    try:
        session.write(file)
        done = subprocess.run([binaries / "compare_gate", "check", case.part, case.sites_file, case.volumes, file],
                              capture_output=True, text=True, timeout=GATE_SECONDS)
        if done.returncode != 0:
            return {"reason": "the pieces cannot be read: " + done.stderr.strip()}
        found = json.loads(done.stdout)
        if found["pieces"] != session.pieces:
            found["reason"] = ", ".join(filter(None, [f"answers {session.pieces} pieces and writes {found['pieces']}",
                                                      found["reason"]]))
        return found
    except subprocess.TimeoutExpired:
        return {"reason": f"the gate did not end within {GATE_SECONDS} s"}
    except Failed as failed:
        return {"reason": f"gave no pieces: {failed}"}
    finally:
        file.unlink(missing_ok=True)


def new_row(case, peer, threads):
    return {"case": case.name, "task": case.task, "mesh": case.mesh, "triangles": case.triangles,
            "site_set": case.sites, "sites": case.count, "peer": peer.name, "threads": threads,
            "given_cells": peer.given_cells, "version": "",
            "failure": "", "reason": "", "loaded": False, "oracle": case.oracle}


class Expectations:
    """Which runs would exceed the limit, from smaller ones of the same mesh: times grow at least with the sites."""

    def __init__(self, limit):
        self.limit, self.seen = limit, {}

    def note(self, case, peer, threads, seconds):
        self.seen.setdefault((case.mesh, case.task, peer.name, threads), []).append((case.count, seconds))

    def refusal(self, case, peer, threads):
        if case.count > peer.max_sites:
            return peer.max_reason
        smaller = [seen for seen in self.seen.get((case.mesh, case.task, peer.name, threads), []) if seen[0] < case.count]
        if not smaller:
            return ""
        count, seconds = max(smaller)  # the nearest, since with few sites the mesh takes most of the time
        if seconds * case.count / count <= self.limit:
            return ""
        took = f"{seconds:.1f} s" if seconds < self.limit else f"more than {self.limit:.0f} s"
        return f"not run: {count} sites took {took}"


def run_case(case, peers, seconds, limit, binaries, expectations, say):
    """Rows, and samples as (case, task, peer, threads, repetition, ms). Repetition 0 is the cold one."""
    logs = BUILD / "logs"
    logs.mkdir(parents=True, exist_ok=True)
    rows, sessions = [], []
    machine.settle()
    watch, load_before = machine.Others(), machine.load()
    for peer in peers:
        for threads in peer.threads:
            row = new_row(case, peer, threads)
            rows.append(row)
            row["failure"] = expectations.refusal(case, peer, threads)
            if row["failure"]:
                continue
            try:
                log = logs / f"{case.name}-{peer.name}-{threads}.log".replace("/", "_").replace(" ", "_")
                sessions.append((row, Session(peer, threads, (case.part, case.sites_file, case.cells), limit, log)))
            except Failed as failed:
                row["failure"] = str(failed)
                expectations.note(case, peer, threads, limit if "no end" in str(failed) else 0.0)
    active = list(sessions)
    while active:
        going = []
        for row, session in active:
            try:
                session.run()
                if len(session.samples) == 1:
                    expectations.note(case, session.peer, session.threads, session.samples[0] / 1e3)
                if sum(session.samples[1:]) < 1e3 * seconds and len(session.samples) <= MAX_RUNS \
                        and session.samples[0] < 1e3 * seconds:
                    going.append((row, session))
            except Failed as failed:
                row["failure"] = str(failed)
                expectations.note(case, session.peer, session.threads, limit if "no end" in str(failed) else 0.0)
                session.kill()
        active = going
    for _, session in sessions:
        if session.process:
            watch.note(session.process.pid)
    others = watch.share()
    samples = []
    for row, session in sessions:
        row.update(version=session.version, runs=len(session.samples), pieces=session.pieces,
                   memory_mb=round(session.memory, 1), memory_ready_mb=round(session.memory_ready, 1))
        if session.samples:
            warm = session.samples[1:] or session.samples
            row.update(cold_ms=session.samples[0], min_ms=min(warm), p50_ms=percentile(warm, 50),
                       p99_ms=percentile(warm, 99), max_ms=max(warm), warm_runs=len(session.samples) - 1)
            samples += [(case.name, case.task, row["peer"], row["threads"], k, ms)
                        for k, ms in enumerate(session.samples)]
        if not row["failure"]:
            row.update(check(session, case, binaries))
        session.end()
    for row in rows:
        row.update(others_share=round(others, 3), loaded=others > LOADED, load_before=load_before)
        say(row)
    return rows, samples

