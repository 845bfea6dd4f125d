"""Recipes, their runs, and replays of the logs of runs."""
from __future__ import annotations

import json
import os
import threading
from ctypes import byref, c_double, c_uint32, c_uint64, sizeof
from dataclasses import dataclass
from typing import Any, Callable, Mapping, Optional, Union

import numpy as np

from . import _library as lib
from ._fracture import Fracture
from ._mesh import Mesh, count as _count
from ._world import Events, events_of


def _settings(threads: int) -> Any:
    settings = lib.defaults("load_settings")
    settings.threads = _count(threads, "threads")
    return settings


class Recipe:
    """What breaks, how, and in which world: a mesh, or a scene of many objects (docs/scenes.md).

    Recipe("wall.json") reads a file, Recipe({"brittle": 1, "mesh": "bunny.obj"}) takes a mapping; `folder` is where its
    paths count from. A recipe never changes. Raises BrittleError with file, place and expected value.
    """

    def __init__(self, source: Union[str, os.PathLike, Mapping[str, Any]], *, folder: Any = None) -> None:
        self._handle = lib.Handle("recipe")
        if isinstance(source, Mapping):
            text = json.dumps(source).encode()
            lib.call("recipe_parse", text, None if folder is None else lib.path_bytes(folder), self._handle.out())
        elif folder is not None:
            raise TypeError("folder belongs to a mapping; the paths of a file count from its own folder")
        else:
            lib.call("recipe_load", lib.path_bytes(source), self._handle.out())

    def to_dict(self) -> dict[str, Any]:
        """The recipe with all its settings. Paths count from the working folder."""
        text = lib.Handle("text")
        lib.call("recipe_text", self._handle.pointer, text.out())
        return json.loads(lib.text_of(text))

    def save(self, path: Any) -> None:
        """Writes a file, with paths relative to its folder."""
        lib.call("recipe_save", self._handle.pointer, lib.path_bytes(path))

    def fracture(self, *, threads: int = 0, progress: Optional[Callable[[float], None]] = None,
                 report: Optional[Callable[[str], None]] = None, cancel: Optional[lib.CancelToken] = None) -> Fracture:
        """Breaks the mesh, in the coordinates of its file: the pieces of `brittle fracture RECIPE`, with the same hash.

        progress: called with the share done; report: with what was done to the mesh, such as a repair; both on another
        thread. A scene is refused: see run().
        """
        settings, handle = _settings(threads), lib.Handle("pieces")
        lib.long_call(settings, lambda: lib.call("recipe_fracture", self._handle.pointer, byref(settings), handle.out()),
                      progress, cancel, report)
        return Fracture(handle)

    def run(self, *, threads: int = 0, progress: Optional[Callable[[float], None]] = None,
            report: Optional[Callable[[str], None]] = None, cancel: Optional[lib.CancelToken] = None) -> Run:
        """Loads and breaks what the recipe holds, and starts its simulation. The arguments are those of fracture()."""
        settings, handle = _settings(threads), lib.Handle("run")
        lib.long_call(settings, lambda: lib.call("run_start", self._handle.pointer, byref(settings), handle.out()),
                      progress, cancel, report)
        return Run(handle)


@dataclass(frozen=True)
class RunObject:
    """An object of a run at its start."""

    name: str
    material: Optional[str]
    fixed: bool  #: a surface that never moves
    position: np.ndarray  #: m, of the object's origin in the world
    orientation: np.ndarray  #: x, y, z, w
    piece_count: int  #: 1 where it is fixed
    mesh: Mesh  #: unbroken, in the object's coordinates
    fracture: Optional[Fracture]  #: its pieces at the start, in its coordinates; None where it is fixed


