"""Sites from what a scene holds: a pattern, an empty, particles, a stroke of grease pencil, painted weights."""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import kdtree

from .engine import brittle
from .layers import gather
from .meshes import matrix_of


class SourceError(Exception):
    """What is missing, and what to do about it."""


def sites_of(thing: bpy.types.Object, mesh: "brittle.Mesh", depsgraph: bpy.types.Depsgraph) -> "brittle.Sites":
    """The sites that the settings of an object ask for. Raises SourceError, brittle.BrittleError."""
    settings = thing.brittle
    return SOURCES[settings.source](thing, mesh, depsgraph, settings)


def _pattern(settings, mesh, **options) -> "brittle.Sites":
    if settings.pattern != "MATERIAL":
        options.setdefault("pattern", settings.pattern.lower())
    if settings.material != "NONE":
        options["material"] = settings.material.lower()
    return brittle.make_sites(mesh, settings.count, seed=settings.seed, cells_per_piece=settings.cells_per_piece,
                              **{"axis": tuple(settings.axis), **options})


def _from_pattern(_thing, mesh, _depsgraph, settings) -> "brittle.Sites":
    return _pattern(settings, mesh)


def _in_box(mesh, points) -> np.ndarray:
    """Points as shares of the sides of the mesh's box."""
    low, high = mesh.bounds
    return (np.asarray(points) - low) / np.maximum(high - low, 1e-30)


def _from_empty(_thing, mesh, _depsgraph, settings) -> "brittle.Sites":
    empty = settings.empty
    if empty is None:
        raise SourceError("Choose an empty: its children are the sites; without children, cells are small near it")
    if empty.children:
        return brittle.Sites([matrix_of(child)[:3, 3] for child in empty.children])
    reach = 2.0 * empty.empty_display_size * float(np.mean(empty.matrix_world.to_scale()))
    diagonal = float(np.linalg.norm(np.diff(mesh.bounds, axis=0)))
    focus = np.clip(_in_box(mesh, matrix_of(empty)[:3, 3]), 0.0, 1.0)
    return _pattern(settings, mesh, pattern="clustered", focus=focus, spread=min(max(reach / diagonal, 0.01), 1.0))


def _from_particles(thing, _mesh, depsgraph, settings) -> "brittle.Sites":
    systems = thing.evaluated_get(depsgraph).particle_systems
    if not systems:
        raise SourceError(f"{thing.name} has no particle system; add one in the properties of the object")
    system = systems[min(thing.particle_systems.active_index, len(systems) - 1)]
    if len(system.particles) == 0:
        raise SourceError(f"{system.name} has no particles in this frame; choose another frame or emit some")
    return brittle.Sites(gather(system.particles, "location", 3)[:settings.count])


def _strokes(pencil: bpy.types.Object):
    """The points of all strokes in the current frames of the layers, (n, 3) each, in the coordinates of the object."""
    for layer in pencil.data.layers:
        frame = layer.active_frame if hasattr(layer, "active_frame") else layer.current_frame()  # before and from 4.3
        for stroke in () if frame is None else getattr(frame, "strokes", None) or frame.drawing.strokes:
            yield np.array([tuple(getattr(point, "co", None) or point.position) for point in stroke.points])


def _from_stroke(_thing, mesh, _depsgraph, settings) -> "brittle.Sites":
    strokes = [] if settings.stroke is None else [points for points in _strokes(settings.stroke) if len(points) > 1]
    if not strokes:
        raise SourceError("Choose a grease pencil object with a stroke: cells are small along it")
    matrix = matrix_of(settings.stroke)
    line = np.concatenate(strokes) @ matrix[:3, :3].T + matrix[:3, 3]
    line = line[np.linspace(0, len(line) - 1, min(len(line), 200)).astype(int)]
    return _pattern(settings, mesh, pattern="curve", line=np.clip(_in_box(mesh, line), 0.0, 1.0))


_CANDIDATES = 20  #: for each site


def _from_weights(thing, mesh, _depsgraph, settings) -> "brittle.Sites":
    group = thing.vertex_groups.active
    if group is None:
        raise SourceError(f"{thing.name} has no vertex group; paint weights, and cells are small where they are high")
    weights = np.zeros(len(thing.data.vertices))
    for vertex in thing.data.vertices:
        for element in vertex.groups:
            if element.group == group.index:
                weights[vertex.index] = element.weight
    if not weights.any():
        raise SourceError(f"All weights of {group.name} are zero; paint some")
    matrix = matrix_of(thing)
    points = gather(thing.data.vertices, "co", 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
    tree = kdtree.KDTree(len(points))
    for index, point in enumerate(points):
        tree.insert(point, index)
    tree.balance()
    candidates = brittle.make_sites(mesh, _CANDIDATES * settings.count, seed=settings.seed).positions
    density = np.array([weights[tree.find(point)[1]] for point in candidates]) + 1e-3  # a few cells everywhere
    chosen = np.random.default_rng(settings.seed).choice(len(candidates), min(settings.count, len(candidates)),
                                                         replace=False, p=density / density.sum())
    return brittle.Sites(candidates[np.sort(chosen)])


SOURCES = {"PATTERN": _from_pattern, "EMPTY": _from_empty, "PARTICLES": _from_particles, "STROKE": _from_stroke,
           "WEIGHTS": _from_weights}
