"""Imports files of pieces other than GLB into Blender and prints for each file:
    FILE objects COUNT faces COUNT open COUNT volume CUBIC_METRES
open: edges without exactly two faces, of the meshes as the importers make them.
    blender --background --factory-startup --python closed.py -- FILE.obj FILE.ply FILE.stl...
"""
import sys

import bmesh
import bpy

for addon in ("io_mesh_ply", "io_mesh_stl"):
    bpy.ops.preferences.addon_enable(module=addon)
IMPORT = {"obj": bpy.ops.wm.obj_import, "ply": bpy.ops.import_mesh.ply, "stl": bpy.ops.import_mesh.stl}

for file in sys.argv[sys.argv.index("--") + 1:]:
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    IMPORT[file.rsplit(".", 1)[1]](filepath=file)
    faces = gaps = 0
    volume = 0.0
    for thing in bpy.data.objects:
        mesh = bmesh.new()
        mesh.from_mesh(thing.data)
        faces += len(mesh.faces)
        gaps += sum(len(edge.link_faces) != 2 for edge in mesh.edges)
        volume += mesh.calc_volume(signed=True)
        mesh.free()
    print(f"{file} objects {len(bpy.data.objects)} faces {faces} open {gaps} volume {volume:.6f}", flush=True)
