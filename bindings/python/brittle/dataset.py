"""Data sets of fractures: many meshes, each broken in many ways, in shards.

    python3 -m brittle.dataset meshes/*.obj --recipe '{"sites": 30, "material": "stone", "seeds": 100}' -o fractures

Shards are tar files, as WebDataset reads them. An item has two members: ID.npz (or ID.glb) and ID.json, its labels.
index.jsonl has a line for each item. ID is a hash of the mesh file, the recipe and the version of Brittle.

A run that ends at any moment, killed or not, continues where it stopped when it is started again: nothing is lost or
written twice, and the bytes are those of a run that was never stopped. A mesh that cannot be read or broken has a line in
the index with the reason, and does not stop the others.

Arrays of ID.npz, of p pieces, v vertices, f faces and b pairs of pieces that touch:

    vertices (v, 3) float32        of all pieces, in the assembled object; m
    faces (f, 3) uint32            of all pieces, from 0 at the first vertex of the piece; those of the outside first
    face_sources (f,) uint32       outside: the face of the mesh; on a cut: the site on the other side
    vertex_ranges, face_ranges     (p, 2) uint32: those of each piece, first and end
    exterior_faces, sites (p,)     uint32: number of faces on the outside; site in whose cell the piece lies
    volumes (p,), centers_mass (p, 3), moments_inertia (p, 3, 3)  float64
    contacts (b, 2) uint32, contact_areas (b,), contact_centroids, contact_normals (b, 3) float64
    pose_rotations (p, 4), pose_translations (p, 3)  float32: a random pose for each piece. The quaternion (x, y, z, w)
                                   turns the piece about its centre of mass, which then moves by the translation.
"""
from __future__ import annotations

import argparse
import contextlib
import dataclasses
import fcntl
import glob
import hashlib
import io
import json
import multiprocessing
import os
import pathlib
import sys
import tarfile
import time
import uuid
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Callable, Iterable, Iterator, Optional, Union

import numpy as np

from . import _library as lib
from ._fracture import Fracture, fracture
from ._mesh import Mesh, load

__all__ = ["DatasetError", "Item", "Summary", "generate", "plan", "read"]

FORMATS = ("npz", "glb")
_ATTEMPTS = 3  #: of a shard whose worker died, before its items are tried one by one


class DatasetError(Exception):
    """A data set that cannot be made or read: what is wrong, and what to do."""


@dataclasses.dataclass(frozen=True)
class Item:
    """One fracture to come: `recipe` holds the arguments of brittle.fracture()."""

    id: str
    mesh: str  #: path
    recipe: dict[str, Any]


@dataclasses.dataclass
class Summary:
    """What generate() did."""

    items: int = 0  #: of the whole data set
    refused: int = 0  #: of these, that could not be read or broken
    new: int = 0  #: made by this call
    core_seconds: float = 0.0  #: that the new items took

    @property
    def items_per_core_second(self) -> float:
        return self.new / self.core_seconds if self.core_seconds > 0 else 0.0


def plan(meshes: Iterable[Union[str, os.PathLike[str]]], recipes: Iterable[dict[str, Any]]) -> list[Item]:
    """All items: each mesh by each recipe, without repetitions. The key "seeds" of a recipe, a number n, stands for the
    seeds 0 to n - 1."""
    expanded: list[dict[str, Any]] = []
    for recipe in recipes:
        if not isinstance(recipe, dict):
            raise DatasetError(f"a recipe is {json.dumps(recipe)}; it must be an object of arguments of fracture()")
        rest = {key: value for key, value in recipe.items() if key != "seeds"}
        if "seeds" not in recipe:
            expanded.append(rest)
        elif "seed" in recipe or not isinstance(recipe["seeds"], int) or recipe["seeds"] < 1:
            raise DatasetError(f"the recipe {json.dumps(recipe)} needs a number above 0 for seeds, and no seed")
        else:
            expanded += [{**rest, "seed": seed} for seed in range(recipe["seeds"])]
    if not expanded:
        raise DatasetError("there are no recipes")
    items: dict[str, Item] = {}
    for mesh in meshes:
        try:
            content = pathlib.Path(mesh).read_bytes()
        except OSError:  # named in the index, as other meshes that cannot be read
            content = b"missing " + os.fsencode(mesh)
        key = hashlib.sha256(content).hexdigest()
        for recipe in expanded:
            text = json.dumps([key, recipe, lib.version()], sort_keys=True)
            identity = hashlib.sha256(text.encode()).hexdigest()[:24]
            items.setdefault(identity, Item(identity, os.fspath(mesh), recipe))
    if not items:
        raise DatasetError("there are no meshes")
    return list(items.values())


