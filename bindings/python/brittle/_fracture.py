"""Fracture: sites, pieces, bonds, hulls and render buffers."""
from __future__ import annotations

from collections.abc import Sequence
from ctypes import byref, c_double, c_uint32, sizeof
from dataclasses import dataclass
from typing import Any, Callable, Iterator, Optional, Union, overload

import numpy as np

from . import _library as lib
from . import _material, _picture
from ._mesh import as_mesh, count as _count

_SEED = 0xffffffffffffffff


class Sites:
    """Voronoi sites. positions: (n, 3). weights: (n,) in m^2, larger cells for heavier sites. groups: (n,) integers;
    the cells of one group become one piece where they touch."""

    def __init__(self, positions: Any, weights: Any = None, groups: Any = None) -> None:
        arrays = [lib.floats(positions, 3, "positions"),
                  None if weights is None else lib.floats(weights, 1, "weights"),
                  None if groups is None else lib.integers(groups, 1, "groups")]
        given = [None if a is None else byref(lib.describe(a)) for a in arrays]
        self._handle = lib.Handle("sites")
        lib.call("sites_from_arrays", *given, self._handle.out())

    @classmethod
    def _of(cls, handle: lib.Handle) -> "Sites":
        sites = cls.__new__(cls)
        sites._handle = handle
        return sites

    @property
    def positions(self) -> np.ndarray:
        return lib.view(self._handle, "sites_array", 1)

    @property
    def weights(self) -> np.ndarray:
        """Without rows where there are none."""
        return lib.view(self._handle, "sites_array", 2)

    @property
    def groups(self) -> np.ndarray:
        """Without rows where there are none."""
        return lib.view(self._handle, "sites_array", 3)

    def __len__(self) -> int:
        return len(self.positions)


def load_sites(path: Any) -> Sites:
    """Reads a text file with a site a line: x y z, or x y z radius."""
    handle = lib.Handle("sites")
    lib.call("sites_load", lib.path_bytes(path), handle.out())
    return Sites._of(handle)


def make_sites(mesh: Any, count: int = 20, *, seed: int = 1, pattern: Optional[str] = None, piece_size: float = 0.0,
               jitter: Optional[float] = None, focus: Any = None, axis: Any = None, spread: Optional[float] = None,
               slenderness: Optional[float] = None, grading: float = 0.0, cells_per_piece: int = 1,
               inside: Optional[bool] = None, line: Any = None, material: Optional[str] = None) -> Sites:
    """The sites of a pattern: uniform, clustered, radial, grid, bricks, slices, splinters, curve, curvature or
    thickness.

    material: one of MATERIALS gives pattern, jitter, axis, spread and slenderness where they are left out.
    piece_size: m; it replaces count. jitter: 0 to 1. focus and line: from 0 to 1 along each side of the mesh's box.
    spread: of a clustered pattern, as a share of the box's diagonal. slenderness: of splinters. grading: spread of the
    sizes of pieces, 0 to 1. inside: only sites inside the solid; by default those of uniform and clustered patterns.
    """
    settings = lib.defaults("pattern")
    if material is not None:
        stuff = _material.material(material)
        settings.kind, settings.jitter, settings.spread = stuff.pattern.encode(), stuff.pattern_jitter, stuff.pattern_spread
        settings.slenderness, settings.axis = stuff.pattern_slenderness, stuff.pattern_axis
    if pattern is not None:
        settings.kind = pattern.encode()
    settings.kind = settings.kind or b"uniform"
    settings.count, settings.seed = _count(count, "count"), _count(seed, "seed", _SEED)
    settings.piece_size, settings.grading = piece_size, grading
    for name, number in (("jitter", jitter), ("spread", spread), ("slenderness", slenderness)):
        if number is not None:
            setattr(settings, name, number)
    for name, numbers in (("focus", focus), ("axis", axis)):
        if numbers is not None:
            setattr(settings, name, lib.vector(numbers, 3, name, c_double))
    settings.cells_per_piece = _count(cells_per_piece, "cells_per_piece")
    settings.inside = int(settings.kind in (b"uniform", b"clustered") if inside is None else inside)
    points = None if line is None else lib.floats(line, 3, "line")
    settings.line = lib.describe(points)
    handle = lib.Handle("sites")
    lib.call("sites_pattern", byref(settings), as_mesh(mesh)._handle.pointer, handle.out())
    return Sites._of(handle)


