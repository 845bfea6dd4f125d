"""Pieces as Blender objects."""
from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from .engine import brittle
from .layers import Layers


def _interior_material(thing: bpy.types.Object) -> bpy.types.Material:
    """The material of the cuts: the one that is set, else one in the colour of the stuff."""
    settings = thing.brittle
    if settings.interior is None:
        stuff = None if settings.material == "NONE" else brittle.material(settings.material.lower())
        name = "Fracture" if stuff is None else f"Fracture {stuff.name}"
        found = bpy.data.materials.get(name)
        if found is None:
            found = bpy.data.materials.new(name)
            colour = (0.35, 0.3, 0.27) if stuff is None else stuff.interior
            found.diffuse_color = (*colour, 1.0)
            found.use_nodes = True
            shader = next(node for node in found.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
            shader.inputs["Base Color"].default_value = (*colour, 1.0)
            shader.inputs["Roughness"].default_value = 0.9
        settings.interior = found
    return settings.interior


def _rows_of(faces: np.ndarray, of: np.ndarray) -> np.ndarray:
    """The row of each of `faces` in `of`, which has the same faces in another order. No two have the same corners."""
    rows = np.empty(len(faces), np.intp)
    rows[np.lexsort(np.sort(faces, axis=1).T)] = np.lexsort(np.sort(of, axis=1).T)
    return rows


def _add_layers(mesh: bpy.types.Mesh, piece: "brittle.Piece", corners: np.ndarray, uv: np.ndarray,
                layers: Layers) -> None:
    """Adds the layers of the object. uv: from the core, its active texture coordinates and those of cuts."""
    outside, weights = np.zeros(len(corners), bool), None
    uv_names, colour_names = {}, {}  # Blender's names of the layers
    if layers.follow and (layers.colours or len(layers.uv) > 1):
        rows = _rows_of(corners, piece.faces)
        outside = rows < piece.exterior_faces
        sources = piece.face_sources[rows[outside]]
        weights = layers.weights(sources, piece.vertices[corners[outside]])
    for layer in layers.uv:
        values = uv.copy()
        if not layer.active:
            if weights is None:
                continue
            values[outside] = layers.at(layer, sources, weights)
        added = mesh.uv_layers.new(name=layer.name, do_init=False)
        added.data.foreach_set("uv", values.astype(np.float32).ravel())
        uv_names[added.name] = layer  # references to layers end with the next new one
    for layer in layers.colours if weights is not None else ():
        values = np.ones((len(corners), 3, 4), np.float32)
        values[outside] = layers.at(layer, sources, weights)
        added = mesh.color_attributes.new(layer.name, layer.kind, "CORNER")
        added.data.foreach_set("color", values.ravel())
        colour_names[added.name] = layer
    for name, layer in uv_names.items():
        if layer.active:
            mesh.uv_layers[name].active = True
        if layer.rendered:
            mesh.uv_layers[name].active_render = True
    for k, added in enumerate(mesh.color_attributes):
        if colour_names[added.name].active:
            mesh.color_attributes.active_color_index = k
        if colour_names[added.name].rendered:
            mesh.color_attributes.render_color_index = k


def _mesh_data(name: str, piece: "brittle.Piece", slots: int, layers: Layers, rough: bool) -> bpy.types.Mesh:
    """The mesh of a piece around its centre of mass; material slot `slots` is that of the cuts."""
    parts = piece.surface()
    corners = np.concatenate([part.vertices[part.faces] for part in parts])
    normals = np.concatenate([part.normals[part.faces] for part in parts]).reshape(-1, 3)
    uv = np.concatenate([(part.uv if len(part.uv) else np.zeros((len(part.vertices), 2), np.float32))[part.faces]
                         for part in parts]) * [1, -1] + [0, 1]  # v points down there
    slot = np.concatenate([np.full(len(part.faces), slots if part.interior else min(part.material or 0, slots - 1))
                           for part in parts])
    smooth = np.concatenate([np.full(len(part.faces), rough or not part.interior) for part in parts])

    mesh = bpy.data.meshes.new(name)
    vertices = (piece.vertices - piece.center_mass).astype(np.float32)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.ravel())
    mesh.loops.add(3 * len(corners))
    mesh.loops.foreach_set("vertex_index", corners.astype(np.int32).ravel())
    mesh.polygons.add(len(corners))
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * len(corners), 3, dtype=np.int32))
    if bpy.app.version < (4, 0, 0):  # later versions find it out
        mesh.polygons.foreach_set("loop_total", np.full(len(corners), 3, np.int32))
    mesh.polygons.foreach_set("material_index", slot.astype(np.int32))
    mesh.polygons.foreach_set("use_smooth", smooth)
    _add_layers(mesh, piece, corners, uv, layers)
    mesh.update(calc_edges=True)
    mesh.normals_split_custom_set(normals)
    if bpy.app.version < (4, 1, 0):  # later versions always use these normals
        mesh.use_auto_smooth = True
    return mesh


def build(thing: bpy.types.Object, broken: "brittle.Fracture",
          layers: Layers) -> tuple[bpy.types.Collection, list[bpy.types.Object]]:
    """Makes a collection of an object for each piece, below an empty, and hides the whole. Origins are centres of mass.

    Returns the collection and the objects in the order of the pieces.
    """
    collection = bpy.data.collections.new(f"{thing.name} pieces")
    (thing.users_collection or (bpy.context.scene.collection,))[0].children.link(collection)
    root = bpy.data.objects.new(f"{thing.name} fractured", None)
    root.location = thing.matrix_world.translation
    root.empty_display_size = 0.1 * max(thing.dimensions)
    collection.objects.link(root)
    back = Matrix.Translation(-root.location)  # the empty has no world matrix yet

    materials = [slot.material for slot in thing.material_slots] or [None]
    interior = _interior_material(thing)
    rough = thing.brittle.roughness_of_cuts() > 0.0
    objects = []
    digits = len(str(max(len(broken.pieces) - 1, 0)))
    for piece in broken.pieces:
        name = f"{thing.name}_{piece.index:0{digits}}"
        mesh = _mesh_data(name, piece, len(materials), layers, rough)
        for material in (*materials, interior):
            mesh.materials.append(material)
        part = bpy.data.objects.new(name, mesh)
        part.location = piece.center_mass
        part.parent, part.matrix_parent_inverse = root, back
        part["volume"] = piece.volume  # m^3
        collection.objects.link(part)
        objects.append(part)
    thing.hide_set(True)
    thing.hide_render = True
    return collection, objects
