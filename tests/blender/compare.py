"""Breaks the bunny by the add-on and by Cell Fracture, which Blender ships: time, pieces, open pieces, volume.

    blender --background --python compare.py -- PIECES...
"""
import sys
import time

import bmesh
import bpy


def measure(things):
    """Number of pieces, of those that are not closed, and their volume."""
    still_open, volume = 0, 0.0
    for thing in things:
        surface = bmesh.new()
        surface.from_mesh(thing.data)
        bmesh.ops.remove_doubles(surface, verts=surface.verts, dist=1e-7)
        bmesh.ops.triangulate(surface, faces=surface.faces)
        still_open += any(not edge.is_manifold for edge in surface.edges)
        volume += surface.calc_volume(signed=True)
        surface.free()
    return len(things), still_open, volume


def bunny():
    bpy.ops.wm.read_homefile(use_factory_startup=False, use_empty=True)
    bpy.ops.import_scene.obj(filepath="/usr/share/glmark2/models/bunny.obj", axis_forward="Y", axis_up="Z")
    thing = bpy.context.selected_objects[0]
    bpy.context.view_layer.objects.active = thing
    return thing


def cell_fracture(count):
    bunny()
    bpy.ops.preferences.addon_enable(module="object_fracture_cell")
    before = set(bpy.data.objects)
    begin = time.perf_counter()
    bpy.ops.object.add_fracture_cell_objects(source={"VERT_OWN"}, source_limit=count, source_noise=0.0, recursion=0,
                                             margin=0.0, use_recenter=True, use_island_split=False)
    seconds = time.perf_counter() - begin
    return seconds, [thing for thing in bpy.data.objects if thing not in before and thing.type == "MESH"]


def brittle(count):
    thing = bunny()
    thing.brittle.material, thing.brittle.count, thing.brittle.rigid_bodies = "NONE", count, False
    begin = time.perf_counter()
    bpy.ops.brittle.fracture()
    seconds = time.perf_counter() - begin
    return seconds, [part for part in bpy.data.collections[f"{thing.name} pieces"].objects if part.type == "MESH"]


counts = [int(text) for text in sys.argv[sys.argv.index("--") + 1:]]
_, open_before, whole = measure([bunny()])
print(f"compare: the bunny is {'open' if open_before else 'closed'} and has {whole:.6f} m^3")
for count in counts:
    for name, work in (("Brittle", brittle), ("Cell Fracture", cell_fracture)):
        seconds, things = work(count)
        pieces, still_open, volume = measure(things)
        print(f"compare: {count} cells by {name}: {seconds:.2f} s, {pieces} pieces, {still_open} open, "
              f"volume {100 * (volume / whole - 1):+.4f} %")
