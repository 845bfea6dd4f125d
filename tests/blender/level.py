"""Makes a level of 200 objects in Blender and exports it as glTF: tools/test-blender opens, plays and replays it.

    blender --background --factory-startup --python level.py -- LEVEL.glb

Instances share a mesh, parents are scaled unevenly and mirrored, and materials, names and custom properties say what
things are: level.json holds the rules.
"""
import math
import sys

import bmesh
import bpy
from mathutils import Matrix

output = sys.argv[sys.argv.index("--") + 1]
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene


def material(name):
    return bpy.data.materials.get(name) or bpy.data.materials.new(name)


def box(name, size, stuff):
    mesh = bpy.data.meshes.new(name)
    shape = bmesh.new()
    bmesh.ops.create_cube(shape, size=1.0, matrix=Matrix.Diagonal((*size, 1.0)))
    shape.to_mesh(mesh)
    shape.free()
    mesh.materials.append(material(stuff))
    return mesh


def vase(name, stuff):
    """A closed surface of revolution: the outside up, over the rim, and the inside down."""
    profile = [(0.0, 0.0), (0.06, 0.0), (0.1, 0.1), (0.05, 0.2), (0.07, 0.25), (0.06, 0.25), (0.04, 0.2), (0.08, 0.1),
               (0.05, 0.02), (0.0, 0.02)]
    segments = 24
    mesh = bpy.data.meshes.new(name)
    shape = bmesh.new()
    rings = []
    for radius, z in profile:
        count = 1 if radius == 0.0 else segments
        rings.append([shape.verts.new((radius * math.cos(2 * math.pi * k / count), radius * math.sin(2 * math.pi * k / count),
                                       z)) for k in range(count)])
    for low, high in zip(rings, rings[1:]):
        for k in range(segments):
            corners = [low[k % len(low)], low[(k + 1) % len(low)], high[(k + 1) % len(high)], high[k % len(high)]]
            shape.faces.new(list(dict.fromkeys(corners)))
    shape.to_mesh(mesh)
    shape.free()
    mesh.materials.append(material(stuff))
    return mesh


def add(name, mesh, place, parent=None, turn=0.0):
    thing = bpy.data.objects.new(name, mesh)
    thing.location, thing.rotation_euler.z, thing.parent = place, turn, parent
    scene.collection.objects.link(thing)
    return thing


add("Floor", box("floor", (12, 12, 0.2), "Concrete"), (0, 0, -0.1))
for k in range(4):
    add(f"Wall.{k:03}", box(f"wall {k}", (5.8, 0.2, 2.4), "Brick red"), (*[(0, 6), (6, 0), (0, -6), (-6, 0)][k], 1.2), None,
        k * math.pi / 2)
# Shelves: below a parent that is scaled unevenly and turned, so that the boards' own turns shear.
rack = bpy.data.objects.new("Rack", None)
rack.scale, rack.rotation_euler.z = (1.3, 0.8, 1.0), 0.3
scene.collection.objects.link(rack)
board, pot = box("board", (2.0, 0.4, 0.04), "Oak"), vase("pot", "Clay")
for k in range(10):
    x, y = 3.0 * (k % 5) - 6.0, 2.5 * (k // 5) - 1.0
    add(f"Board.{k:03}", board, (x * 0.6, y, 0.4), rack, 0.2 * (k % 3))
for k in range(2):  # legs, in the plane of the boards
    add(f"Post.{k:03}", box(f"post {k}", (7.5, 0.3, 0.36), "Concrete"), (0.0, -0.8 + 2.5 * k, 0.19), rack)
# Vases on the floor, instances of one mesh; every fifth one mirrored.
for k in range(120):
    thing = add(f"Vase.{k:03}", pot, (-4.5 + 0.75 * (k % 12), -4.5 + 0.55 * (k // 12), 0.001), None, 0.3 * k)
    if k % 5 == 0:
        thing.scale.x = -1.0
crate = box("crate", (0.3, 0.3, 0.3), "Oak")
for k in range(55):
    add(f"Crate.{k:03}", crate, (-4.2 + 0.85 * (k % 11), 1.6 + 0.8 * (k // 11), 0.151))
for k in range(6):
    pane = add(f"Pane.{k:03}", box(f"pane {k}", (0.9, 0.02, 1.0), "Glass"), (-3.0 + 1.2 * k, 5.2, 0.5))
    pane["brittle"] = '{"material": "glass", "anchored": true}'
add("Statue", box("statue", (0.4, 0.4, 1.2), "Marble"), (4.5, -4.5, 0.6))["kind"] = "landmark"
sheet = bpy.data.meshes.new("sheet")  # an open mesh, which a rule wants to break: it stays fixed, with a note
sheet.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
add("Vase of paper", sheet, (5, 5, 2))
bpy.ops.object.light_add(type="SUN")
bpy.ops.object.camera_add()

meshes = sum(thing.type == "MESH" for thing in scene.objects)
assert meshes == 200, meshes
bpy.ops.export_scene.gltf(filepath=output, export_extras=True, export_cameras=True, export_lights=True)
