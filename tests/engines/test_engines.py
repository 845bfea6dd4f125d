"""Bodies that other engines make of Brittle's files: Godot, Rapier and Blender.

tools/test-engines runs it; BRITTLE is the program, BRITTLE_ENGINES a folder with the npm packages of package.json.
"""
import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import pytest

HERE = Path(__file__).parent
BRITTLE = os.environ["BRITTLE"]
ENGINES = Path(os.environ["BRITTLE_ENGINES"])
CALM = 0.2  # m/s at birth
# Of solids, thin shells, and cells with several islands. Those of torus_knot and tower overlap with one hull a piece.
SHAPES = {"cube": 20, "hollow_sphere": 20, "menger_sponge": 50, "vase": 30, "torus_knot": 4, "tower": 10}
FALLING = {"wall": 30, "statue": 20}


def fracture(shape: str, sites: int, file: Path, *options: str) -> Path:
    subprocess.run([BRITTLE, "fracture", f"shape:{shape}", "-n", str(sites), "-o", file, *options], check=True,
                   stdout=subprocess.DEVNULL)
    return file


def numbers(text: str) -> dict[str, dict[str, float]]:
    """By file: the numbers of its line, NAME.glb WORD NUMBER WORD NUMBER ..."""
    found = {}
    for line in text.splitlines():
        if match := re.match(r"(\S+)\.glb ((?:\w+ [-+.e\d]+ ?)+)$", line):
            words = match[2].split()
            found[Path(match[1]).name] = dict(zip(words[::2], map(float, words[1::2])))
    return found


def births(command: list, tmp_path: Path, options: list[str]) -> dict[str, dict[str, float]]:
    files = [fracture(shape, sites, tmp_path / f"{shape}.glb", *options) for shape, sites in SHAPES.items()]
    run = subprocess.run([*command, *files], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stdout + run.stderr
    found = numbers(run.stdout)
    assert set(found) == set(SHAPES)
    return found


RAPIER = ["node", str(ENGINES / "birth.mjs")]
BLENDER = ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
           str(HERE / "birth.py"), "--"]


@pytest.mark.parametrize("command, options", [(RAPIER, ["--rigid-bodies"]), (BLENDER, ["--hulls", "unreal"])],
                         ids=["rapier", "blender"])
def test_pieces_lie_still_at_birth(command, options, tmp_path):
    for shape, of in births(command, tmp_path, options).items():
        assert of["bodies"] >= SHAPES[shape] and of["speed"] < CALM, (shape, of)


def test_one_hull_a_piece_pushes_islands_apart(tmp_path):
    found = births(RAPIER, tmp_path, ["--rigid-bodies", "--hull-parts", "1"])
    assert found["torus_knot"]["speed"] > CALM and found["tower"]["speed"] > CALM
    assert all(of["hulls"] == of["bodies"] for of in found.values())


def test_godot_makes_rigid_bodies_that_fall_and_rest(tmp_path):
    project = Path(shutil.copytree(HERE / "godot", tmp_path / "godot"))
    for shape, sites in FALLING.items():
        fracture(shape, sites, project / f"{shape}.glb", "--hulls", "godot")
    log = (tmp_path / "import.log").open("w")
    # The editor imports the files and stays open.
    with subprocess.Popen(["godot3-server", "--path", project, "--editor"], stdout=log, stderr=log) as editor:
        try:
            for _ in range(600):
                if len(list(project.glob(".import/*.md5"))) == len(FALLING) or editor.poll() is not None:
                    break
                time.sleep(0.2)
        finally:
            editor.kill()
    run = subprocess.run(["godot3-server", "--path", project, "-s", "fall.gd", "--fixed-fps", "60"],
                         capture_output=True, text=True, timeout=120)
    found = numbers(run.stdout)
    assert set(found) == set(FALLING), run.stdout + run.stderr
    for shape, of in found.items():
        assert of["bodies"] == of["fell"] >= FALLING[shape], (shape, of)
        assert of["speed"] < 0.1 and of["below"] == 0, (shape, of)
