"""Blender's meshes as meshes of Brittle, in world coordinates."""
from __future__ import annotations

import bpy
import numpy as np

from .engine import brittle
from .layers import Layers, gather


def matrix_of(thing: bpy.types.Object) -> np.ndarray:
    """(4, 4): from the coordinates of the object to the world's."""
    return np.array(thing.matrix_world, dtype=np.float64)


def mesh_of(thing: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple["brittle.Mesh", Layers]:
    """The mesh of an object with its modifiers, normals, active texture coordinates and slots of materials; its layers.

    Raises brittle.BrittleError for a mesh without faces.
    """
    evaluated = thing.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    try:
        mesh.calc_loop_triangles()
        if bpy.app.version < (4, 1, 0):
            mesh.calc_normals_split()
        loops = gather(mesh.loop_triangles, "loops", 3, np.int32)
        corners = gather(mesh.loops, "vertex_index", 1, np.int32)[loops]
        materials = gather(mesh.loop_triangles, "material_index", 1, np.int32)
        matrix = matrix_of(thing)
        if np.linalg.det(matrix[:3, :3]) < 0:  # a mirror turns the faces inside out
            loops, corners = loops[:, ::-1], corners[:, ::-1]
        points = gather(mesh.vertices, "co", 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        if bpy.app.version < (4, 1, 0):
            normals = gather(mesh.loops, "normal", 3)
        else:
            normals = gather(mesh.corner_normals, "vector", 3)
        normals = normals @ np.linalg.inv(matrix[:3, :3])  # by the inverse transpose
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
        layers = Layers(mesh, loops, corners, points)
        uv = layers.active_uv
        solid = brittle.Mesh(points[corners].reshape(-1, 3), normals=normals[loops].reshape(-1, 3),
                             uv=None if uv is None else uv.values.reshape(-1, 2) * [1, -1] + [0, 1],  # v points down
                             materials=materials, weld=True)
        layers.follow = len(solid.faces) == len(loops)
        return solid, layers
    finally:
        evaluated.to_mesh_clear()
