"""An adapter for tools/compare --physics that only knows stacks, which stand, balls that bounce, and boxes that rest on
a slope, written from docs/benchmark-physics.md alone. Its first argument names the fault that it has: the judge must
find it.

    tools/compare --physics --adapter 'forms=python3 tests/tools/comparison/closed_forms.py sound' --scene bounce_50
"""
import array
import math
import os
import struct
import sys
import time


def read_scene(name):
    """Steps, steps a record, seconds of a step, and bodies as (fixed, pose, corners, restitution)."""
    with open(name, "rb") as file:
        data = file.read()
    assert data[:8] == b"scene 1\n"
    steps, steps_a_record, _, count = struct.unpack_from("<4I", data, 8)
    gravity, step = struct.unpack_from("<4d", data, 24)[1], struct.unpack_from("<4d", data, 24)[3]
    at, bodies = 72, []
    for _ in range(count):
        fixed, corners = struct.unpack_from("<2I", data, at)
        numbers = struct.unpack_from("<19d", data, at + 8)
        points = struct.unpack_from(f"<{3 * corners}d", data, at + 160)
        at += 160 + 24 * corners
        bodies.append((fixed != 0, numbers[4:11], points, numbers[18]))
    assert at == len(data)
    return steps, steps_a_record, step, -gravity, bodies


def height(seconds, fall, gravity, restitution):
    """Of a ball above the height at which it touches."""
    speed = math.sqrt(2.0 * gravity * fall)
    seconds -= speed / gravity
    if seconds < 0.0:
        return fall - 0.5 * gravity * (seconds + speed / gravity) ** 2
    while seconds > (flight := 2.0 * restitution * speed / gravity) > 1e-3:
        seconds, speed = seconds - flight, restitution * speed
    return max(0.0, restitution * speed * seconds - 0.5 * gravity * seconds * seconds)


def pose(fault, seconds, which, scene):
    _, _, _, gravity, bodies = scene
    fixed, start, corners, restitution = bodies[which]
    x, y, z, *turn = start
    if len(bodies) == 1 and fault != "still":
        fall = y + min(corners[1::3])
        bounce = {"lively": 1.3, "dull": restitution - 0.05}.get(fault, restitution)
        y += height(seconds, fall, gravity, bounce) - fall
    if fault == "exploding":
        x, y = x + (which + 1) * seconds, y + 3.0 * which * seconds * seconds
    elif fault == "sinking":
        y -= 2.0 * seconds
    elif fault == "overlapping":
        y -= 0.3 * which * min(1.0, seconds)
    elif fault == "drifting":
        x += 0.006 * seconds / 30.0 * (which == len(bodies) - 1)
    elif fault == "nowhere" and seconds > 1.0 and which == 0:
        y = math.nan
    elif fault == "elsewhere":
        z += 0.01
    elif fault == "turned":
        turn = [turn[3], turn[0], turn[1], turn[2]]  # w, x, y, z
    elif fault == "stretched":
        turn = [2.0 * value for value in turn]
    elif fault == "unfixing" and fixed:
        y -= 0.1 * seconds
    return x, y, z, *turn


def write_poses(fault, name, scene):
    steps, steps_a_record, step, _, bodies = scene
    records = steps // steps_a_record + 1 - (fault == "short")
    with open(name, "wb") as out:
        counts = (0xffffffff, 0xffffffff) if fault == "boasting" else (len(bodies), records)
        out.write((b"parts 1\n" if fault == "mistaken" else b"poses 1\n") + struct.pack("<2I", *counts))
        array.array("d", [value for record in range(records) for which in range(len(bodies))
                          for value in pose(fault, record * steps_a_record * step, which, scene)]).tofile(out)
        if fault == "truncated":
            out.truncate(out.tell() - 5)


def main():
    fault, scene, _ = sys.argv[1:]
    scene = read_scene(scene)
    print("something of no interest", flush=True)
    print("ready forms 1", flush=True)
    for line in sys.stdin:
        if line == "run\n":
            if fault == "hanging":
                time.sleep(600)
            elif fault == "crashing":
                os.abort()
            elif fault == "refusing":
                print("failed a box is too plain", flush=True)
            elif fault == "babbling":
                print("done soon", flush=True)
            elif fault == "timeless":
                print("done nan nan nan", flush=True)
            else:
                print("done 0.25 0.5 1", flush=True)
        elif line.startswith("write "):
            if fault != "silent":
                write_poses(fault, line[6:-1], scene)
            print("written", flush=True)


main()
