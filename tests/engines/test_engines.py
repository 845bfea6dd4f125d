"""Brittle's files in other programs: bodies in Godot, Rapier and Blender; meshes in Blender and three.js; the Khronos
validator; tangents by MikkTSpace.

tools/test-engines runs it; BRITTLE is the program, BRITTLE_ENGINES a folder with the npm packages of package.json.
"""
import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import pytest
import textured

HERE = Path(__file__).parent
BRITTLE = os.environ["BRITTLE"]
ENGINES = Path(os.environ["BRITTLE_ENGINES"])
CALM = 0.2  # m/s at birth
# Of solids, thin shells, and cells with several islands. Those of torus_knot and tower overlap with one hull a piece.
SHAPES = {"cube": 20, "hollow_sphere": 20, "menger_sponge": 50, "vase": 30, "torus_knot": 4, "tower": 10}
FALLING = {"wall": 30, "statue": 20}


CRATE = HERE.parent / "corpus" / "meshes" / "crate.glb"


def fracture(shape: str, sites: int, file: Path, *options: str) -> Path:
    return fracture_mesh(f"shape:{shape}", sites, file, *options)


def fracture_mesh(mesh, sites: int, file: Path, *options: str) -> Path:
    subprocess.run([BRITTLE, "fracture", mesh, "-n", str(sites), "-o", file, *options], check=True,
                   stdout=subprocess.DEVNULL)
    return file


def numbers(text: str) -> dict[str, dict[str, float]]:
    """By file: the numbers of its line, NAME.ENDING WORD NUMBER WORD NUMBER ..."""
    found = {}
    for line in text.splitlines():
        if match := re.match(r"(\S+)\.(?:glb|obj|ply|stl) ((?:\w+ [-+.e\d]+ ?)+)$", line):
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
BLENDER_CLOSED = [*BLENDER[:-2], str(HERE / "closed.py"), "--"]


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


def node(program: str, files: list) -> str:
    shutil.copy(HERE / program, ENGINES)  # beside the packages
    run = subprocess.run(["node", ENGINES / program, *files], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


def test_files_pass_the_khronos_validator(tmp_path):
    ball = tmp_path / "ball.glb"
    textured.write(ball)
    texture = HERE.parent / "corpus" / "meshes" / "crate planks.png"
    files = [fracture(shape, sites, tmp_path / f"{shape}.glb") for shape, sites in SHAPES.items()]
    files += [fracture("vase", 20, tmp_path / f"vase_{name}.glb", *options) for name, options in {
        "godot": ["--hulls", "godot"], "unreal": ["--hulls", "unreal"], "bodies": ["--rigid-bodies"],
        "rough": ["--roughness", "1", "--detail", "3"], "image": ["--interior-texture", texture]}.items()]
    files += [fracture_mesh(CRATE, 20, tmp_path / "crate.glb"), fracture_mesh(ball, 20, tmp_path / "bumpy.glb"),
              fracture_mesh(ball, 20, tmp_path / "bumpy_rough.glb", "--roughness", "1", "--rigid-bodies")]
    text = node("validate.mjs", files)
    found = numbers(text)
    assert set(found) == {file.stem for file in files}, text
    assert all(of["errors"] == of["warnings"] == 0 for of in found.values()), text


def test_the_validator_finds_faults(tmp_path):
    file = fracture("cube", 3, tmp_path / "cube.glb")
    file.write_bytes(file.read_bytes().replace(b'"NORMAL"', b'"NOMRAL"'))
    assert numbers(node("validate.mjs", [file]))["cube"]["errors"] > 0


def test_tangents_are_those_of_mikktspace(tmp_path):
    ball = tmp_path / "ball.glb"
    textured.write(ball)
    whole = fracture_mesh(ball, 1, tmp_path / "whole.glb")
    pieces = fracture_mesh(ball, 30, tmp_path / "pieces.glb")
    text = node("tangents.mjs", [whole, pieces])
    found = numbers(text)
    assert found["whole"]["primitives"] == 1 and found["whole"]["vertices"] == 3 * 2 * 32 * 23, text
    assert found["whole"]["turned"] < 0.1 and found["whole"]["flipped"] == 0, text
    # Pieces keep the tangents of the whole ball, also at their borders, where those of a piece alone turn away.
    assert found["pieces"]["primitives"] >= 20 and found["pieces"]["flipped"] == 0, text
    assert found["pieces"]["turned"] < 10, text


def test_blender_gets_closed_pieces_of_every_format(tmp_path):
    fracture("cube", 20, tmp_path / "obj.obj")
    fracture("cube", 20, tmp_path / "ply.ply")
    fracture_mesh(CRATE.with_suffix(".obj"), 20, tmp_path / "textured.ply")
    fracture("cube", 20, tmp_path / "stl.stl")
    fracture("cube", 20, tmp_path / "joined.stl", "--one-file")
    pieces = sorted(tmp_path.glob("stl_*.stl"))
    assert len(pieces) == 20 and not (tmp_path / "stl.stl").exists()
    whole = [tmp_path / name for name in ("obj.obj", "ply.ply", "textured.ply", "joined.stl")]
    run = subprocess.run([*BLENDER_CLOSED, *whole, *pieces], capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stdout + run.stderr
    found = numbers(run.stdout)
    assert found["obj"]["objects"] == 20 and found["ply"]["objects"] == 1
    cube = found["ply"]["volume"]
    # The importer of STL welds by position: the faces of neighbours are one. So a piece has a file of its own.
    joined = found.pop("joined")
    assert joined["open"] > 0 and joined["faces"] < found["ply"]["faces"], joined
    for name, of in found.items():
        assert of["open"] == 0 and of["volume"] > 0, (name, of)
    assert found["obj"]["volume"] == pytest.approx(cube, rel=1e-5)
    assert sum(found[piece.stem]["volume"] for piece in pieces) == pytest.approx(cube, rel=1e-5)
    assert sum(found[piece.stem]["faces"] for piece in pieces) == found["ply"]["faces"]


def test_three_gets_the_pieces(tmp_path):
    files = [fracture("vase", 20, tmp_path / "vase.glb"), fracture("cube", 20, tmp_path / "cube.glb"),
             fracture("vase", 20, tmp_path / "unreal.glb", "--hulls", "unreal")]
    text = node("three.mjs", files)
    found = numbers(text)
    assert set(found) == {"vase", "cube", "unreal"}, text
    for of in found.values():
        assert of["pieces"] >= 20 and of["wrong"] == of["normals"] == 0, text
    assert found["unreal"]["volume"] == pytest.approx(found["vase"]["volume"], rel=1e-6)