@dataclass(frozen=True)
class Certificate:
    """What certifies the pieces, computed from them alone. Volumes in m^3."""

    pieces: int
    closed: bool
    open_pieces: int
    negative_pieces: int
    cells: int
    volume_input: float
    volume_sum: float
    smallest_piece: float
    volume_error: float
    triangles_in: int
    triangles_out: int
    cap_triangles: int
    hash: int


@dataclass(frozen=True)
class SurfacePart:
    """Render buffers of one material of a piece: read-only float32 views, relative to the centre of mass."""

    material: Optional[int]  #: of the mesh; None for cuts and for a mesh without materials
    interior: bool  #: whether it is a cut
    positions: np.ndarray  #: (v, 3), metres
    normals: np.ndarray  #: (v, 3), unit
    uv: np.ndarray  #: (v, 2), v points down; without rows where there are none
    uv2: np.ndarray
    colours: np.ndarray  #: (v, 4), linear; without rows where there are none
    faces: np.ndarray  #: (t, 3) uint32
    vertices: np.ndarray  #: (v,) uint32: the vertex of the piece at each of these


class Piece:
    """One piece of a fracture. Its arrays are read-only views, which keep the fracture alive."""

    __slots__ = ("_fracture", "index")

    def __init__(self, fracture: "Fracture", index: int) -> None:
        self._fracture = fracture
        self.index = index

    @property
    def vertices(self) -> np.ndarray:
        """(n, 3) float64, metres, in the coordinates of the mesh."""
        begin, end = self._fracture._array(4)[self.index]
        return self._fracture._array(1)[begin:end]

    @property
    def faces(self) -> np.ndarray:
        """(m, 3) uint32, those of the outside first."""
        begin, end = self._fracture._array(5)[self.index]
        return self._fracture._array(2)[begin:end]

    @property
    def face_sources(self) -> np.ndarray:
        """(m,) uint32: outside, the face of the mesh; on a cut, the site on the other side."""
        begin, end = self._fracture._array(5)[self.index]
        return self._fracture._array(3)[begin:end]

    @property
    def exterior_faces(self) -> int:
        """How many of the first faces lie on the surface of the mesh."""
        return int(self._fracture._array(6)[self.index])

    @property
    def site(self) -> int:
        """The site in whose cell the piece lies."""
        return int(self._fracture._array(7)[self.index])

    @property
    def volume(self) -> float:
        """m^3."""
        return float(self._fracture._array(8)[self.index])

    @property
    def area(self) -> float:
        """Of the whole surface, m^2."""
        return float(self._fracture._array(9)[self.index])

    @property
    def center_mass(self) -> np.ndarray:
        """(3,), metres."""
        return self._fracture._array(10)[self.index]

    @property
    def moment_inertia(self) -> np.ndarray:
        """(3, 3), about the centre of mass at density 1, m^5."""
        return self._fracture._array(11)[self.index].reshape(3, 3)

    def surface(self) -> list[SurfacePart]:
        """Render buffers with normals and texture coordinates, a part for each material, then the cuts."""
        handle = lib.Handle("surface")
        lib.call("pieces_surface", self._fracture._handle.pointer, self.index, handle.out())
        parts = []
        for k in range(lib.surface_parts(handle)):
            material, interior = c_uint32(), c_uint32()
            lib.call("surface_part", handle.pointer, k, byref(material), byref(interior))
            arrays = [lib.view(handle, "surface_array", k, which) for which in range(1, 8)]
            parts.append(SurfacePart(None if material.value == 0xffffffff else material.value, bool(interior.value),
                                     *arrays))
        return parts

    def __repr__(self) -> str:
        return f"<brittle.Piece {self.index} of {len(self._fracture.pieces)}, {self.volume:.6g} m^3>"


class _Pieces(Sequence):
    def __init__(self, fracture: "Fracture") -> None:
        self._fracture = fracture

    def __len__(self) -> int:
        return len(self._fracture._array(8))

    @overload
    def __getitem__(self, index: int) -> Piece: ...
    @overload
    def __getitem__(self, index: slice) -> list[Piece]: ...
    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [Piece(self._fracture, k) for k in range(*index.indices(len(self)))]
        if not -len(self) <= index < len(self):
            raise IndexError(f"there is no piece {index}; there are {len(self)}")
        return Piece(self._fracture, index % len(self))

    def __iter__(self) -> Iterator[Piece]:
        return (Piece(self._fracture, k) for k in range(len(self)))


