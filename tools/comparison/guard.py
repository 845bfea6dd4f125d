"""tools/compare --guard: is this tree slower than an earlier commit?

Both are built by the same compiler with the same flags, below build/compare/guard, and their probes (guard/probe.cpp)
run each case in turns, in several fresh processes each, since the place of a process in memory changes its speed. A
case with a phase whose minimum grew by the threshold is measured again, in further processes. The phase is slower where
its minimum grew by the threshold there too, and so did the median of the ratios of all turns.
"""
import argparse
import os
import shutil
import subprocess
import tarfile
import time
from io import BytesIO
from statistics import median

from . import machine
from .peers import BUILD, ROOT

FOLDER = BUILD / "guard"
THRESHOLD = 1.10
MIN_MILLISECONDS = 0.25  # of a phase; shorter ones are noise
PROCESSES = 3            # pairs of fresh processes
SLOWER = 7               # exit code, as of brittle profile --compare
PROBE = ROOT / "tools" / "comparison" / "guard"


def git(*words):
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True)
    if done.returncode != 0:
        raise SystemExit(f"tools/compare --guard: git {' '.join(words)}: {done.stderr.decode().strip()}")
    return done.stdout


def default_commit():
    """The last commit where files are changed, else the one before it."""
    changed = git("status", "--porcelain", "--untracked-files=no", "--", "fracture", "physics",
                  "CMakeLists.txt").strip()
    return "HEAD" if changed else "HEAD~1"


def copy_tree(to):
    """The files of the working tree, with their times, so that only changed ones are compiled again."""
    wanted = set()
    for name in git("ls-files", "-z", "--cached", "--others", "--exclude-standard").decode().split("\0"):
        source = ROOT / name
        if not name or not source.is_file():
            continue
        wanted.add(name)
        target = to / name
        if target.exists():
            old, new = target.stat(), source.stat()
            if (old.st_mtime_ns, old.st_size) == (new.st_mtime_ns, new.st_size):
                continue
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source, target)
    for file in [file for file in to.rglob("*") if file.is_file() and str(file.relative_to(to)) not in wanted]:
        file.unlink()


def unpack(commit, to):
    if to.exists():
        return
    with tarfile.open(fileobj=BytesIO(git("archive", commit))) as archive:
        archive.extractall(to.with_suffix(".new"), filter="data")
    to.with_suffix(".new").rename(to)


def build(name, fill):
    """The probe of a tree. Both trees lie at equal depth, so that ccache finds what they share."""
    folder = FOLDER / name
    folder.mkdir(parents=True, exist_ok=True)
    fill(folder / "source")
    probe = folder / "probe"
    probe.mkdir(exist_ok=True)
    for file in ("probe.cpp", "guard.cmake"):
        if not (probe / file).exists() or (probe / file).read_bytes() != (PROBE / file).read_bytes():
            shutil.copy2(PROBE / file, probe / file)
    environment = {**os.environ, "CCACHE_BASEDIR": str(folder), "CCACHE_NOHASHDIR": "1"}
    configure = ["cmake", "-S", folder / "source", "-B", folder / "build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                 "-DBUILD_TESTING=OFF", "-DBRITTLE_LIBRARY_ONLY=ON",
                 f"-DCMAKE_PROJECT_brittle_INCLUDE={probe / 'guard.cmake'}",
                 f"-DGUARD_PROBE={probe / 'probe.cpp'}"]
    for words in (configure, ["cmake", "--build", folder / "build", "--target", "brittle_guard"]):
        done = subprocess.run([str(word) for word in words], env=environment, capture_output=True, text=True)
        if done.returncode != 0:
            lines = [line for line in (done.stdout + done.stderr).splitlines() if "error" in line.lower()]
            raise SystemExit(f"tools/compare --guard: {name} does not build: "
                             + "\n".join((lines or done.stderr.splitlines())[:5]) + "\nName a later commit, or see "
                             f"whether tools/comparison/guard/probe.cpp uses functions that it lacks.")
    return folder / "build" / "brittle_guard"


