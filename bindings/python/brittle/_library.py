"""The C library behind the package: structures, functions, errors and array views. Mirrors bindings/c/brittle.h."""
from __future__ import annotations

import ctypes
import os
import pathlib
import threading
from ctypes import POINTER, byref, c_char_p, c_double, c_float, c_int32, c_size_t, c_uint32, c_uint64, c_void_p
from typing import Any, Callable, Optional

import numpy as np

_SONAME = "libbrittle.so.0.1"
_DTYPES: dict[int, np.dtype] = {1: np.dtype(np.float32), 2: np.dtype(np.float64), 3: np.dtype(np.uint16), 4: np.dtype(np.uint32)}
_TYPES = {dtype: number for number, dtype in _DTYPES.items()}


class BrittleError(Exception):
    """A refusal of the library. `status` is its name, for example "not_closed"; the text says what to do."""

    def __init__(self, status: str, message: str) -> None:
        super().__init__(message)
        self.status = status


class ArgumentError(BrittleError, ValueError):
    """An argument or a setting is out of range: status "invalid_argument" or "invalid_setting"."""


class MissingFileError(BrittleError, FileNotFoundError):
    """Status "file_not_found"."""

    def __str__(self) -> str:  # OSError would print its own arguments
        return str(self.args[0])


class OutOfMemoryError(BrittleError, MemoryError):
    """Status "out_of_memory"."""


class Cancelled(BrittleError):
    """The call was cancelled by its CancelToken."""


_ERRORS = {
    "invalid_argument": ArgumentError,
    "invalid_setting": ArgumentError,
    "file_not_found": MissingFileError,
    "out_of_memory": OutOfMemoryError,
    "cancelled": Cancelled,
}


class Error(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("status", c_int32), ("message", ctypes.c_char * 1016)]


class Array(ctypes.Structure):
    _fields_ = [("type", c_uint32), ("columns", c_uint32), ("rows", c_uint64), ("stride", c_uint64), ("data", c_void_p)]


class MeshArrays(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("weld", c_uint32), ("positions", Array), ("triangles", Array),
                ("normals", Array), ("uv", Array), ("materials", Array)]


class InspectionStruct(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("refusal", c_int32), ("box_min", c_double * 3), ("box_max", c_double * 3),
                ("area", c_double), ("volume", c_double)] + [
        (name, c_uint64) for name in (
            "vertices", "edges", "triangles", "components", "open_edges", "misoriented_edges", "non_manifold_edges",
            "non_manifold_vertices", "flat_triangles", "duplicate_triangles", "intersections", "holes")]


class RepairSettings(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("remesh_holes", c_uint32), ("weld_distance", c_double),
                ("close_holes", c_double), ("cavities", c_uint32), ("covered_parts", c_uint32)]


class Pattern(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("count", c_uint32), ("kind", c_char_p), ("seed", c_uint64),
                ("piece_size", c_double), ("jitter", c_double), ("focus", c_double * 3), ("axis", c_double * 3),
                ("spread", c_double), ("slenderness", c_double), ("grading", c_double), ("line", Array),
                ("cells_per_piece", c_uint32), ("inside", c_uint32)]


ProgressCall = ctypes.CFUNCTYPE(None, c_void_p, c_double)
CancelledCall = ctypes.CFUNCTYPE(c_int32, c_void_p)


class FractureSettings(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("threads", c_uint32), ("sequential", c_uint32), ("rough_detail", c_uint32),
                ("min_volume", c_double), ("roughness", c_double), ("rough_wavelength", c_double),
                ("rough_grain", c_double * 3), ("rough_seed", c_uint64), ("rough_max_triangles", c_uint64),
                ("workspace", c_void_p), ("progress", ProgressCall), ("cancelled", CancelledCall), ("user", c_void_p),
                ("cancel_flag", POINTER(c_int32))]


class CertificateStruct(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("pieces", c_uint32), ("closed", c_uint32), ("open_pieces", c_uint32),
                ("negative_pieces", c_uint32), ("cells", c_uint32), ("volume_input", c_double),
                ("volume_sum", c_double), ("smallest_piece", c_double), ("volume_error", c_double),
                ("triangles_in", c_uint64), ("triangles_out", c_uint64), ("cap_triangles", c_uint64),
                ("hash", c_uint64)]


