"""Makes compound rigid bodies of files with hulls for Unreal in Blender, without gravity, and prints for each file:
    FILE bodies COUNT hulls COUNT speed M/S
speed: of the fastest piece within its first half second. Pieces that lie in each other push each other away.
    blender --background --factory-startup --python birth.py -- FILE.glb...
"""
import sys

import bpy
import numpy

numpy.bool = bool  # which the importer of Blender 3.4 still asks for

FRAMES, RATE = 12, 24


def add_body(thing, shape):
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    bpy.ops.rigidbody.object_add(type="ACTIVE")
    thing.select_set(False)
    thing.rigid_body.collision_shape = shape
    thing.rigid_body.use_margin = True
    thing.rigid_body.collision_margin = 0.0


for file in sys.argv[sys.argv.index("--") + 1:]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=file)
    bpy.ops.rigidbody.world_add()
    scene = bpy.context.scene
    scene.gravity = (0, 0, 0)
    scene.render.fps = RATE
    bpy.ops.object.select_all(action="DESELECT")
    hulls = [thing for thing in scene.objects if thing.name.startswith("UCX_")]
    pieces = sorted({hull.parent for hull in hulls}, key=lambda piece: piece.name)
    for piece in pieces:
        add_body(piece, "COMPOUND")
    for hull in hulls:
        add_body(hull, "CONVEX_HULL")
    before, speed = None, 0.0
    for frame in range(1, FRAMES + 1):
        scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        now = [piece.evaluated_get(graph).matrix_world.translation.copy() for piece in pieces]
        if before:
            speed = max(speed, max((a - b).length for a, b in zip(now, before)) * RATE)
        before = now
    print(f"{file} bodies {len(pieces)} hulls {len(hulls)} speed {speed:.4f}", flush=True)
