"""The peers: where they come from, and how their adapters are built and called."""
import os
import shlex
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
ADAPTERS = ROOT / "tools" / "comparison" / "adapters"
BUILD = ROOT / "build" / "compare"
CORES = os.cpu_count() or 1


@dataclass
class Peer:
    name: str                    # in tables
    command: list                # its first words; those of the case follow
    words: list = field(default_factory=list)     # after those of the case
    task: str = "pieces"         # or "cells": only the cells in the box of the mesh
    given_cells: bool = False    # its time does not hold the computation of cells
    threads: tuple = (1,)        # the counts to run it with
    folder: Path = ROOT          # it runs there
    source: str = ""             # where it comes from
    packages: tuple = ()         # Debian packages that its adapter needs
    version: str = ""            # of the first of them that the adapter was written for
    make: list = field(default_factory=list)      # compiles the adapter
    needs: Path = None           # a file without which it is not installed
    max_sites: int = 1 << 30     # more of them are not asked for, with the reason:
    max_reason: str = ""


def compiled(name, *libraries, flags=(), words=(), **more):
    """A peer in C++ from one file."""
    program = BUILD / "bin" / name
    source = ADAPTERS / f"{name}.cpp"
    make = ["g++", "-std=c++20", "-O3", "-DNDEBUG", *flags, f"-I{ROOT}", source, "-o", program, *libraries]
    return {"command": [program], "words": list(words), "make": make, "needs": program, **more}


def known(binaries, manifold=None):
    """All peers, installed or not."""
    both = tuple(sorted({1, CORES}))
    node = BUILD / "node"
    cgal = compiled("cgal", "-lmpfr", "-lgmp", "-pthread",
                    flags=("-frounding-math", "-DCGAL_USE_GMP=1", "-DCGAL_USE_MPFR=1"),
                    given_cells=True, threads=both, source="Debian",
                    packages=("libcgal-dev", "libgmp-dev", "libmpfr-dev"),
                    version="5.5.1-2")
    peers = [
        Peer("Brittle", [binaries / "compare_brittle"], threads=both, source="this commit",
             needs=binaries / "compare_brittle"),
        Peer("Brittle, cells", [binaries / "compare_brittle"], ["cells"], task="cells", threads=both,
             source="this commit", needs=binaries / "compare_brittle"),
        Peer("Manifold (npm)", ["node", "manifold.mjs"], given_cells=True, folder=node, source="npm",
             packages=("nodejs",), needs=node / "node_modules" / "manifold-3d"),
        Peer("CGAL corefinement", **{**cgal, "words": ["corefine"]}),
        Peer("CGAL clip", **{**cgal, "words": ["clip"]}),
        Peer("three-bvh-csg", ["node", "three.mjs"], ["csg"], given_cells=True, folder=node, source="npm",
             packages=("nodejs",), needs=node / "node_modules" / "three-bvh-csg"),
        Peer("three-pinata", ["node", "three.mjs"], ["pinata"], folder=node, source="npm", packages=("nodejs",),
             needs=node / "node_modules" / "@dgreenheck"),
        Peer("Blender Cell Fracture", ["blender", "--background", "--factory-startup", "--threads", str(CORES),
                                       "--python",
                                       ADAPTERS / "blender.py", "--"], threads=(CORES,), source="Debian",
             packages=("blender",), version="3.4.1+dfsg-2+b1",
             needs=Path(shutil.which("blender") or "/usr/bin/blender")),
        Peer("VTK", ["/usr/bin/python3", ADAPTERS / "vtk_clip.py"], given_cells=True, source="Debian",
             packages=("python3-vtk9",), version="9.1.0+really9.1.0+dfsg2-5+deb12u1",
             needs=Path("/usr/lib/python3/dist-packages/vtk.py")),
        Peer("OpenVDB fracturer", **compiled("openvdb", "-lopenvdb", "-ltbb", given_cells=True, threads=(CORES,),
                                             source="Debian",
                                             packages=("libopenvdb-dev",), version="10.0.1-2")),
        Peer("voro++, cells", **compiled("voro", "-lvoro++", task="cells", source="Debian", packages=("voro++-dev",),
                                         version="0.5+revert-to-0.4.6+dfsg1-1")),
    ]
    if manifold:
        folder = Path(manifold).resolve()
        library = next((lib for lib in (folder / "lib", folder / "lib64", folder / "src", folder)
                        if any(lib.glob("libmanifold.*"))),
                       folder / "lib")
        peers.insert(3, Peer("Manifold (native)", **compiled(
            "manifold", f"-L{library}", f"-Wl,-rpath,{library}", "-lmanifold", "-ltbb",
            flags=(f"-I{folder / 'include'}",), given_cells=True, threads=both, source=str(folder),
            packages=("libtbb-dev",))))
    return peers