class Run:
    """The simulation of a recipe: Recipe(...).run(). Steps of 1/120 s; shots of the recipe come at their times.

    A single mesh stands on the stage, 2 m large unless the recipe has units. Everything that happens is logged: see
    save_log(). Calls from several threads take turns.
    """

    def __init__(self, handle: lib.Handle) -> None:
        self._handle = handle
        self._turn = threading.Lock()

    def _call(self, name: str, *arguments: Any) -> None:
        with self._turn:
            lib.call(name, self._handle.pointer, *arguments)

    def step(self, steps: int = 1) -> None:
        """Advances by steps. Ctrl+C ends it between two of them."""
        for _ in range(_count(steps, "steps")):
            self._call("run_step", 1)

    def act(self, name: str, **fields: Any) -> None:
        """Takes an action of docs/replay.md: run.act("push", piece=3, point=[0, 1, 0], impulse=[0, 0, 5])."""
        plain = {key: value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
                 for key, value in fields.items()}
        self._call("run_act", json.dumps({name: plain}).encode())

    def shoot(self, start: Any, velocity: Any, radius: float = 0.1, density: float = 7800.0) -> None:
        """Shoots a ball."""
        self.act("shoot", velocity=list(map(float, velocity)), radius=float(radius), density=float(density),
                 **{"from": list(map(float, start))})

    def transforms(self) -> np.ndarray:
        """A structured array with piece, slot, position (of the centre of mass) and orientation (x, y, z, w) of each
        piece after the last step."""
        return self._table("run_transforms", lib.TRANSFORM)

    def balls(self) -> np.ndarray:
        """A structured array with position, orientation and radius of each ball that was shot, and of links of chains."""
        return self._table("run_balls", lib.BALL)

    def _table(self, name: str, dtype: np.dtype) -> np.ndarray:
        count = c_uint64()
        with self._turn:
            lib.call(name, self._handle.pointer, None, 0, byref(count))
            table = np.zeros(count.value, dtype)
            lib.call(name, self._handle.pointer, table.ctypes.data, len(table), byref(count))
        return table

    def events(self) -> Events:
        """What changed since the last call; the first call gives all pieces of the start. Empty where the recipe is not
        breakable: its pieces stay those of objects()."""
        handle = lib.Handle("events")
        self._call("run_events", handle.out())
        return events_of(handle)

    def objects(self) -> list[RunObject]:
        """The objects at the start; one for a recipe of one mesh."""
        count, found = c_uint32(), []
        self._call("run_object_count", byref(count))
        for k in range(count.value):
            one = lib.RunObjectStruct(struct_size=sizeof(lib.RunObjectStruct))
            self._call("run_object_get", k, byref(one))
            mesh, pieces = lib.Handle("mesh"), lib.Handle("pieces")
            self._call("run_object_mesh", k, mesh.out())
            if not one.is_fixed:
                self._call("run_object_pieces", k, pieces.out())
            found.append(RunObject((one.name or b"").decode(), (one.material or b"").decode() or None,
                                   bool(one.is_fixed), np.array(one.position), np.array(one.orientation),
                                   one.piece_count, Mesh._of(mesh), None if one.is_fixed else Fracture(pieces)))
        return found

    def save_log(self, path: Any) -> None:
        """Writes the replay log of the run so far: replay() and `brittle replay` repeat it."""
        self._call("run_save_log", lib.path_bytes(path))

    @property
    def notes(self) -> list[str]:
        """Lines for people about objects that the scene could not take as the recipe says."""
        text = lib.Handle("text")
        self._call("run_notes", text.out())
        return lib.text_of(text).splitlines()

    @property
    def steps(self) -> int:
        """Steps since the start."""
        value = c_uint64()
        self._call("run_time", byref(value), None)
        return value.value

    @property
    def step_seconds(self) -> float:
        value = c_double()
        self._call("run_time", None, byref(value))
        return value.value

    @property
    def state_hash(self) -> int:
        """That of a replay log: equal runs give equal hashes, with any number of threads."""
        value = c_uint64()
        self._call("run_state_hash", byref(value))
        return value.value


@dataclass(frozen=True)
class Replay:
    """What replay() found."""

    equal: bool  #: every state was that of the log
    steps: int
    actions: int
    first_difference: Optional[int]  #: the first step whose state differs
    difference: str  #: what differs, for people
    state_hash: int  #: of the last state that was reached


def replay(path: Any, *, threads: int = 0, progress: Optional[Callable[[float], None]] = None,
           cancel: Optional[lib.CancelToken] = None) -> Replay:
    """Repeats the run of a replay log up to its end or the first difference."""
    settings = _settings(threads)
    found = lib.ReplayResultStruct(struct_size=sizeof(lib.ReplayResultStruct))
    name = lib.path_bytes(path)
    lib.long_call(settings, lambda: lib.call("replay", name, byref(settings), byref(found)), progress, cancel)
    equal = bool(found.is_equal)
    return Replay(equal, found.steps, found.actions, None if equal else found.first_difference,
                  found.difference.decode(errors="replace"), found.state_hash)