class Fracture:
    """The pieces of a fracture. It never changes, and any thread may read it."""

    def __init__(self, handle: lib.Handle) -> None:
        self._handle = handle

    def _array(self, which: int) -> np.ndarray:
        return lib.view(self._handle, "pieces_array", which)

    @property
    def pieces(self) -> _Pieces:
        """All pieces, a sequence."""
        return _Pieces(self)

    @property
    def volumes(self) -> np.ndarray:
        """(p,) float64, m^3."""
        return self._array(8)

    @property
    def centers_mass(self) -> np.ndarray:
        """(p, 3) float64, m."""
        return self._array(10)

    @property
    def bonds(self) -> np.ndarray:
        """(b, 2) uint32: pieces that touch, the lower number first."""
        return self._array(12)

    @property
    def bond_areas(self) -> np.ndarray:
        """(b,) float64, m^2."""
        return self._array(13)

    @property
    def bond_centroids(self) -> np.ndarray:
        """(b, 3) float64, of the areas of contact, m."""
        return self._array(14)

    @property
    def bond_normals(self) -> np.ndarray:
        """(b, 3) float64, unit, from the first to the second piece."""
        return self._array(15)

    @property
    def certificate(self) -> Certificate:
        """Closedness, volumes and hash, computed from the pieces alone."""
        found = lib.CertificateStruct(struct_size=sizeof(lib.CertificateStruct))
        lib.call("pieces_certificate", self._handle.pointer, byref(found))
        values = {name: getattr(found, name) for name, _ in found._fields_[1:]}
        values["closed"] = bool(values["closed"])
        return Certificate(**values)

    @property
    def hash(self) -> str:
        """16 hexadecimal digits, as `brittle fracture` prints them."""
        return f"{self.certificate.hash:016x}"

    def hulls(self, max_parts: int = 1, max_vertices: int = 32) -> list[list[np.ndarray]]:
        """Collision hulls: for each piece the points of its convex parts, (n, 3) float32 relative to its centre of
        mass. With one part a piece has its convex hull; more follow pieces that are not convex."""
        handle = lib.Handle("hulls")
        lib.call("pieces_hulls", self._handle.pointer, _count(max_parts, "max_parts"),
                 _count(max_vertices, "max_vertices"), handle.out())
        points, ranges, owners = (lib.view(handle, "hulls_array", which) for which in (1, 2, 3))
        hulls: list[list[np.ndarray]] = [[] for _ in self.pieces]
        for (begin, end), piece in zip(ranges, owners):
            hulls[piece].append(points[begin:end])
        return hulls

    def _export_settings(self, name: str, per_piece: bool, hulls: Optional[str], rigid_bodies: bool,
                         density: float, hull_parts: int) -> Any:
        settings = lib.defaults("export_settings")
        names = (None, "godot", "unreal")
        if hulls not in names:
            raise ValueError(f"hulls is {hulls!r}; it must be None, 'godot' or 'unreal'")
        settings.name, settings.hulls = name.encode(), names.index(hulls)
        settings.per_piece, settings.rigid_bodies, settings.density = int(per_piece), int(rigid_bodies), density
        settings.hull_parts = _count(hull_parts, "hull_parts")
        return settings

    def export(self, path: Any, *, name: str = "mesh", per_piece: bool = False, hulls: Optional[str] = None,
               rigid_bodies: bool = False, density: float = 1000.0, hull_parts: int = 16) -> None:
        """Writes the pieces to .glb, .obj, .ply or .stl with the materials of the mesh.

        For GLB: `hulls` names the nodes so that 'godot' or 'unreal' makes bodies of the pieces; `rigid_bodies` adds
        masses (of `density`, kg/m^3) and collision hulls with KHR_physics_rigid_bodies; `hull_parts` is the most hulls
        of a piece that is not convex.
        """
        settings = self._export_settings(name, per_piece, hulls, rigid_bodies, density, hull_parts)
        lib.call("pieces_save", self._handle.pointer, lib.path_bytes(path), byref(settings))

    def to_bytes(self, file: str = "pieces.glb", *, name: str = "mesh", per_piece: bool = False,
                 hulls: Optional[str] = None, rigid_bodies: bool = False, density: float = 1000.0,
                 hull_parts: int = 16) -> dict[str, bytes]:
        """The files that export(file) would write: name to content, the one to open first."""
        settings = self._export_settings(name, per_piece, hulls, rigid_bodies, density, hull_parts)
        files = lib.Handle("files")
        lib.call("pieces_save_memory", self._handle.pointer, file.encode(), byref(settings), files.out())
        return lib.files_of(files)

    def __repr__(self) -> str:
        return f"<brittle.Fracture of {len(self.pieces)} pieces>"

    def _repr_html_(self) -> str:
        """The pieces, moved apart, for a notebook."""
        vertices, faces = self._array(1), self._array(2)
        vertex_ranges, face_ranges = self._array(4), self._array(5)
        centres = self.centers_mass
        middle = (centres * self.volumes[:, None]).sum(axis=0) / max(self.volumes.sum(), 1e-300)
        vertex_counts, face_counts = np.diff(vertex_ranges, axis=1)[:, 0], np.diff(face_ranges, axis=1)[:, 0]
        apart = vertices + np.repeat(0.25 * (centres - middle), vertex_counts, axis=0)
        absolute = faces.astype(np.int64) + np.repeat(vertex_ranges[:, 0], face_counts)[:, None]
        colours = np.repeat(_picture.piece_colours(len(self.pieces)), face_counts, axis=0)
        return _picture.figure(_picture.draw(apart, absolute, colours),
                               f"{len(self.pieces)} pieces, {len(faces)} faces, {self.volumes.sum():.4g} m\u00b3")