def _random_poses(identity: str, broken: Fracture) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(int(identity, 16))
    quaternions = random.normal(size=(len(broken.pieces), 4))
    quaternions /= np.linalg.norm(quaternions, axis=1, keepdims=True)
    centres = broken.centers_mass
    reach = float(np.linalg.norm(np.ptp(centres, axis=0))) if len(centres) else 0.0
    return quaternions.astype(np.float32), (random.uniform(-1, 1, centres.shape) * reach).astype(np.float32)


def _arrays(identity: str, broken: Fracture) -> dict[str, np.ndarray]:
    return {
        "vertices": broken._array(1).astype(np.float32), "faces": broken._array(2), "face_sources": broken._array(3),
        "vertex_ranges": broken._array(4), "face_ranges": broken._array(5), "exterior_faces": broken._array(6),
        "sites": broken._array(7), "volumes": broken.volumes, "centers_mass": broken.centers_mass,
        "moments_inertia": broken._array(11).reshape(-1, 3, 3), **_labels(identity, broken),
    }


def _labels(identity: str, broken: Fracture) -> dict[str, np.ndarray]:
    rotations, translations = _random_poses(identity, broken)
    return {"contacts": broken.bonds, "contact_areas": broken.bond_areas, "contact_centroids": broken.bond_centroids,
            "contact_normals": broken.bond_normals, "pose_rotations": rotations, "pose_translations": translations}


def _members(item: Item, broken: Fracture, form: str, entry: dict[str, Any]) -> dict[str, bytes]:
    """The files of an item. The labels of a GLB file are in the JSON beside it."""
    if form == "npz":
        buffer = io.BytesIO()
        np.savez(buffer, **_arrays(item.id, broken))
        data = buffer.getvalue()
    else:
        data = broken.to_bytes(f"{item.id}.glb")[f"{item.id}.glb"]
        entry = {**entry, **{name: array.tolist() for name, array in _labels(item.id, broken).items()}}
    return {f"{item.id}.{form}": data, f"{item.id}.json": json.dumps(entry, sort_keys=True).encode()}


def _add(archive: tarfile.TarFile, name: str, data: bytes) -> None:
    member = tarfile.TarInfo(name)  # of 1970 and of nobody, so that equal runs give equal bytes
    member.size = len(data)
    archive.addfile(member, io.BytesIO(data))