class MaterialStruct(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("rough_detail", c_uint32), ("name", c_char_p), ("density", c_double),
                ("friction", c_double), ("restitution", c_double), ("tensile", c_double), ("compressive", c_double),
                ("shear", c_double), ("fracture_toughness", c_double), ("fracture_energy", c_double),
                ("pattern", c_char_p), ("pattern_jitter", c_double), ("pattern_spread", c_double),
                ("pattern_slenderness", c_double), ("pattern_axis", c_double * 3), ("roughness", c_double),
                ("rough_grain", c_double * 3), ("exterior", c_double * 3), ("interior", c_double * 3)]


class ExportSettings(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("per_piece", c_uint32), ("name", c_char_p), ("hulls", c_uint32),
                ("rigid_bodies", c_uint32), ("density", c_double), ("hull_parts", c_uint32)]


class WorldSettings(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("bullet", c_uint32), ("threads", c_uint32), ("workers", c_uint32),
                ("max_pieces", c_uint32), ("latency", c_uint32), ("has_ground", c_uint32), ("ground_height", c_float),
                ("gravity", c_float * 3), ("step", c_float)]


class Anchor(ctypes.Structure):
    _fields_ = [("centre", c_double * 3), ("radius", c_double)]


class ObjectSettings(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("max_pieces", c_uint32), ("material", c_char_p), ("strength", c_double),
                ("min_size", c_double), ("roughness", c_double), ("seed", c_uint64), ("position", c_float * 3),
                ("orientation", c_float * 4), ("linear_velocity", c_float * 3), ("angular_velocity", c_float * 3),
                ("anchors", POINTER(Anchor)), ("anchor_count", c_uint32)]


ReportCall = ctypes.CFUNCTYPE(None, c_void_p, c_char_p)


class LoadSettings(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("threads", c_uint32), ("progress", ProgressCall),
                ("cancelled", CancelledCall), ("report", ReportCall), ("user", c_void_p), ("cancel_flag", POINTER(c_int32))]


class RunObjectStruct(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("is_fixed", c_uint32), ("name", c_char_p), ("material", c_char_p),
                ("position", c_float * 3), ("orientation", c_float * 4), ("piece_count", c_uint32)]


class ReplayResultStruct(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("is_equal", c_uint32), ("steps", c_uint64), ("actions", c_uint64),
                ("first_difference", c_uint64), ("state_hash", c_uint64), ("difference", ctypes.c_char * 1016)]


BALL = np.dtype([("position", np.float32, 3), ("orientation", np.float32, 4), ("radius", np.float32)])
TRANSFORM = np.dtype([("piece", np.uint32), ("slot", np.uint32), ("position", np.float32, 3),
                      ("orientation", np.float32, 4)])


def _load() -> ctypes.CDLL:
    """The library of BRITTLE_LIBRARY, else the one in the package, else that of the system."""
    given = os.environ.get("BRITTLE_LIBRARY")
    bundled = pathlib.Path(__file__).parent / "lib" / _SONAME
    return ctypes.CDLL(given or (str(bundled) if bundled.exists() else _SONAME))


