"""The cases: meshes and sites, in the format of the adapters, with cells and the oracle's volumes.

They are kept in build/compare.
"""
import array
import hashlib
import os
import struct
import subprocess
import tarfile
from dataclasses import dataclass
from pathlib import Path

from .peers import BUILD, ROOT

SITES = ROOT / "tools" / "comparison" / "sites"
GLMARK = Path("/usr/share/glmark2/models")
CGAL_DATA = Path("/usr/share/doc/libcgal-dev/data.tar.gz")

# Name in tables: file or shape. cgal: a file of the package libcgal-demo.
MESHES = {
    "cube": "shape:cube",
    "torus": "shape:torus",
    "animal": "shape:animal",
    "sponge": "shape:menger_sponge",
    "ball_20k": "shape:icosphere:5",
    "ball_328k": "shape:icosphere:7",
    "bunny": GLMARK / "bunny.obj",
    "horse": GLMARK / "horse.3ds",
    "cat": GLMARK / "cat.3ds",
    "armadillo": "cgal:armadillo.off",
    "elephant": "cgal:refined_elephant.off",
}
RANDOM = ("random_10", "random_100", "random_1000", "random_10000")
DEGENERATE = ("cube/lattice_8", "cube/lattice_64", "cube/mirrored_35", "cube/coplanar_100", "sponge/lattice_64")
SHORT = [f"bunny/{sites}" for sites in RANDOM] + ["horse/random_100", "cat/random_100", "animal/random_100",
                                                  "armadillo/random_100", *DEGENERATE, "ball_328k/random_100"]
ALL = list(dict.fromkeys([f"{mesh}/{sites}" for mesh in MESHES for sites in RANDOM] + [*DEGENERATE]))
# For peers that only make cells.
CELLS = ["bunny/random_100", "bunny/random_1000", "bunny/random_10000", "cube/lattice_64"]


@dataclass
class Case:
    name: str
    mesh: str
    sites: str
    count: int
    triangles: int
    part: Path
    sites_file: Path
    cells: Path
    volumes: Path
    oracle: str       # how the volumes were found
    task: str = "pieces"


class Missing(Exception):
    """An input that this machine does not have."""


def mesh_source(name):
    source = MESHES[name]
    if str(source).startswith("cgal:"):
        file = BUILD / "meshes" / source[5:]
        if not file.exists():
            if not CGAL_DATA.exists():
                raise Missing("the package libcgal-demo is not installed; tools/compare --install gets it")
            file.parent.mkdir(parents=True, exist_ok=True)
            with tarfile.open(CGAL_DATA) as archive:
                file.write_bytes(archive.extractfile(f"data/meshes/{file.name}").read())
        return file
    if isinstance(source, Path) and not source.exists():
        raise Missing(f"{source} is missing; the package glmark2-data has it")
    return source


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode != 0:
        raise Missing(done.stderr.strip() or f"{words[0]} ended with exit code {done.returncode}")
    return done.stdout


def part_bounds(file):
    data = file.read_bytes()
    _, vertices, triangles = struct.unpack_from("<III", data)
    points = array.array("d")
    points.frombytes(data[12:12 + 24 * vertices])
    return [min(points[k::3]) for k in range(3)], [max(points[k::3]) for k in range(3)], triangles


def box_part(file, low, high):
    corners = [tuple((high if k >> axis & 1 else low)[axis] for axis in range(3)) for k in range(8)]
    triangles = (0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2,
                 1, 3, 7, 1, 7, 5)
    file.write_bytes(struct.pack("<III", 1, 8, 12) + b"".join(struct.pack("<ddd", *corner) for corner in corners)
                     + struct.pack("<36I", *triangles))


def prepare(name, binaries, exact_prisms, task="pieces"):
    """A case by its name MESH/SITES. With the task "cells" the solid is the bounding box of the mesh."""
    mesh, _, sites = name.partition("/")
    listed = SITES / f"{sites}.txt"
    if mesh not in MESHES or not listed.exists():
        raise SystemExit(f"tools/compare: there is no case '{name}'. Meshes: {', '.join(MESHES)}. Sites: "
                         + ", ".join(sorted(file.stem for file in SITES.glob('*.txt'))))
    folder = BUILD / "inputs"
    folder.mkdir(parents=True, exist_ok=True)
    part = folder / f"{mesh}.part"
    source = mesh_source(mesh)
    run(binaries / "compare_input", source, part)
    low, high, triangles = part_bounds(part)
    if task == "cells":
        part = folder / f"{mesh}_box.part"
        box_part(part, low, high)
        triangles = 12
    sites_file = folder / f"{mesh}_{sites}.txt"
    places = [[float(x) for x in line.split()] for line in listed.read_text(encoding="ascii").splitlines()]
    sites_file.write_text("".join(" ".join(repr(low[k] + (high[k] - low[k]) * u) for k, u in enumerate(place)) + "\n"
                                  for place in places), encoding="ascii")
    # Cells and volumes follow from these two files and from the gate alone.
    key = hashlib.sha256(part.read_bytes() + sites_file.read_bytes() + str(exact_prisms).encode()
                         + (binaries / "compare_gate").read_bytes()).hexdigest()[:16]
    cells, volumes = folder / f"{key}.cells", folder / f"{key}.volumes"
    if not cells.exists():
        run(binaries / "compare_gate", "cells", part, sites_file, new := folder / f"{os.getpid()}.new")
        new.rename(cells)
    if not volumes.exists():
        run(binaries / "compare_gate", "volumes", part, sites_file, new := folder / f"{os.getpid()}.new", exact_prisms)
        new.rename(volumes)
    lines = volumes.read_text(encoding="ascii").splitlines()
    exact = sum(line.endswith("exact") for line in lines[1:])
    oracle = "all cells exact" if exact == len(places) else (
        f"{exact} of {len(places)} cells exact, the others in double, which differs from these by at most "
        f"{float(lines[0].split()[1]):.1e} m^3")
    return Case(name, mesh, sites, len(places), triangles, part, sites_file, cells, volumes, oracle, task)