@contextlib.contextmanager
def _replaced(path: pathlib.Path) -> Iterator[Any]:
    """A file that gets its name once it is complete and on the disk."""
    part = path.with_name(f".part-{uuid.uuid4().hex}-{path.name}")
    try:
        with open(part, "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _paths(folder: pathlib.Path, shard: int) -> tuple[pathlib.Path, pathlib.Path]:
    """The shard and its part of the index. The shard is complete once the second exists."""
    return folder / f"shard-{shard:06}.tar", folder / "index" / f"shard-{shard:06}.jsonl"


def _write_shard(folder: pathlib.Path, shard: int, items: list[Item], form: str,
                 deadly: frozenset[str] = frozenset()) -> tuple[int, float]:
    """Breaks the items of a shard and writes it. Returns the number of new items, and the seconds that they took.
    deadly: items that killed their process, and are only named."""
    data_path, index_path = _paths(folder, shard)
    if index_path.exists():
        return 0, 0.0
    begin = time.perf_counter()
    lines: list[str] = []
    mesh: Union[Mesh, lib.BrittleError, None] = None
    path = None
    with _replaced(data_path) as file, tarfile.open(fileobj=file, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for item in items:
            entry: dict[str, Any] = {"id": item.id, "mesh": item.mesh, "recipe": item.recipe}
            try:
                if item.id in deadly:
                    raise lib.BrittleError("process_died", "the process that broke this mesh died")
                if item.mesh != path:
                    path, mesh = item.mesh, None
                    try:
                        mesh = load(item.mesh)
                    except lib.BrittleError as refusal:
                        mesh = refusal
                if not isinstance(mesh, Mesh):
                    assert mesh is not None
                    raise mesh
                broken = fracture(mesh, threads=1, **item.recipe)
                certificate = dataclasses.asdict(broken.certificate)
                certificate["hash"] = broken.hash
                entry.update(status="ok", shard=data_path.name, **certificate)
                for name, data in _members(item, broken, form, entry).items():
                    _add(archive, name, data)
            except lib.BrittleError as refusal:
                entry.update(status=refusal.status, error=str(refusal))
            except (TypeError, ValueError) as refusal:
                entry.update(status="invalid_recipe", error=str(refusal))
            lines.append(json.dumps(entry, sort_keys=True) + "\n")
    with _replaced(index_path) as file:
        file.write("".join(lines).encode())
    return len(items), time.perf_counter() - begin


def _clean(folder: pathlib.Path) -> None:
    """Removes what killed processes left."""
    for part in (*folder.glob(".part-*"), *(folder / "index").glob(".part-*")):
        part.unlink(missing_ok=True)


def _begin(folder: pathlib.Path, items: list[Item], form: str, shard_size: int) -> None:
    """Makes the folder, or checks that it holds this data set."""
    (folder / "index").mkdir(parents=True, exist_ok=True)
    description = {"brittle": lib.version(), "format": form, "shard_size": shard_size, "items": len(items),
                   "plan": hashlib.sha256("".join(item.id for item in items).encode()).hexdigest()}
    path = folder / "dataset.json"
    if path.exists():
        found = json.loads(path.read_text())
        if found != description:
            unlike = [key for key in description if found.get(key) != description[key]]
            raise DatasetError(f"{folder} holds a data set of other {', '.join(unlike)}; give the meshes, recipes and "
                               f"options of that one to continue it, or choose another folder")
    _clean(folder)
    if not path.exists():
        with _replaced(path) as file:
            file.write(json.dumps(description, indent=2).encode())


@contextlib.contextmanager
def _locked(folder: pathlib.Path) -> Iterator[None]:
    with _disk(folder):
        folder.mkdir(parents=True, exist_ok=True)
        lock = open(folder / ".lock", "wb")
    with lock as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise DatasetError(f"another process is writing {folder}; wait for it, or choose another folder") from None
        yield


@contextlib.contextmanager
def _disk(folder: pathlib.Path) -> Iterator[None]:
    try:
        yield
    except OSError as fault:
        raise DatasetError(f"{folder} cannot be written: {fault}; what is complete stays, and the same call continues "
                           "it") from fault


Work = tuple[pathlib.Path, int, list[Item], str]


def _run_pool(work: list[Work], workers: int, done: Callable[[int, float], None]) -> None:
    """Writes shards by a pool of processes. Shards whose process died are tried again, at last item by item."""
    context = multiprocessing.get_context("spawn")
    attempts = [0] * len(work)
    left = list(range(len(work)))
    while left:
        # After a death it is not known whose it was: each shard that was tried gets a process of its own.
        alone = [k for k in left if attempts[k] > 0]
        batch, width = (alone[:1], 1) if alone else (left, workers)
        with ProcessPoolExecutor(width, mp_context=context) as pool:
            queue, running = iter(batch), {}

            def start() -> None:
                for k in queue:
                    attempts[k] += 1
                    running[pool.submit(_write_shard, *work[k])] = k
                    return

            for _ in range(2 * width):
                start()
            try:
                while running:
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        k = running.pop(future)
                        done(*future.result())
                        left.remove(k)
                        attempts[k] = 0
                        start()
            except BrokenProcessPool:
                pass
        for k in [k for k in left if attempts[k] >= _ATTEMPTS]:
            folder, shard, items, form = work[k]
            done(*_write_shard(folder, shard, items, form, _find_deadly(items, form)))
            left.remove(k)


def _try_item(item: Item, form: str) -> None:
    with contextlib.suppress(lib.BrittleError, TypeError, ValueError):
        _members(item, fracture(load(item.mesh), threads=1, **item.recipe), form, {})


def _find_deadly(items: list[Item], form: str) -> frozenset[str]:
    """The items that kill the process that breaks them."""
    context = multiprocessing.get_context("spawn")
    found = set()
    for item in items:
        process = context.Process(target=_try_item, args=(item, form))
        process.start()
        process.join()
        if process.exitcode != 0:
            found.add(item.id)
    return frozenset(found)


def _run_dask(work: list[Work], scheduler: str, done: Callable[[int, float], None]) -> None:
    """Writes shards by the workers of a Dask scheduler, which all see the folder under the same path."""
    from distributed import Client, as_completed  # Debian: python3-distributed

    with Client(scheduler) as client:
        # Dask itself starts the shards of a worker that died on another one.
        futures = [client.submit(_write_shard, *arguments, pure=False, retries=_ATTEMPTS) for arguments in work]
        for future in as_completed(futures):
            done(*future.result())
            future.release()


def generate(meshes: Iterable[Union[str, os.PathLike[str]]], recipes: Iterable[dict[str, Any]],
             output: Union[str, os.PathLike[str]], *, workers: Optional[int] = None, scheduler: Optional[str] = None,
             format: str = "npz", shard_size: int = 64, progress: Optional[Callable[[Summary], None]] = None) -> Summary:
    """Makes a data set, or continues one. See the head of this module.

    workers: processes of this machine, by default one per core. scheduler: address of a Dask scheduler, whose workers
    are used instead; they must have Brittle, and see meshes and output under the same paths. shard_size: items a shard.
    progress: called after each shard. Raises DatasetError.
    """
    if format not in FORMATS:
        raise DatasetError(f"the format is {format!r}; it must be one of {', '.join(FORMATS)}")
    if shard_size < 1:
        raise DatasetError(f"the shard size is {shard_size}; it must be above 0")
    items = plan([os.path.abspath(mesh) for mesh in meshes], recipes)
    folder = pathlib.Path(output).absolute()
    summary = Summary(items=len(items))

    def done(new: int, seconds: float) -> None:
        summary.new += new
        summary.core_seconds += seconds
        if progress is not None:
            progress(summary)

    with _locked(folder), _disk(folder):
        _begin(folder, items, format, shard_size)
        shards = [items[k:k + shard_size] for k in range(0, len(items), shard_size)]
        work = [(folder, k, shard, format) for k, shard in enumerate(shards) if not _paths(folder, k)[1].exists()]
        if scheduler is not None:
            _run_dask(work, scheduler, done)
        else:
            _run_pool(work, workers or os.cpu_count() or 1, done)
        with _replaced(folder / "index.jsonl") as file:
            for k in range(len(shards)):
                for line in _paths(folder, k)[1].read_bytes().splitlines(keepends=True):
                    summary.refused += json.loads(line)["status"] != "ok"
                    file.write(line)
        _clean(folder)
    return summary


def read(folder: Union[str, os.PathLike[str]]) -> Iterator[tuple[dict[str, Any], dict[str, np.ndarray]]]:
    """Yields the labels and arrays of each item of a data set in npz, in the order of the index."""
    base = pathlib.Path(folder)
    if not (base / "index.jsonl").exists():
        raise DatasetError(f"{base} has no index.jsonl: the data set is not complete, or this is another folder")
    for path in sorted(base.glob("shard-*.tar")):
        with tarfile.open(path) as archive:
            data: dict[str, np.ndarray] = {}
            for member in archive:
                file = archive.extractfile(member)
                assert file is not None
                if member.name.endswith(".npz"):
                    with np.load(io.BytesIO(file.read())) as arrays:
                        data = dict(arrays)
                elif member.name.endswith(".json"):
                    yield json.loads(file.read()), data


def _recipes(texts: list[str]) -> list[dict[str, Any]]:
    """Recipes of the command line: JSON, or the name of a file with a list of recipes."""
    recipes: list[dict[str, Any]] = []
    for text in texts:
        try:
            found = json.loads(text if text.lstrip().startswith(("{", "[")) else pathlib.Path(text).read_text())
        except OSError as fault:
            raise DatasetError(f"the recipe {text!r} is neither JSON nor a file that can be read: {fault}") from None
        except json.JSONDecodeError as fault:
            raise DatasetError(f"the recipe {text!r} is no JSON: {fault}") from None
        recipes += found if isinstance(found, list) else [found]
    return recipes


def main(arguments: Optional[list[str]] = None) -> int:
    """The command python3 -m brittle.dataset."""
    parser = argparse.ArgumentParser(prog="python3 -m brittle.dataset", description="Break many meshes in many ways.")
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="a mesh file, or a pattern in quotes: 'meshes/*.obj'")
    parser.add_argument("--recipe", action="append", required=True, metavar="JSON", help="arguments of fracture(), for "
                        "example '{\"sites\": 30, \"seeds\": 100}', or a file with a list of such recipes; repeatable")
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="the data set")
    parser.add_argument("--workers", type=int, help="processes; by default one per core")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of Dask, for example tcp://head:8786")
    parser.add_argument("--format", choices=FORMATS, default="npz")
    parser.add_argument("--shard-size", type=int, default=64, metavar="N", help="items a shard; 64 by default")
    parser.add_argument("--price", type=float, metavar="P", help="of a core for an hour, to tell the cost of a million")
    options = parser.parse_args(arguments)

    def progress(summary: Summary) -> None:
        print(f"\r{summary.new} new items of {summary.items}, {summary.items_per_core_second:.1f} a second and core",
              end="", file=sys.stderr, flush=True)

    try:
        meshes = [path for text in options.meshes for path in (sorted(glob.glob(text)) or [text])]
        summary = generate(meshes, _recipes(options.recipe), options.output, workers=options.workers,
                           scheduler=options.scheduler, format=options.format, shard_size=options.shard_size,
                           progress=progress if sys.stderr.isatty() else None)
    except DatasetError as fault:
        print(f"brittle.dataset: {fault}", file=sys.stderr)
        return 1
    print(f"{summary.items} items in {options.output}, {summary.refused} of them refused (see status in index.jsonl)")
    if summary.new:
        hours = 1e6 / summary.items_per_core_second / 3600
        cost = "" if options.price is None else f", at a cost of {options.price * hours:.2f}"
        print(f"{summary.new} new, {summary.items_per_core_second:.1f} a second and core; a million would take "
              f"{hours:.1f} hours of a core{cost}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
