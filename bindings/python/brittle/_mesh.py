"""Meshes: the input of a fracture."""
from __future__ import annotations

import math
from ctypes import byref, c_double, sizeof
from dataclasses import dataclass
from typing import Any, Optional

import numpy as np

from . import _library as lib
from . import _picture


@dataclass(frozen=True)
class Inspection:
    """The flaws of a mesh. Lengths in metres."""

    refusal: Optional[str]  #: the status that fracture() would raise; None where it accepts the mesh
    report: str  #: for people
    bounds: np.ndarray  #: (2, 3): the corners of the box
    area: float
    volume: float  #: meaningless where the mesh is open
    vertices: int
    edges: int
    triangles: int
    components: int
    open_edges: int
    misoriented_edges: int
    non_manifold_edges: int
    non_manifold_vertices: int
    flat_triangles: int
    duplicate_triangles: int
    intersections: int
    holes: int

    @property
    def is_watertight(self) -> bool:
        return self.open_edges == 0 and self.misoriented_edges == 0 and self.non_manifold_edges == 0


class Mesh:
    """A triangle mesh with its materials. It never changes; repair() and unite() return another one.

    vertices: (n, 3) real numbers, metres. faces: (m, 3) integers, counter-clockwise seen from outside.
    weld=True joins vertices at equal positions, as engines need it: normals and uv stay with the corners of faces.
    """

    def __init__(self, vertices: Any, faces: Any = None, *, normals: Any = None, uv: Any = None, materials: Any = None,
                 weld: bool = False) -> None:
        arrays = [lib.floats(vertices, 3, "vertices"),
                  None if faces is None else lib.integers(faces, 3, "faces"),
                  None if normals is None else lib.floats(normals, 3, "normals"),
                  None if uv is None else lib.floats(uv, 2, "uv"),
                  None if materials is None else lib.integers(materials, 1, "materials")]
        if faces is not None and np.size(faces) == 0:  # without rows each three vertices would be a face
            raise lib.BrittleError("empty_mesh", "there are no faces")
        given = lib.MeshArrays(sizeof(lib.MeshArrays), int(weld), *(lib.describe(a) for a in arrays))
        self._handle = lib.Handle("mesh")
        lib.call("mesh_from_arrays", byref(given), self._handle.out())

    @classmethod
    def _of(cls, handle: lib.Handle) -> "Mesh":
        mesh = cls.__new__(cls)
        mesh._handle = handle
        return mesh

    @property
    def vertices(self) -> np.ndarray:
        """(n, 3) float64, metres: a read-only view."""
        return lib.view(self._handle, "mesh_array", 1)

    @property
    def faces(self) -> np.ndarray:
        """(m, 3) uint32: a read-only view."""
        return lib.view(self._handle, "mesh_array", 2)

    @property
    def normals(self) -> np.ndarray:
        """(m, 3, 3) float32: of the corners of the faces, zero where a corner has none. Without rows where there are none."""
        return self._of_corners(3)

    @property
    def uv(self) -> np.ndarray:
        """(m, 3, 2) float32: of the corners of the faces, v points down. Without rows where there are none."""
        return self._of_corners(4)

    @property
    def uv2(self) -> np.ndarray:
        """(m, 3, 2) float32: the second set of texture coordinates. Without rows where there is none."""
        return self._of_corners(5)

    @property
    def colours(self) -> np.ndarray:
        """(m, 3, 4) float32: of the corners of the faces, linear, with opacity. Without rows where there are none."""
        return self._of_corners(6)

    @property
    def materials(self) -> np.ndarray:
        """(m,) uint32: the number in the file or the arrays of each face's material, 2**32 - 1 for a face without one.
        Without rows where no face has one."""
        return lib.view(self._handle, "mesh_array", 7)

    def _of_corners(self, which: int) -> np.ndarray:
        rows = lib.view(self._handle, "mesh_array", which)
        return rows.reshape(len(rows) // 3, 3, rows.shape[1])

    @property
    def bounds(self) -> np.ndarray:
        """(2, 3) float64: the corners of the box around all vertices."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def inspect(self) -> Inspection:
        """Lists the flaws of the mesh, and whether fracture() accepts it."""
        found = lib.InspectionStruct(struct_size=sizeof(lib.InspectionStruct))
        text = lib.Handle("text")
        lib.call("mesh_inspect", self._handle.pointer, byref(found), text.out())
        counts = {name: getattr(found, name) for name, _ in found._fields_[4:]}
        return Inspection(refusal=lib.status_name(found.refusal) if found.refusal else None, report=lib.text_of(text),
                          bounds=np.array([found.box_min, found.box_max]), **counts)

    def repair(self, *, weld_distance: float = -1.0, close_holes: float = math.inf, remesh_holes: str = "none",
               cavities: bool = False, covered_parts: bool = False) -> "Mesh":
        """Returns a closed, oriented manifold, as far as that is possible. remesh_holes: "none", "flat" or "smooth"."""
        settings = lib.defaults("repair_settings")
        kinds = ("none", "flat", "smooth")
        if remesh_holes not in kinds:
            raise ValueError(f"remesh_holes is {remesh_holes!r}; it must be one of {', '.join(kinds)}")
        settings.remesh_holes = kinds.index(remesh_holes)
        settings.weld_distance, settings.close_holes = weld_distance, close_holes
        settings.cavities, settings.covered_parts = int(cavities), int(covered_parts)
        handle = lib.Handle("mesh")
        lib.call("mesh_repair", self._handle.pointer, byref(settings), handle.out(), None)
        return Mesh._of(handle)

    def unite(self, threads: int = 0) -> "Mesh":
        """Returns one solid of parts that pass through each other. The mesh must be closed."""
        handle = lib.Handle("mesh")
        lib.call("mesh_unite", self._handle.pointer, count(threads, "threads"), handle.out(), None)
        return Mesh._of(handle)

    def export(self, path: Any) -> None:
        """Writes .glb, .obj, .ply or .stl, by the extension."""
        lib.call("mesh_save", self._handle.pointer, lib.path_bytes(path))

    def to_bytes(self, name: str = "mesh.glb") -> dict[str, bytes]:
        """The files that export(name) would write: name to content, the one to open first."""
        files = lib.Handle("files")
        lib.call("mesh_save_memory", self._handle.pointer, name.encode(), files.out())
        return lib.files_of(files)

    def __repr__(self) -> str:
        return f"<brittle.Mesh of {len(self.vertices)} vertices and {len(self.faces)} faces>"

    def _repr_html_(self) -> str:
        """The mesh, for a notebook."""
        colours = np.tile([0.8, 0.82, 0.85], (len(self.faces), 1))
        size = " \u00d7 ".join(f"{length:.4g}" for length in np.diff(self.bounds, axis=0)[0])
        return _picture.figure(_picture.draw(self.vertices, self.faces, colours),
                               f"{len(self.vertices)} vertices, {len(self.faces)} faces, {size} m")


def count(value: Any, name: str, largest: int = 0xffffffff) -> int:
    """An integer from 0 to `largest`; ctypes would take any other one modulo 2^32."""
    number = int(value)
    if number != value or not 0 <= number <= largest:
        raise ValueError(f"{name} is {value}; it must be an integer from 0 to {largest}")
    return number


def load(path: Any) -> Mesh:
    """Reads .obj, .stl, .ply, .off, .glb, .gltf or .3ds, with materials and textures."""
    handle = lib.Handle("mesh")
    lib.call("mesh_load", lib.path_bytes(path), handle.out())
    return Mesh._of(handle)


def load_bytes(data: bytes, extension: str) -> Mesh:
    """Reads the bytes of a mesh file; `extension` names the format, for example ".glb"."""
    handle = lib.Handle("mesh")
    lib.call("mesh_load_memory", bytes(data), len(data), extension.encode(), handle.out())
    return Mesh._of(handle)


def shape(name: str) -> Mesh:
    """A procedural shape: "cube", "icosphere:4", "torus", "animal", "statue", ..."""
    handle = lib.Handle("mesh")
    lib.call("mesh_shape", name.encode(), handle.out())
    return Mesh._of(handle)


def box(size: Any = (1.0, 1.0, 1.0)) -> Mesh:
    """A box around the origin; `size` in metres."""
    handle = lib.Handle("mesh")
    lib.call("mesh_box", lib.vector(size, 3, "size", c_double), handle.out())
    return Mesh._of(handle)


def as_mesh(mesh: Any) -> Mesh:
    """The mesh itself, or that of anything with vertices and faces, trimesh.Trimesh for example."""
    if isinstance(mesh, Mesh):
        return mesh
    if hasattr(mesh, "vertices") and hasattr(mesh, "faces"):
        return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    raise TypeError(f"{type(mesh).__name__} is no mesh: it needs vertices and faces")