def fracture(mesh: Any, sites: Union[int, Sites, Any] = 100, *, seed: int = 1, material: Optional[str] = None,
             roughness: Optional[float] = None, wavelength: float = 0.0, grain: Any = None,
             detail: Optional[int] = None, min_volume: float = 0.0, threads: int = 0,
             progress: Optional[Callable[[float], None]] = None, cancel: Optional[lib.CancelToken] = None,
             **pattern_options: Any) -> Fracture:
    """Cuts a closed mesh into watertight pieces.

    sites: their number, of the pattern; or Sites; or an array (n, 3). `pattern_options` are those of make_sites().
    material: one of MATERIALS gives pattern, roughness, grain and detail where they are left out.
    roughness: of the cuts, from 0 (flat) to 1; wavelength: of the largest bumps, m, 0 for the distance of sites; grain:
    direction of the grain, its length the stretch along it, 1/16 to 16; detail: octaves, 1 to 6.
    min_volume: smaller pieces join a neighbour, m^3. threads: 0 for one per core; pieces do not depend on it.
    progress: called with the share done, on another thread. Ctrl+C and `cancel` end the call within about 0.1 s.
    Raises BrittleError with status and remedy for a mesh or setting that cannot be used, Cancelled for `cancel`.
    """
    solid = as_mesh(mesh)
    if isinstance(sites, (int, np.integer)):
        given = make_sites(solid, int(sites), seed=seed, material=material, **pattern_options)
    elif pattern_options:
        raise TypeError(f"{', '.join(pattern_options)}: options of a pattern need a number of sites")
    else:
        given = sites if isinstance(sites, Sites) else Sites(sites)
    settings = lib.defaults("fracture_settings")
    settings.threads, settings.min_volume = _count(threads, "threads"), min_volume
    if material is not None:
        stuff = _material.material(material)
        settings.roughness, settings.rough_grain = stuff.roughness, stuff.rough_grain
        settings.rough_detail = stuff.rough_detail
    if roughness is not None:
        settings.roughness = roughness
    if grain is not None:
        settings.rough_grain = lib.vector(grain, 3, "grain", c_double)
    if detail is not None:
        settings.rough_detail = _count(detail, "detail")
    settings.rough_wavelength, settings.rough_seed = wavelength, _count(seed, "seed", _SEED)
    handle = lib.Handle("pieces")
    lib.long_call(settings, lambda: lib.call("fracture", solid._handle.pointer, given._handle.pointer, byref(settings),
                                             handle.out()), progress, cancel)
    return Fracture(handle)
