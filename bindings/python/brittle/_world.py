"""Destruction: breakable objects in a world of rigid bodies."""
from __future__ import annotations

import ctypes
import threading
from ctypes import byref, c_float, c_uint32, c_uint64
from dataclasses import dataclass
from typing import Any, Iterable, Optional

import numpy as np

from . import _library as lib
from ._fracture import Fracture
from ._mesh import as_mesh, count as _count

_NONE = 0xffffffff


@dataclass(frozen=True)
class AddedPiece:
    """A new piece. vertices: (v, 3) float32 relative to its centre of mass; faces: (t, 3), those of the outside first."""

    piece: int
    object: int
    slot: int  #: a small index, used again once the piece is gone
    depth: int  #: cuts between the original object and this piece
    parent: Optional[int]  #: the piece that was cut
    vertices: np.ndarray
    faces: np.ndarray
    exterior_faces: int
    center_mass: np.ndarray  #: in the coordinates of the unbroken object


@dataclass(frozen=True)
class Events:
    """Changes since the last call. Removals come first: added pieces use slots again."""

    removed: np.ndarray  #: (r, 2) uint32: piece, slot
    added: list[AddedPiece]
    fading: np.ndarray  #: (f, 2) uint32: piece, slot
    fading_shares: np.ndarray  #: (f,) float32: the visible share, from 1 to 0


def events_of(handle: lib.Handle) -> Events:
    """The events of a handle of the library."""
    rows = lib.view(handle, "events_array", 2)
    added = []
    for k, (piece, number, slot, depth, parent) in enumerate(rows.tolist()):
        exterior, arrays = c_uint32(), []
        for which in (1, 2, 3):
            array = lib.Array()
            lib.call("events_added_array", handle.pointer, k, which, byref(array), byref(exterior))
            arrays.append(lib.as_numpy(handle, array))
        added.append(AddedPiece(piece, number, slot, depth, None if parent == _NONE else parent, arrays[0], arrays[1],
                                exterior.value, arrays[2][0]))
    return Events(lib.view(handle, "events_array", 1), added, lib.view(handle, "events_array", 3),
                  lib.view(handle, "events_array", 4))


