import types

import brittle
import numpy as np
import pytest

from conftest import BUNNY, volume

TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.float16, np.int64, ">f8"])
@pytest.mark.parametrize("index", [np.uint16, np.uint32, np.int32, np.int64, np.uint8])
def test_dtypes(kind, index):
    mesh = brittle.Mesh(TETRAHEDRON[0].astype(kind), TETRAHEDRON[1].astype(index))
    assert np.array_equal(mesh.vertices, TETRAHEDRON[0]) and np.array_equal(mesh.faces, TETRAHEDRON[1])
    assert brittle.fracture(mesh, 3).certificate.closed


def test_strides_and_lists():
    wide = np.zeros((4, 8))
    wide[:, 2:5] = TETRAHEDRON[0]
    for vertices in (wide[:, 2:5], np.asfortranarray(TETRAHEDRON[0]), TETRAHEDRON[0].tolist(), wide[::-1][::-1, 2:5]):
        assert np.array_equal(brittle.Mesh(vertices, TETRAHEDRON[1].tolist()).vertices, TETRAHEDRON[0])


@pytest.mark.parametrize("vertices, faces, error, words", [
    (np.zeros((4, 2)), TETRAHEDRON[1], ValueError, r"vertices has the shape \(4, 2\)"),
    (np.zeros(12), TETRAHEDRON[1], ValueError, "vertices has the shape"),
    (TETRAHEDRON[0], np.zeros((4, 4), int), ValueError, "faces has the shape"),
    (TETRAHEDRON[0], TETRAHEDRON[1].astype(float), TypeError, "faces has the dtype float64"),
    (TETRAHEDRON[0].astype(complex), TETRAHEDRON[1], TypeError, "vertices has the dtype complex128"),
    (TETRAHEDRON[0].astype(str), TETRAHEDRON[1], TypeError, "vertices has the dtype"),
    (TETRAHEDRON[0], -TETRAHEDRON[1], ValueError, "faces has numbers from -3"),
    (TETRAHEDRON[0], TETRAHEDRON[1] + (1 << 40), ValueError, "faces has numbers"),
    (TETRAHEDRON[0], TETRAHEDRON[1] + 1, brittle.BrittleError, "4"),
    (np.full((4, 3), np.nan), TETRAHEDRON[1], brittle.BrittleError, "finite"),
    (TETRAHEDRON[0], np.zeros((0, 3), int), brittle.BrittleError, "no faces"),
])
def test_arrays_that_are_no_mesh(vertices, faces, error, words):
    with pytest.raises(error, match=words):
        brittle.Mesh(vertices, faces)


def test_soup_of_triangles_is_welded():
    soup = TETRAHEDRON[0][TETRAHEDRON[1]].reshape(-1, 3)
    assert brittle.Mesh(soup).inspect().open_edges == 12
    welded = brittle.Mesh(soup, weld=True)
    assert len(welded.vertices) == 4 and welded.inspect().is_watertight