_P, _E, _F = c_void_p, POINTER(Error), POINTER(c_float)
# The arguments of each function that returns a status, without the error at the end.
_CALLS: dict[str, list[Any]] = {
    "mesh_from_arrays": [POINTER(MeshArrays), POINTER(_P)],
    "mesh_load": [c_char_p, POINTER(_P)],
    "mesh_load_memory": [c_char_p, c_size_t, c_char_p, POINTER(_P)],
    "mesh_shape": [c_char_p, POINTER(_P)],
    "mesh_box": [POINTER(c_double), POINTER(_P)],
    "mesh_save": [_P, c_char_p],
    "mesh_save_memory": [_P, c_char_p, POINTER(_P)],
    "mesh_array": [_P, c_uint32, POINTER(Array)],
    "mesh_inspect": [_P, POINTER(InspectionStruct), POINTER(_P)],
    "mesh_repair": [_P, POINTER(RepairSettings), POINTER(_P), POINTER(_P)],
    "mesh_unite": [_P, c_uint32, POINTER(_P), POINTER(_P)],
    "files_get": [_P, c_uint64, POINTER(c_char_p), POINTER(_P), POINTER(c_size_t)],
    "sites_pattern": [POINTER(Pattern), _P, POINTER(_P)],
    "sites_from_arrays": [POINTER(Array), POINTER(Array), POINTER(Array), POINTER(_P)],
    "sites_load": [c_char_p, POINTER(_P)],
    "sites_array": [_P, c_uint32, POINTER(Array)],
    "fracture": [_P, _P, POINTER(FractureSettings), POINTER(_P)],
    "pieces_array": [_P, c_uint32, POINTER(Array)],
    "pieces_certificate": [_P, POINTER(CertificateStruct)],
    "pieces_surface": [_P, c_uint32, POINTER(_P)],
    "surface_part": [_P, c_uint64, POINTER(c_uint32), POINTER(c_uint32)],
    "surface_array": [_P, c_uint64, c_uint32, POINTER(Array)],
    "pieces_hulls": [_P, c_uint32, c_uint32, POINTER(_P)],
    "hulls_array": [_P, c_uint32, POINTER(Array)],
    "pieces_save": [_P, c_char_p, POINTER(ExportSettings)],
    "pieces_save_memory": [_P, c_char_p, POINTER(ExportSettings), POINTER(_P)],
    "material_get": [c_char_p, POINTER(MaterialStruct)],
    "world_create": [POINTER(WorldSettings), POINTER(_P)],
    "world_add_breakable": [_P, _P, POINTER(ObjectSettings), POINTER(c_uint32)],
    "world_add_bonded": [_P, _P, POINTER(ObjectSettings), POINTER(c_uint32)],
    "world_remove": [_P, c_uint32],
    "world_strike": [_P, c_uint32, _F, _F, c_double, POINTER(c_uint32)],
    "world_shoot": [_P, _F, _F, c_float, c_float, POINTER(c_uint32)],
    "world_body": [_P, c_uint32, _F, _F],
    "world_step": [_P, c_uint32],
    "world_state_hash": [_P, POINTER(c_uint64)],
    "world_transforms": [_P, c_float, _P, c_uint64, POINTER(c_uint64)],
    "world_events": [_P, POINTER(_P)],
    "recipe_load": [c_char_p, POINTER(_P)],
    "recipe_parse": [c_char_p, c_char_p, POINTER(_P)],
    "recipe_text": [_P, POINTER(_P)],
    "recipe_save": [_P, c_char_p],
    "recipe_fracture": [_P, POINTER(LoadSettings), POINTER(_P)],
    "run_start": [_P, POINTER(LoadSettings), POINTER(_P)],
    "run_notes": [_P, POINTER(_P)],
    "run_step": [_P, c_uint32],
    "run_time": [_P, POINTER(c_uint64), POINTER(c_double)],
    "run_act": [_P, c_char_p],
    "run_state_hash": [_P, POINTER(c_uint64)],
    "run_transforms": [_P, _P, c_uint64, POINTER(c_uint64)],
    "run_balls": [_P, _P, c_uint64, POINTER(c_uint64)],
    "run_events": [_P, POINTER(_P)],
    "run_object_count": [_P, POINTER(c_uint32)],
    "run_object_get": [_P, c_uint32, POINTER(RunObjectStruct)],
    "run_object_pieces": [_P, c_uint32, POINTER(_P)],
    "run_object_mesh": [_P, c_uint32, POINTER(_P)],
    "run_save_log": [_P, c_char_p],
    "replay": [c_char_p, POINTER(LoadSettings), POINTER(ReplayResultStruct)],
    "events_array": [_P, c_uint32, POINTER(Array)],
    "events_added_array": [_P, c_uint64, c_uint32, POINTER(Array), POINTER(c_uint32)],
}
_FREE = ("mesh", "text", "files", "sites", "pieces", "surface", "hulls", "world", "events", "recipe", "run")
_INIT = {"repair_settings": RepairSettings, "pattern": Pattern, "fracture_settings": FractureSettings,
         "export_settings": ExportSettings, "world_settings": WorldSettings, "object_settings": ObjectSettings,
         "load_settings": LoadSettings}

_library = _load()


