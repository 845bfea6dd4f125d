import collections
import json
import os
import pathlib
import signal
import subprocess
import sys
import tarfile
import time

import brittle
import numpy as np
import pytest
from brittle import dataset

from conftest import is_closed, volume


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """Two sound meshes, an open one, a copy, a damaged file and a name without a file."""
    folder = tmp_path_factory.mktemp("meshes")
    brittle.shape("torus").export(folder / "a_torus.ply")
    brittle.shape("icosphere:3").export(folder / "b_ball.ply")
    cube = brittle.shape("cube")
    brittle.Mesh(cube.vertices, cube.faces[1:]).export(folder / "c_open.ply")
    (folder / "d_damaged.glb").write_bytes(b"glTF\x02\x00\x00\x00and so on")
    (folder / "e_copy.ply").write_bytes((folder / "b_ball.ply").read_bytes())
    return [*sorted(folder.iterdir()), folder / "missing.obj"]


RECIPES = [{"sites": 12, "seeds": 10}, {"sites": 20, "material": "stone", "seeds": 2}, {"sites": 3, "wrong": 1}]
ITEMS = 5 * 13  # without the copy


def tree(folder: pathlib.Path) -> dict:
    """The bytes of all files that stay."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*")
            if path.is_file() and path.name != ".lock"}


@pytest.fixture(scope="module")
def reference(meshes, tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "reference"
    summary = dataset.generate(meshes, RECIPES, folder, workers=2, shard_size=4)
    assert (summary.items, summary.new) == (ITEMS, ITEMS) and summary.items_per_core_second > 0
    return folder


def index_of(folder: pathlib.Path) -> list:
    return [json.loads(line) for line in (folder / "index.jsonl").read_text().splitlines()]


def test_index_names_each_item_once_and_what_is_wrong(reference, meshes):
    entries = index_of(reference)
    assert len(entries) == len({entry["id"] for entry in entries}) == ITEMS
    found = collections.Counter((pathlib.Path(entry["mesh"]).name, entry["status"]) for entry in entries)
    assert found == {("a_torus.ply", "ok"): 12, ("a_torus.ply", "invalid_recipe"): 1, ("b_ball.ply", "ok"): 12,
                     ("b_ball.ply", "invalid_recipe"): 1, ("c_open.ply", "not_closed"): 12,
                     ("c_open.ply", "invalid_recipe"): 1, ("d_damaged.glb", "malformed_file"): 13,
                     ("missing.obj", "file_not_found"): 13}
    assert all("wrong" in entry["error"] for entry in entries if entry["status"] == "invalid_recipe")


def rotate(quaternion, points):
    axis, real = quaternion[:3], quaternion[3]
    return points + 2 * np.cross(axis, np.cross(axis, points) + real * points)


def test_items_hold_the_fracture_and_its_labels(reference):
    count = 0
    for entry, data in dataset.read(reference):
        count += 1
        broken = brittle.fracture(brittle.load(entry["mesh"]), **entry["recipe"])
        assert broken.hash == entry["hash"]
        pieces = len(data["volumes"])
        assert pieces == entry["pieces"] == len(broken.pieces)
        for piece in range(0, pieces, 5):
            begin, end = data["vertex_ranges"][piece]
            vertices = data["vertices"][begin:end].astype(float)
            faces = data["faces"][slice(*data["face_ranges"][piece])]
            assert is_closed(faces)
            assert volume(vertices, faces) == pytest.approx(data["volumes"][piece], rel=1e-3, abs=1e-7)
            turned = rotate(data["pose_rotations"][piece], vertices - data["centers_mass"][piece])
            assert volume(turned, faces) == pytest.approx(volume(vertices, faces), rel=1e-3, abs=1e-7)
        assert np.linalg.norm(data["pose_rotations"], axis=1) == pytest.approx(1, abs=1e-5)
        assert np.array_equal(data["contacts"], broken.bonds) and data["contacts"].max() < pieces
        assert len(data["contact_areas"]) == len(data["contacts"]) == len(data["contact_normals"])
    assert count == sum(entry["status"] == "ok" for entry in index_of(reference)) == 24


def test_finished_data_set_is_not_made_again(meshes, reference):
    before = tree(reference)
    assert dataset.generate(meshes, RECIPES, reference, shard_size=4).new == 0
    assert tree(reference) == before


def command(meshes, output, *options):
    recipes = [text for recipe in RECIPES for text in ("--recipe", json.dumps(recipe))]
    return [sys.executable, "-m", "brittle.dataset", *map(str, meshes), *recipes, "-o", str(output), "--shard-size", "4",
            *options]


def test_killed_runs_continue(meshes, reference, tmp_path):
    output = tmp_path / "killed"
    for shards in (0, 1, 3, 5):  # of 17
        process = subprocess.Popen(command(meshes, output, "--workers", "2"), start_new_session=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        while len(list(output.glob("index/shard-*"))) < shards:
            assert process.poll() is None
            time.sleep(0.002)
        os.killpg(process.pid, signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL
        assert not (output / "index.jsonl").exists()
    printed = subprocess.run(command(meshes, output), check=True, capture_output=True, text=True).stdout
    assert f"{ITEMS} items in" in printed and "41 of them refused" in printed
    assert tree(output) == tree(reference)


def test_a_worker_that_dies_does_not_stop_the_others(meshes, reference, tmp_path):
    # Every process of the run that comes to this fracture dies, as if it had run out of memory.
    (tmp_path / "sitecustomize.py").write_text(
        "import os\nimport brittle._fracture as module\nwhole = module.fracture\n"
        "def fracture(mesh, sites=100, *, seed=1, **options):\n"
        "    if (sites, seed, len(mesh.vertices)) == (12, 7, 642):\n        os._exit(9)\n"
        "    return whole(mesh, sites, seed=seed, **options)\nmodule.fracture = fracture\n")
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    subprocess.run(command(meshes, tmp_path / "out", "--workers", "2"), check=True, stdout=subprocess.DEVNULL,
                   env=dict(os.environ, PYTHONPATH=path))
    expected, found = index_of(reference), index_of(tmp_path / "out")
    unlike = [(a, b) for a, b in zip(expected, found) if a != b]
    assert len(found) == len(expected) and len(unlike) == 1
    assert unlike[0][0]["recipe"] == {"sites": 12, "seed": 7} and unlike[0][1]["status"] == "process_died"


def test_other_plans_and_writers_are_refused(meshes, reference, tmp_path):
    for recipes, options in (([{"sites": 5}], {"shard_size": 4}), (RECIPES, {"shard_size": 5}),
                             (RECIPES, {"shard_size": 4, "format": "glb"})):
        with pytest.raises(dataset.DatasetError, match="choose another folder"):
            dataset.generate(meshes, recipes, reference, **options)
    for recipes in ([], [{"seeds": 0}], [{"seeds": 2, "seed": 1}], ["cube"]):
        with pytest.raises(dataset.DatasetError):
            dataset.generate(meshes, recipes, tmp_path / "none")
    with pytest.raises(dataset.DatasetError, match="no meshes"):
        dataset.generate([], RECIPES, tmp_path / "none")
    with pytest.raises(dataset.DatasetError, match="format"):
        dataset.generate(meshes, RECIPES, tmp_path / "none", format="obj")
    (tmp_path / "file").write_text("")
    with pytest.raises(dataset.DatasetError, match="cannot be written"):
        dataset.generate(meshes, RECIPES, tmp_path / "file")
    with dataset._locked(tmp_path / "busy"), pytest.raises(dataset.DatasetError, match="another process"):
        dataset.generate(meshes, RECIPES, tmp_path / "busy")
    failed = subprocess.run(command(meshes, reference, "--format", "glb"), capture_output=True, text=True)
    assert failed.returncode == 1 and "choose another folder" in failed.stderr
    with pytest.raises(dataset.DatasetError, match="not complete"):
        next(dataset.read(tmp_path))


def test_glb_items(meshes, tmp_path):
    dataset.generate(meshes[:1], [{"sites": 6, "seeds": 2}], tmp_path / "glb", workers=1, format="glb")
    with tarfile.open(tmp_path / "glb" / "shard-000000.tar") as archive:
        names = archive.getnames()
        assert len(names) == 4
        for name in names[::2]:
            mesh = brittle.load_bytes(archive.extractfile(name).read(), ".glb")
            labels = json.loads(archive.extractfile(name.replace(".glb", ".json")).read())
            assert volume(mesh.vertices, mesh.faces) == pytest.approx(labels["volume_sum"], rel=1e-5)
            assert len(labels["pose_rotations"]) == labels["pieces"] and len(labels["contacts"]) > 0


def test_dask_with_a_worker_that_is_killed(meshes, reference, tmp_path):
    pytest.importorskip("distributed")
    scheduler = subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1",
                                  "--port", "0", "--dashboard-address", "127.0.0.1:0", "--scheduler-file",
                                  tmp_path / "scheduler.json"], stderr=subprocess.DEVNULL)
    workers = []
    try:
        while not (tmp_path / "scheduler.json").exists() or not (tmp_path / "scheduler.json").read_text():
            assert scheduler.poll() is None
            time.sleep(0.05)
        address = json.loads((tmp_path / "scheduler.json").read_text())["address"]
        workers = [subprocess.Popen([sys.executable, "-m", "distributed.cli.dask_worker", address, "--nthreads", "1",
                                     "--no-nanny", "--no-dashboard", "--local-directory", tmp_path / f"worker{k}"],
                                    stderr=subprocess.DEVNULL) for k in range(3)]
        from distributed import Client
        with Client(address) as client:
            client.wait_for_workers(3, timeout=60)
        killed = []

        def kill(_summary) -> None:
            if not killed:
                workers[0].kill()
                killed.append(True)

        dataset.generate(meshes, RECIPES, tmp_path / "dask", scheduler=address, shard_size=4, progress=kill)
        assert killed and workers[0].wait() == -signal.SIGKILL
        assert tree(tmp_path / "dask") == tree(reference)
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()
