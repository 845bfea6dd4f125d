"""What the tests of the Python package share. tools/test-python installs the wheel and runs them."""
import os
import pathlib
import re
import subprocess

import brittle
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUNNY = pathlib.Path("/usr/share/glmark2/models/bunny.obj")


@pytest.fixture(scope="session")
def bunny() -> brittle.Mesh:
    return brittle.load(BUNNY)


@pytest.fixture(scope="session")
def command_hash(tmp_path_factory):
    """A function that breaks a mesh by the command line and returns the hash that it prints."""
    program = pathlib.Path(os.environ.get("BRITTLE_COMMAND", ROOT / "build/release/bin/brittle"))

    def run(mesh, *options: str) -> str:
        output = tmp_path_factory.mktemp("command") / "pieces.ply"
        printed = subprocess.run([program, "fracture", mesh, "-o", output, *options], check=True, capture_output=True,
                                 text=True).stdout
        return re.search(r"^ *hash +([0-9a-f]{16})", printed, re.MULTILINE)[1]

    return run


def is_closed(faces) -> bool:
    """Whether each directed edge has exactly one opposite one: counted here, not by the library."""
    edges = [(int(a), int(b)) for face in faces for a, b in ((face[0], face[1]), (face[1], face[2]), (face[2], face[0]))]
    return len(set(edges)) == len(edges) and set(edges) == {(b, a) for a, b in edges}


def volume(vertices, faces) -> float:
    """Volume inside a closed surface, by tetrahedra to the origin."""
    import numpy as np
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)