def of_command(text, known_options=("cells", "given", "threads"), cores=CORES):
    """A peer that the command line names: NAME=COMMAND, with options between brackets: NAME[cells,threads]=..."""
    name, found, command = text.partition("=")
    if not found or not name.strip() or not command.strip():
        raise SystemExit(f"tools/compare: --adapter wants NAME=COMMAND, not '{text}'")
    name, _, options = name.strip().partition("[")
    options = {word.strip() for word in options.rstrip("]").split(",") if word.strip()}
    if unknown := sorted(options - set(known_options)):
        raise SystemExit(f"tools/compare: --adapter {name} has the options {', '.join(known_options)}, not "
                         + ", ".join(unknown))
    return Peer(name, shlex.split(command), task="cells" if "cells" in options else "pieces",
                given_cells="given" in options,
                threads=tuple(sorted({1, cores})) if "threads" in options else (1,), folder=Path.cwd(),
                source="--adapter")


def choose(all_peers, names, command="tools/compare"):
    """Those that can run, of the ones whose name begins with one of `names`, or of all."""
    taken = [peer.name for peer in all_peers]
    if twice := next((name for name in taken if taken.count(name) > 1), None):
        raise SystemExit(f"{command}: two peers have the name {twice}; give --adapter another one")
    if names:
        all_peers = [peer for peer in all_peers if any(peer.name.lower().startswith(name.lower()) for name in names)]
        if not all_peers:
            raise SystemExit(f"{command}: no peer begins with {' or '.join(names)}; {command} --list has the names")
    chosen = installed(all_peers, command)
    if not chosen:
        raise SystemExit(f"{command}: no peer can run; {command} --install gets them")
    for peer in chosen:
        if peer.version and (found := package_version(peer.packages[0])) != peer.version:
            print(f"compare: {peer.packages[0]} is {found or 'not installed'}; the adapter was written for "
                  f"{peer.version}", flush=True)
    return chosen


def build(binaries, targets):
    """The folder of our programs: the given one, else they are built."""
    if binaries:
        return binaries.resolve()
    if not (ROOT / "build" / "release" / "build.ninja").exists():
        subprocess.run(["cmake", "--preset", "release"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "--preset", "release", "--target", *targets], cwd=ROOT, check=True,
                   stdout=subprocess.DEVNULL)
    return ROOT / "build" / "release" / "bin"


def package_version(package):
    done = subprocess.run(["dpkg-query", "-W", "-f", "${db:Status-Status} ${Version}", package], capture_output=True,
                          text=True)
    status, _, version = done.stdout.partition(" ")
    return version if status == "installed" else ""


def install(peers):
    """Installs the peers' packages, compiles their adapters, and says what cannot be had."""
    packages = sorted({package for peer in peers for package in peer.packages})
    missing = [package for package in packages if not package_version(package)]
    if missing:
        subprocess.run([ROOT / "tools" / "setup", "--compare"], check=True)
    node = BUILD / "node"
    if any(peer.source == "npm" for peer in peers):
        node.mkdir(parents=True, exist_ok=True)
        lock = ADAPTERS / "node" / "package-lock.json"
        if not (node / "node_modules").exists() or (node / lock.name).read_bytes() != lock.read_bytes():
            for name in ("package.json", lock.name):
                shutil.copy(ADAPTERS / "node" / name, node)
            subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"], cwd=node,
                           check=True,
                           stdout=subprocess.DEVNULL)
        for script in (ADAPTERS / "node").glob("*.mjs"):
            shutil.copy(script, node)
    (BUILD / "bin").mkdir(parents=True, exist_ok=True)
    done = set()
    for peer in peers:
        if not peer.make or peer.needs in done:
            continue
        done.add(peer.needs)
        sources = [Path(word) for word in peer.make if str(word).endswith(".cpp")] + [*ADAPTERS.glob("*.h")]
        if not peer.needs.exists() or any(source.stat().st_mtime > peer.needs.stat().st_mtime for source in sources):
            print(f"compare: compiling the adapter of {peer.name}", flush=True)
            made = subprocess.run([str(word) for word in peer.make], capture_output=True, text=True)
            if made.returncode != 0:
                first = next((line for line in made.stderr.splitlines() if "error" in line), made.stderr[:200])
                print(f"compare: the adapter of {peer.name} does not compile: {first}", flush=True)


def installed(peers, command="tools/compare"):
    """Those that can run; prints a line for each of the others."""
    ready = []
    for peer in peers:
        if peer.needs is not None and not peer.needs.exists():
            print(f"compare: {peer.name} is not installed and is left out; {command} --install gets it", flush=True)
            continue
        ready.append(peer)
    return ready