def _declare() -> None:
    for name, arguments in _CALLS.items():
        function = getattr(_library, "brittle_" + name)
        function.argtypes, function.restype = arguments + [_E], c_int32
    for name in _FREE:
        function = getattr(_library, f"brittle_{name}_free")
        function.argtypes, function.restype = [c_void_p], None
    for name, struct in _INIT.items():
        function = getattr(_library, f"brittle_{name}_init")
        function.argtypes, function.restype = [POINTER(struct), c_size_t], None
    others: list[tuple[str, list[Any], Any]] = [
        ("text_get", [c_void_p], c_char_p), ("files_count", [c_void_p], c_uint64),
        ("surface_parts", [c_void_p], c_uint64), ("version", [], c_char_p), ("status_name", [c_int32], c_char_p),
        ("material_name", [c_uint32], c_char_p)]
    for name, arguments, result in others:
        function = getattr(_library, "brittle_" + name)
        function.argtypes, function.restype = arguments, result


try:
    _declare()
except AttributeError as missing:
    raise ImportError(f"the library is of another version than this package: {missing}") from None


def version() -> str:
    """The version of the library."""
    return _library.brittle_version().decode()


def status_name(status: int) -> str:
    return _library.brittle_status_name(status).decode()


def material_names() -> tuple[str, ...]:
    names: list[str] = []
    while name := _library.brittle_material_name(len(names)):
        names.append(name.decode())
    return tuple(names)


def call(name: str, *arguments: Any) -> None:
    """Calls brittle_NAME. A failure becomes an exception."""
    error = Error(struct_size=ctypes.sizeof(Error))
    status = getattr(_library, "brittle_" + name)(*arguments, byref(error))
    if status != 0:
        label = status_name(status)
        raise _ERRORS.get(label, BrittleError)(label, error.message.decode(errors="replace"))


def defaults(name: str) -> Any:
    """A structure of settings with its defaults."""
    settings = _INIT[name]()
    getattr(_library, f"brittle_{name}_init")(byref(settings), ctypes.sizeof(settings))
    return settings


class Handle:
    """Owns an object of the library and frees it with the last reference."""

    __slots__ = ("pointer", "_free", "__weakref__")

    def __init__(self, kind: str) -> None:
        self.pointer = c_void_p()
        self._free: Callable[[c_void_p], None] = getattr(_library, f"brittle_{kind}_free")

    def out(self) -> Any:
        """The argument through which a function gives the object out."""
        return byref(self.pointer)

    def __del__(self) -> None:
        self._free(self.pointer)


class _View:
    """What numpy needs for an array that keeps its owner alive."""

    def __init__(self, owner: Handle, interface: dict) -> None:
        self.owner = owner
        self.__array_interface__ = interface


def view(owner: Handle, name: str, *arguments: Any) -> np.ndarray:
    """A read-only numpy view of an array of the library, without a copy. One column gives one dimension."""
    array = Array()
    call(name, owner.pointer, *arguments, byref(array))
    return as_numpy(owner, array)


def as_numpy(owner: Handle, array: Array) -> np.ndarray:
    dtype = _DTYPES[array.type]
    shape = (array.rows,) if array.columns == 1 else (array.rows, array.columns)
    if array.rows == 0:
        return np.zeros(shape, dtype)
    strides = (array.stride,) if array.columns == 1 else (array.stride, dtype.itemsize)
    return np.asarray(_View(owner, {"data": (array.data, True), "shape": shape, "strides": strides,
                                    "typestr": dtype.str, "version": 3}))


def text_of(handle: Handle) -> str:
    return _library.brittle_text_get(handle.pointer).decode()


def files_of(handle: Handle) -> dict[str, bytes]:
    """Copies of the files in memory, the one to open first."""
    found = {}
    for k in range(_library.brittle_files_count(handle.pointer)):
        name, data, size = c_char_p(), c_void_p(), c_size_t()
        call("files_get", handle.pointer, k, byref(name), byref(data), byref(size))
        found[(name.value or b"").decode()] = ctypes.string_at(data, size.value)
    return found


def surface_parts(handle: Handle) -> int:
    return _library.brittle_surface_parts(handle.pointer)


def floats(values: Any, columns: int, name: str) -> np.ndarray:
    """An array of the caller's with real numbers, as float32 or float64; copied only where the library cannot read it."""
    array = np.asarray(values)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} has the dtype {array.dtype}; it must hold real numbers")
    wanted = (-1,) if columns == 1 else (-1, columns)
    if array.ndim != len(wanted) or (columns > 1 and array.shape[1] != columns):
        raise ValueError(f"{name} has the shape {array.shape}; it must be (n{', ' + str(columns) if columns > 1 else ','})")
    if array.dtype not in (np.float32, np.float64) or not array.dtype.isnative:
        array = array.astype(np.float64)
    return _readable(array)


