import base64
import json
import re
import struct
import zlib

import brittle
import numpy as np
import pytest

from conftest import BUNNY, is_closed, volume


@pytest.mark.parametrize("options, arguments", [
    ({}, []),
    ({"roughness": 0.3}, ["--roughness", "0.3"]),
    ({"pattern": "radial", "focus": (0.2, 0.5, 0.9)}, ["--pattern", "radial", "--focus", "0.2,0.5,0.9"]),
    ({"pattern": "grid", "inside": True}, ["--pattern", "grid", "--inside"]),
    *(({"material": name}, ["--material", name]) for name in brittle.MATERIALS),
    ({"material": "stone", "roughness": 0.2, "detail": 1},
     ["--material", "stone", "--roughness", "0.2", "--detail", "1"]),
])
def test_hash_is_that_of_the_command_line(bunny, command_hash, options, arguments):
    broken = brittle.fracture(bunny, sites=100, seed=3, **options)
    assert broken.hash == command_hash(BUNNY, "-n", "100", "--seed", "3", *arguments)


def test_pieces_do_not_depend_on_the_number_of_threads(bunny):
    assert len({brittle.fracture(bunny, 60, threads=threads).hash for threads in (1, 2, 7)}) == 1


def test_pieces_are_closed_and_fill_the_mesh():
    torus = brittle.shape("torus")
    broken = brittle.fracture(torus, 30, seed=4)
    assert len(broken.pieces) >= 30
    total = 0.0
    for piece in broken.pieces:
        assert is_closed(piece.faces)
        assert volume(piece.vertices, piece.faces) == pytest.approx(piece.volume, rel=1e-9)
        assert np.all(piece.vertices.min(axis=0) <= piece.center_mass)
        assert np.all(piece.center_mass <= piece.vertices.max(axis=0))
        assert np.all(np.linalg.eigvalsh(piece.moment_inertia) > 0)
        total += piece.volume
    assert total == pytest.approx(volume(torus.vertices, torus.faces), rel=1e-12)
    certificate = broken.certificate
    assert certificate.closed and certificate.open_pieces == 0 and certificate.pieces == len(broken.pieces)


def test_two_sites_cut_a_cube_in_halves():
    broken = brittle.fracture(brittle.box((1, 1, 1)), [[-0.25, 0, 0], [0.25, 0, 0]])
    assert broken.volumes == pytest.approx([0.5, 0.5])
    assert broken.bonds.tolist() == [[0, 1]]
    assert broken.bond_areas == pytest.approx([1.0])
    assert broken.bond_normals[0] == pytest.approx([1, 0, 0])
    assert broken.bond_centroids[0] == pytest.approx([0, 0, 0])
    left = broken.pieces[0]
    assert left.site == 0 and left.vertices[:, 0].max() == 0
    cut = left.face_sources[left.exterior_faces:]
    assert cut.tolist() == [1] * len(cut)  # the site on the other side


def test_weights_move_the_cut_and_groups_join_cells():
    cube = brittle.box((1, 1, 1))
    sites = [[-0.25, 0, 0], [0.25, 0, 0]]
    heavier = brittle.fracture(cube, brittle.Sites(sites, weights=[0.1, 0.0]))
    assert heavier.volumes == pytest.approx([0.6, 0.4])  # the plane |x - a|^2 - 0.1 = |x - b|^2
    joined = brittle.fracture(cube, brittle.Sites(sites, groups=[3, 3]))
    assert joined.volumes == pytest.approx([1.0])


def test_arrays_are_read_only_views_that_keep_their_owner():
    piece = brittle.fracture(brittle.shape("cube"), 8).pieces[2]
    vertices, copy = piece.vertices, piece.vertices.copy()
    with pytest.raises(ValueError):
        vertices[0, 0] = 1.0
    assert not vertices.flags.owndata
    del piece
    for _ in range(50):  # memory that was freed would be used again
        brittle.fracture(brittle.shape("cube"), 8, seed=9)
    assert np.array_equal(vertices, copy)