class Probe:
    def __init__(self, program):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def run(self, case):
        self.process.stdin.write(case + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline().strip()
        if not line or line.startswith("failed"):
            raise SystemExit(f"tools/compare --guard: case {case}: {line or 'the probe ended'}")
        phases = {}
        for phase, milliseconds in (pair.rsplit("=", 1) for pair in line.replace("find places", "find_places").split()):
            phases[phase] = phases.get(phase, 0.0) + float(milliseconds)
        return phases

    def end(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def measure(programs, cases, seconds):
    """Samples of (case, phase), one list for each program, by turn. A case gets an equal share of the time."""
    samples = {}
    for pair in range(PROCESSES):
        probes = [Probe(program) for program in programs]
        for case in cases:
            end, turn = time.monotonic() + seconds / len(cases) / PROCESSES, pair
            for probe in probes:
                probe.run(case)  # fills workspaces
            while time.monotonic() < end or turn < pair + 3:
                for which in ((0, 1) if turn % 2 == 0 else (1, 0)):
                    for phase, milliseconds in probes[which].run(case).items():
                        samples.setdefault((case, phase), ([], []))[which].append(milliseconds)
                turn += 1
        for probe in probes:
            probe.end()
    return samples


def ratios(before, now):
    """The median of the ratios of turns, in which a change of the machine's speed meets both; and that of minima."""
    return median(b / max(a, 1e-9) for a, b in zip(before, now)), min(now) / max(min(before), 1e-9)


def long_enough(before, now):
    return bool(before) and bool(now) and median(before) >= MIN_MILLISECONDS


def suspects(samples, threshold):
    return [key for key, pair in samples.items() if long_enough(*pair) and ratios(*pair)[1] > threshold]


def joined(samples, again):
    return {key: tuple(first + second for first, second in zip(pair, again.get(key, ([], []))))
            for key, pair in samples.items()}


def confirmed(suspected, samples, again, threshold):
    """Noise that lasts hides a slower median, but not a slower minimum; chance does not make a minimum slower twice."""
    together = joined(samples, again)
    return [key for key in suspected if key in again and ratios(*again[key])[1] > threshold
            and ratios(*together[key])[0] > threshold]


def main(words):
    parser = argparse.ArgumentParser(prog="tools/compare --guard", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--guard", "--guard-full", nargs="?", const="", metavar="COMMIT", dest="commit",
                        help="the commit to compare with (default: the last one where fracture/ or physics/ is "
                             "changed, else the one before it)")
    parser.add_argument("--guard-seconds", type=float, help="time for measuring (default 100; 420 with --guard-full)")
    parser.add_argument("--guard-case", action="append", metavar="CASE",
                        help="only this case of the probe; again for more")
    parser.add_argument("--guard-threshold", type=float, default=THRESHOLD, metavar="RATIO")
    options = parser.parse_args(words)
    seconds = options.guard_seconds or (420.0 if "--guard-full" in words else 100.0)
    commit = git("rev-parse", "--verify", (options.commit or default_commit()) + "^{commit}").decode().strip()
    print(f"guard: {git('log', '-1', '--format=%h %s', commit).decode().strip()}, and this tree", flush=True)
    programs = [build(commit[:12], lambda to: unpack(commit, to)), build("now", copy_tree)]
    cases = subprocess.run([programs[1], "--list"], capture_output=True, text=True, check=True).stdout.split()
    if options.guard_case:
        if unknown := set(options.guard_case) - set(cases):
            raise SystemExit(f"tools/compare --guard: there is no case {', '.join(sorted(unknown))}, only "
                             + ", ".join(cases))
        cases = options.guard_case
    busy, own, begin = machine.busy_seconds(), sum(os.times()[:4]), time.monotonic()
    samples = measure(programs, cases, seconds)
    suspected = suspects(samples, options.guard_threshold)
    again = measure(programs, sorted({case for case, _ in suspected}), seconds) if suspected else {}
    found = confirmed(suspected, samples, again, options.guard_threshold)
    used = sum(os.times()[:4]) - own
    others = max(0.0, machine.busy_seconds() - busy - used) / ((time.monotonic() - begin) * (os.cpu_count() or 1))
    print(f"{'case':9} {'phase':12} {'before ms':>10} {'now ms':>10} {'median':>8} {'minimum':>8}")
    for key, (before, now) in sorted(joined(samples, again).items(),
                                     key=lambda item: (cases.index(item[0][0]), item[0][1] != "total", item[0][1])):
        if not long_enough(before, now):
            continue
        of_median, of_minimum = ratios(before, now)
        faster = max(of_median, of_minimum) < 1 / options.guard_threshold
        note = "SLOWER" if key in found else "faster" if faster else ""
        if key in suspected and not note:
            note = "not confirmed"
        print(f"{key[0]:9} {key[1]:12} {median(before):10.3f} {median(now):10.3f} {of_median:8.3f} "
              f"{of_minimum:8.3f} {note}")
    for case, phase in sorted(key for key, (before, now) in samples.items() if bool(before) != bool(now)):
        print(f"guard: {case}: only one of the two has a phase {phase}; look at total")
    if others > 0.05:
        print(f"guard: other processes used {100 * others:.0f} % of the machine; small differences are not to be "
              "relied on")
    print("guard: " + ("slower: " + ", ".join(f"{case} {phase}" for case, phase in found) if found else
                       f"no phase is slower by {100 * (options.guard_threshold - 1):.0f} %"), flush=True)
    return SLOWER if found else 0