def test_attributes_of_arrays():
    vertices, faces = TETRAHEDRON
    normals = vertices / np.maximum(np.linalg.norm(vertices, axis=1), 1)[:, None] + np.array([0, 0, 1.0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    uv = np.linspace(0, 1, 8).reshape(4, 2)
    mesh = brittle.Mesh(vertices, faces, normals=normals, uv=uv, materials=[0, 3, 3, 7])
    assert mesh.normals.shape == (4, 3, 3) and mesh.normals == pytest.approx(normals[faces], abs=1e-6)
    assert mesh.uv == pytest.approx(uv[faces], abs=1e-6)
    assert mesh.materials.tolist() == [0, 3, 3, 7]
    assert mesh.uv2.shape == (0, 3, 2) and mesh.colours.shape == (0, 3, 4)
    assert not any(array.flags.writeable for array in (mesh.normals, mesh.uv, mesh.materials))
    uv_of_mesh = mesh.uv
    del mesh  # the view keeps it
    assert uv_of_mesh == pytest.approx(uv[faces], abs=1e-6)
    plain = brittle.Mesh(vertices, faces)
    assert [len(a) for a in (plain.normals, plain.uv, plain.uv2, plain.colours, plain.materials)] == [0] * 5


def test_attributes_of_a_file():
    lines = ["ply", "format ascii 1.0", "element vertex 4", *(f"property float {axis}" for axis in "xyz"),
             *(f"property uchar {colour}" for colour in ("red", "green", "blue")), "element face 4",
             "property list uchar int vertex_indices", "end_header"]
    colours = np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]])
    lines += [" ".join(map(str, [*corner, *colour])) for corner, colour in zip(TETRAHEDRON[0], colours)]
    lines += ["3 " + " ".join(map(str, face)) for face in TETRAHEDRON[1]]
    mesh = brittle.load_bytes("\n".join(lines).encode() + b"\n", ".ply")
    assert mesh.colours.shape == (4, 3, 4)
    by_corner = {tuple(mesh.vertices[vertex]): mesh.colours[face, corner, :3].tolist()
                 for face in range(4) for corner, vertex in enumerate(mesh.faces[face])}
    for position, colour in zip(TETRAHEDRON[0], colours / 255):
        assert by_corner[tuple(position)] == pytest.approx(colour.tolist())


def test_anything_with_vertices_and_faces_is_a_mesh():
    like_trimesh = types.SimpleNamespace(vertices=TETRAHEDRON[0], faces=TETRAHEDRON[1])
    assert brittle.fracture(like_trimesh, 4).volumes.sum() == pytest.approx(1 / 6)


def test_open_mesh_is_refused_and_repaired():
    mesh = brittle.Mesh(TETRAHEDRON[0], TETRAHEDRON[1][1:])
    found = mesh.inspect()
    assert (found.refusal, found.open_edges, found.holes, found.is_watertight) == ("not_closed", 3, 1, False)
    for sites in (3, TETRAHEDRON[0]):
        with pytest.raises(brittle.BrittleError, match="3 open edges.*; repair the mesh first") as failure:
            brittle.fracture(mesh, sites)
        assert failure.value.status == "not_closed"
    repaired = mesh.repair()
    assert volume(repaired.vertices, repaired.faces) == pytest.approx(1 / 6)
    assert repaired.inspect().refusal is None and "closed" in repaired.inspect().report


def test_parts_that_cross_are_united():
    cube = brittle.box((1, 1, 1))
    other = cube.vertices + 0.5
    crossing = brittle.Mesh(np.concatenate([cube.vertices, other]), np.concatenate([cube.faces, cube.faces + 8]))
    united = crossing.unite()
    assert volume(united.vertices, united.faces) == pytest.approx(2 - 0.125)


def test_files(tmp_path, bunny):
    assert brittle.load(str(BUNNY)).faces.shape == brittle.load_bytes(BUNNY.read_bytes(), ".obj").faces.shape
    folder = tmp_path / "Größe 🐇"
    folder.mkdir()
    bunny.export(folder / "bunny.ply")
    assert np.allclose(brittle.load(folder / "bunny.ply").vertices, bunny.vertices, atol=1e-6)
    with pytest.raises(FileNotFoundError, match="missing.obj"):
        brittle.load(tmp_path / "missing.obj")
    (tmp_path / "bad.ply").write_bytes(b"ply\nformat nothing\n")
    with pytest.raises(brittle.BrittleError) as failure:
        brittle.load(tmp_path / "bad.ply")
    assert failure.value.status == "malformed_file" and "bad.ply" in str(failure.value)


def test_help_reads_well():
    for thing in (getattr(brittle, name) for name in brittle.__all__ if name != "MATERIALS"):
        assert thing.__doc__ and not thing.__doc__.startswith(thing.__name__ + "("), thing
