"""An adapter for tools/compare that only knows cubes with sites in the middle of their octants, written from
docs/benchmark.md alone. Its first argument names the fault that it has: the gate must find it.

    tools/compare --adapter 'octants=python3 tests/tools/comparison/octants.py sound' --case cube/lattice_8
"""
import array
import os
import sys
import time

FACES = (0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5)


def read_part(name):
    with open(name, "rb") as file:
        counts = array.array("I")
        counts.fromfile(file, 3)
        points = array.array("d")
        points.fromfile(file, 3 * counts[1])
    return points


def box(low, high):
    return [x for k in range(8) for x in ((high if k >> axis & 1 else low)[axis] for axis in range(3))], list(FACES)


def broken(fault, low, high, sites):
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    parts = [box([low[k] if site[k] < middle[k] else middle[k] for k in range(3)],
                 [middle[k] if site[k] < middle[k] else high[k] for k in range(3)]) for site in sites]
    if fault == "open":
        del parts[1][1][-3:]
    elif fault == "inside-out":
        parts[2] = parts[2][0], parts[2][1][::-1]
    elif fault == "missing":
        parts.pop()
    elif fault == "shifted":
        parts[3] = [x + 1e-3 for x in parts[3][0]], parts[3][1]
    elif fault == "islands":
        last = parts.pop()  # touches the first in a vertex
        parts[0] = parts[0][0] + last[0], parts[0][1] + [v + 8 for v in last[1]]
    elif fault == "crossing":
        parts[6][0][0:3] = [0.5 * low[0], 0.5 * high[1], 2.0 * high[2]]
    return parts


def main():
    fault, mesh, sites, _, _ = sys.argv[1:]
    points = read_part(mesh)
    low, high = [[pick(points[k::3]) for k in range(3)] for pick in (min, max)]
    places = [[float(x) for x in line.split()] for line in open(sites, encoding="ascii")]
    print("something of no interest", flush=True)
    print("ready octants 1", flush=True)
    parts = []
    for line in sys.stdin:
        if line == "run\n":
            if fault == "hanging":
                time.sleep(600)
            elif fault == "crashing":
                os.abort()
            elif fault == "refusing":
                print("failed a cube is too plain", flush=True)
                continue
            elif fault == "babbling":
                print("done soon", flush=True)
                continue
            begin = time.perf_counter()
            parts = broken(fault, low, high, places)
            count = len(parts) + (fault == "miscounting")
            print(f"done {1e3 * (time.perf_counter() - begin)} {count}", flush=True)
        elif line.startswith("write "):
            with open(line[6:-1], "wb") as out:
                array.array("I", [len(parts)]).tofile(out)
                for vertices, corners in parts:
                    array.array("I", [len(vertices) // 3, len(corners) // 3]).tofile(out)
                    array.array("d", vertices).tofile(out)
                    array.array("I", corners).tofile(out)
                if fault == "truncated":
                    out.truncate(out.tell() - 5)
            print("written", flush=True)


main()