class World:
    """A world in which objects break. Y is up; metres, kilograms, seconds. Calls from several threads take turns.

    ground: height of the ground plane, or None. engine: "solver", Brittle's own, or "bullet".
    """

    def __init__(self, *, ground: Optional[float] = 0.0, gravity: Any = (0.0, -9.81, 0.0), step: float = 1.0 / 120.0,
                 engine: str = "solver", threads: int = 0, workers: int = 1, max_pieces: int = 2000,
                 latency: int = 2) -> None:
        if engine not in ("solver", "bullet"):
            raise ValueError(f"engine is {engine!r}; it must be 'solver' or 'bullet'")
        settings = lib.defaults("world_settings")
        settings.bullet, settings.has_ground = int(engine == "bullet"), int(ground is not None)
        settings.ground_height = 0.0 if ground is None else ground
        settings.gravity, settings.step = lib.vector(gravity, 3, "gravity"), step
        settings.threads, settings.workers = _count(threads, "threads"), _count(workers, "workers")
        settings.max_pieces, settings.latency = _count(max_pieces, "max_pieces"), _count(latency, "latency")
        self._handle = lib.Handle("world")
        self._turn = threading.Lock()
        lib.call("world_create", byref(settings), self._handle.out())

    def _call(self, name: str, *arguments: Any) -> None:
        with self._turn:
            lib.call(name, self._handle.pointer, *arguments)

    def add(self, thing: Any, *, material: str = "stone", strength: float = 0.1, min_size: float = 0.05,
            max_pieces: int = 48, roughness: Optional[float] = None, seed: int = 1, position: Any = (0.0, 0.0, 0.0),
            orientation: Any = (0.0, 0.0, 0.0, 1.0), linear_velocity: Any = (0.0, 0.0, 0.0),
            angular_velocity: Any = (0.0, 0.0, 0.0), anchors: Iterable[tuple[Any, float]] = ()) -> int:
        """Adds a mesh that blows break, or a Fracture as bonded pieces. Returns the number of the object.

        material: glass, stone, concrete, wood, ceramic or brick. strength: share of its handbook strength.
        orientation: a unit quaternion x, y, z, w. anchors: balls (centre, radius) in which the world holds it.
        """
        settings = lib.defaults("object_settings")
        settings.material, settings.strength = material.encode(), strength
        settings.min_size, settings.max_pieces = min_size, _count(max_pieces, "max_pieces")
        settings.roughness = -1.0 if roughness is None else roughness
        settings.seed = _count(seed, "seed", 0xffffffffffffffff)
        settings.position = lib.vector(position, 3, "position")
        settings.orientation = lib.vector(orientation, 4, "orientation")
        settings.linear_velocity = lib.vector(linear_velocity, 3, "linear_velocity")
        settings.angular_velocity = lib.vector(angular_velocity, 3, "angular_velocity")
        balls = [lib.Anchor(lib.vector(centre, 3, "an anchor", ctypes.c_double), radius) for centre, radius in anchors]
        held = (lib.Anchor * len(balls))(*balls)
        settings.anchors, settings.anchor_count = held, len(balls)
        number = c_uint32()
        if isinstance(thing, Fracture):
            self._call("world_add_bonded", thing._handle.pointer, byref(settings), byref(number))
        else:
            self._call("world_add_breakable", as_mesh(thing)._handle.pointer, byref(settings), byref(number))
        return number.value

    def remove(self, number: int) -> None:
        """Removes an object with all its pieces."""
        self._call("world_remove", _count(number, "number"))

    def strike(self, piece: int, point: Any, direction: Any, energy: float) -> bool:
        """Strikes a piece as a hammer of one kilogram with this energy (J) does. True where the piece breaks; its
        parts come some steps later."""
        broke = c_uint32()
        self._call("world_strike", _count(piece, "piece"), lib.vector(point, 3, "point"),
                   lib.vector(direction, 3, "direction"), energy, byref(broke))
        return bool(broke.value)

    def shoot(self, start: Any, velocity: Any, radius: float = 0.1, density: float = 7800.0) -> int:
        """Adds a ball. Returns its number for body()."""
        body = c_uint32()
        self._call("world_shoot", lib.vector(start, 3, "start"), lib.vector(velocity, 3, "velocity"), radius, density,
                   byref(body))
        return body.value

    def body(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Position and orientation (x, y, z, w) of a ball."""
        position, orientation = (c_float * 3)(), (c_float * 4)()
        self._call("world_body", _count(number, "number"), position, orientation)
        return np.array(position), np.array(orientation)

    def step(self, steps: int = 1) -> None:
        """Advances by steps of the world. Ctrl+C ends it between two of them."""
        for _ in range(_count(steps, "steps")):
            self._call("world_step", 1)

    def transforms(self, alpha: float = 1.0) -> np.ndarray:
        """A structured array with piece, slot, position (of the centre of mass) and orientation (x, y, z, w) of each
        piece. alpha: from 0, before the last step, to 1."""
        count = c_uint64()
        with self._turn:
            lib.call("world_transforms", self._handle.pointer, alpha, None, 0, byref(count))
            poses = np.zeros(count.value, lib.TRANSFORM)
            lib.call("world_transforms", self._handle.pointer, alpha, poses.ctypes.data, len(poses), byref(count))
        return poses

    def events(self) -> Events:
        """What changed since the last call."""
        handle = lib.Handle("events")
        self._call("world_events", handle.out())
        return events_of(handle)

    @property
    def state_hash(self) -> int:
        """Equal runs give equal hashes, with any number of threads."""
        value = c_uint64()
        self._call("world_state_hash", byref(value))
        return value.value
