"""Fractures real models of Debian's packages into GLB files for tools/check-blender, and prints the files.
    models.py PROGRAM FOLDER [--short]
--short: the models that are in the repository or in packages which the build installs.

Each file of pieces must use every material of its model; tests/blender/check.py looks at the rest in Blender. Exit 1
if a model cannot be fractured or loses a material.
"""
import json
import re
import struct
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
ZOO = ROOT / "build" / "zoo"
GLMARK2 = "usr/share/glmark2/models"
CGAL = "usr/share/doc/libcgal-dev/data/meshes"
ASSIMP = "usr/share/assimp/models"
PACKAGES = ["glmark2-data", "libcgal-demo", "assimp-testmodels"]

# Package or None for a path in the repository, path, number of sites, options. The first ones are the short form.
MODELS = [
    (None, "tests/corpus/meshes/crate.glb", 25, []),
    ("glmark2-data", f"{GLMARK2}/horse.3ds", 40, ["--repair"]),
    ("glmark2-data", f"{GLMARK2}/asteroid-high.3ds", 40, ["--roughness", "1"]),
    ("glmark2-data", f"{GLMARK2}/bunny.obj", 60, []),
]
SHORT = len(MODELS)
MODELS += [
    ("glmark2-data", f"{GLMARK2}/cat.3ds", 40, ["--repair"]),
    ("libcgal-demo", f"{CGAL}/armadillo.off", 100, []),
    ("libcgal-demo", f"{CGAL}/camel.off", 60, ["--material", "wood"]),
    ("libcgal-demo", f"{CGAL}/cheese.off", 100, []),
    ("libcgal-demo", f"{CGAL}/ChineseDragon-10kv.off", 60, ["--repair"]),
    ("libcgal-demo", f"{CGAL}/cow.off", 40, ["--cells-per-piece", "8"]),
    ("libcgal-demo", f"{CGAL}/dino.off", 40, ["--material", "stone"]),
    ("libcgal-demo", f"{CGAL}/elephant.off", 60, ["--hulls", "unreal"]),
    ("libcgal-demo", f"{CGAL}/fandisk.off", 40, ["--pattern", "grid"]),
    ("libcgal-demo", f"{CGAL}/knot1.off", 60, ["--hulls", "godot"]),
    ("libcgal-demo", f"{CGAL}/man.off", 60, ["--rigid-bodies"]),
    ("libcgal-demo", f"{CGAL}/turbine.off", 60, ["--pattern", "radial"]),
    ("assimp-testmodels", f"{ASSIMP}/OBJ/spider.obj", 40, ["--repair"]),
    ("assimp-testmodels", f"{ASSIMP}/OBJ/WusonOBJ.obj", 40, ["--repair"]),
    ("assimp-testmodels", f"{ASSIMP}/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", 40, ["--repair"]),
    ("assimp-testmodels", f"{ASSIMP}/glTF2/BoxTextured-glTF-Binary/BoxTextured.glb", 20, []),
    ("assimp-testmodels", f"{ASSIMP}/glTF2/glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf", 20, []),
]


def source_of(package, path):
    if package is None:
        return ROOT / path
    installed = Path("/") / path
    return installed if installed.exists() else ZOO / package / path


def document_of(file):
    """The JSON of a .gltf or .glb file."""
    data = file.read_bytes()
    if data[:4] == b"glTF":
        data = data[20:20 + struct.unpack_from("<I", data, 12)[0]]
    return json.loads(data)


def used_materials(document):
    names = set()
    for mesh in document["meshes"]:
        for primitive in mesh["primitives"]:
            if "material" in primitive:
                names.add(document["materials"][primitive["material"]].get("name", ""))
    return names


def materials_of(source):
    """The names of the materials that faces of the model use."""
    if source.suffix in (".gltf", ".glb"):
        return used_materials(document_of(source)) - {""}
    if source.suffix == ".obj" and source.with_suffix(".mtl").exists():
        text = source.read_text(errors="replace")
        return set(re.findall(r"^usemtl +(.+?)\s*$", text, re.M))
    return set()


def main(program, folder, short):
    models = MODELS[:SHORT] if short else MODELS
    if not short:
        subprocess.run([ROOT / "tools" / "zoo", "--fetch", *PACKAGES], check=True)
    folder.mkdir(parents=True, exist_ok=True)
    bad = 0
    for package, path, sites, options in models:
        source = source_of(package, path)
        target = folder / f"{source.stem}.glb"
        done = subprocess.run([program, "fracture", source, "-n", str(sites), "-o", target, *options],
                              capture_output=True, text=True)
        if done.returncode != 0:
            print(f"models: {source}: {done.stderr.strip() or done.stdout.strip()}", file=sys.stderr)
            bad = 1
            continue
        lost = materials_of(source) - used_materials(document_of(target))
        if lost:
            print(f"models: {source}: the pieces have lost the materials {', '.join(sorted(lost))}", file=sys.stderr)
            bad = 1
        print(target)
    return bad


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2]), "--short" in sys.argv[3:]))