def integers(values: Any, columns: int, name: str) -> np.ndarray:
    """An array of the caller's with integers from 0 to 2^32 - 1, as uint16 or uint32."""
    array = np.asarray(values)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name} has the dtype {array.dtype}; it must hold integers")
    if array.ndim != (1 if columns == 1 else 2) or (columns > 1 and array.shape[1] != columns):
        raise ValueError(f"{name} has the shape {array.shape}; it must be (n{', ' + str(columns) if columns > 1 else ','})")
    if array.dtype not in (np.uint16, np.uint32) or not array.dtype.isnative:
        if array.size and (array.min() < 0 or array.max() > 0xffffffff):
            raise ValueError(f"{name} has numbers from {array.min()} to {array.max()}; they must be from 0 to 2^32 - 1")
        array = array.astype(np.uint32)
    return _readable(array)


def _readable(array: np.ndarray) -> np.ndarray:
    columns = array.shape[1] if array.ndim == 2 else 1
    rows_ok = array.strides[0] >= columns * array.itemsize
    columns_ok = array.ndim == 1 or array.strides[1] == array.itemsize
    return array if rows_ok and columns_ok else np.ascontiguousarray(array)


def describe(array: Optional[np.ndarray]) -> Array:
    """The structure for an array of floats() or integers(), which must outlive it; an empty one for None."""
    if array is None:
        return Array()
    columns = array.shape[1] if array.ndim == 2 else 1
    stride = array.strides[0] if array.shape[0] > 1 else columns * array.itemsize
    return Array(_TYPES[array.dtype], columns, array.shape[0], stride, array.ctypes.data)


def vector(values: Any, size: int, name: str, kind: Any = c_float) -> Any:
    numbers = [float(v) for v in values]
    if len(numbers) != size:
        raise ValueError(f"{name} has {len(numbers)} numbers; it must have {size}")
    return (kind * size)(*numbers)


def path_bytes(path: Any) -> bytes:
    return os.fsencode(path)


class CancelToken:
    """Cancels long calls from any thread: fracture(..., cancel=token), and token.cancel() elsewhere."""

    def __init__(self) -> None:
        self.flag = c_int32(0)

    def cancel(self) -> None:
        self.flag.value = 1

    @property
    def cancelled(self) -> bool:
        return self.flag.value != 0


def interruptible(work: Callable[[], None], token: CancelToken) -> None:
    """Runs work() such that Ctrl+C cancels it: signals reach the main thread alone, so it waits for another one."""
    if threading.current_thread() is not threading.main_thread():
        work()
        return
    done, failure = threading.Event(), []

    def run() -> None:
        try:
            work()
        except BaseException as error:  # pylint: disable=broad-except
            failure.append(error)
        finally:
            done.set()

    thread = threading.Thread(target=run, name="brittle", daemon=True)
    thread.start()
    try:
        done.wait()
    except BaseException:
        token.cancel()
        thread.join()
        raise
    thread.join()
    if failure:
        raise failure[0]


def long_call(settings: Any, work: Callable[[], None], progress: Optional[Callable[[float], None]],
              cancel: Optional[CancelToken], report: Optional[Callable[[str], None]] = None) -> None:
    """Runs work(), which passes these settings to the library, such that Ctrl+C and `cancel` end it. An exception of
    progress() or report() ends it, too, and is raised here."""
    token = cancel if cancel is not None else CancelToken()
    settings.cancel_flag = ctypes.pointer(token.flag)
    failure: list[BaseException] = []

    def passing(callback: Callable[[Any], None]) -> Callable[[Any, Any], None]:
        def call_back(_user: Any, value: Any) -> None:
            try:
                if not failure:
                    callback(value.decode(errors="replace") if isinstance(value, bytes) else value)
            except BaseException as error:  # pylint: disable=broad-except
                failure.append(error)  # an exception cannot pass through the library
                token.cancel()
        return call_back

    if progress is not None:
        settings.progress = ProgressCall(passing(progress))
    if report is not None:
        settings.report = ReportCall(passing(report))
    try:
        interruptible(work, token)
    except Cancelled:
        if not failure:
            raise
    if failure:
        raise failure[0]