def test_sequence_of_pieces():
    broken = brittle.fracture(brittle.shape("cube"), 5)
    assert len(list(broken.pieces)) == len(broken.pieces) == 5
    assert broken.pieces[-1].index == 4 and [p.index for p in broken.pieces[1:3]] == [1, 2]
    with pytest.raises(IndexError, match="there is no piece 5"):
        broken.pieces[5]


def test_render_buffers_and_hulls():
    broken = brittle.fracture(brittle.shape("icosphere:3"), 12)
    for piece, hulls in zip(broken.pieces, broken.hulls()):
        outside = sum(len(part.faces) for part in piece.surface() if not part.interior)
        assert outside == piece.exterior_faces
        for part in piece.surface():
            assert np.linalg.norm(part.normals, axis=1) == pytest.approx(1, abs=1e-5)
            assert part.faces.max() < len(part.positions) == len(part.vertices)
            placed = piece.vertices[part.vertices] - piece.center_mass
            assert np.array_equal(placed.astype(np.float32), part.positions)
        reach = np.linalg.norm(piece.vertices - piece.center_mass, axis=1).max()
        assert len(hulls) == 1 and np.linalg.norm(hulls[0], axis=1).max() <= reach * (1 + 1e-5)


def test_export(tmp_path):
    broken = brittle.fracture(brittle.shape("cube"), 7)
    broken.export(tmp_path / "pieces.glb", name="cube")
    data = (tmp_path / "pieces.glb").read_bytes()
    assert data == broken.to_bytes("pieces.glb", name="cube")["pieces.glb"]
    length = struct.unpack_from("<I", data, 12)[0]
    document = json.loads(data[20:20 + length])
    assert len(document["meshes"]) == 7
    back = brittle.load(tmp_path / "pieces.glb")
    assert volume(back.vertices, back.faces) == pytest.approx(8.0, rel=1e-5)
    with pytest.raises(brittle.BrittleError, match="xyz") as failure:
        broken.export(tmp_path / "pieces.xyz")
    assert failure.value.status == "unsupported_format"


def test_settings_that_cannot_be_used():
    cube = brittle.shape("cube")
    for call in (lambda: brittle.fracture(cube, -1), lambda: brittle.fracture(cube, threads=-3),
                 lambda: brittle.fracture(cube, roughness=2.0), lambda: brittle.fracture(cube, pattern="swirl"),
                 lambda: brittle.fracture(cube, [[0, 0, float("nan")]]),
                 lambda: brittle.fracture(cube, [[0, 0]]), lambda: brittle.fracture(cube, grain=(1, 2))):
        with pytest.raises((ValueError, brittle.BrittleError)):
            call()
    with pytest.raises(TypeError, match="focus"):
        brittle.fracture(cube, [[0, 0, 0]], focus=(0, 0, 0))
    with pytest.raises(TypeError, match="no mesh"):
        brittle.fracture("cube.obj")


def decode(page: str) -> np.ndarray:
    """The picture in HTML as (height, width, 4), read here from the PNG format."""
    data = base64.b64decode(re.search(r"base64,([^\"]+)", page)[1])
    width, height = struct.unpack_from(">II", data, 16)
    packed = b"".join(re.findall(rb"(?s)IDAT(.*?).{4}\x00\x00\x00\x00IEND", data))
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 4 * width)
    return rows[:, 1:].reshape(height, width, 4)


def test_pictures_for_notebooks(bunny):
    whole, broken = decode(bunny._repr_html_()), decode(brittle.fracture(bunny, 20)._repr_html_())
    for image in (whole, broken):
        covered = image[..., 3] == 255
        assert 0.15 < covered.mean() < 0.6  # an animal in the middle of an empty picture
        assert not covered[0].any() and not covered[:, 0].any()
    grey, colours = whole[whole[..., 3] == 255][:, :3], broken[broken[..., 3] == 255][:, :3]
    assert np.ptp(grey.astype(int), axis=1).max() < 30 < np.ptp(colours.astype(int), axis=1).max()
    assert ">8 pieces, " in brittle.fracture(brittle.shape("cube"), 8)._repr_html_()
