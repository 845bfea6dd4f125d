"""Cell Fracture, which Blender ships, for tools/compare. Its points are the vertices of a child of the mesh.

It adds noise of 0.001 units to its cells and merges their vertices within 0.005 units. So everything is enlarged until
the mesh is 1,000 units long.

    blender --background --factory-startup --python blender.py -- MESH SITES CELLS THREADS
"""
import struct
import sys
import time

import bmesh
import bpy


UNITS = 1000.0


def say(line):
    print(line, flush=True)


def new_object(name, points, triangles):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], triangles)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(thing)
    return thing


def read_mesh(name):
    data = open(name, "rb").read()
    _, vertices, triangles = struct.unpack_from("<III", data)
    points = struct.iter_unpack("<ddd", data[12:12 + 24 * vertices])
    corners = struct.iter_unpack("<III", data[12 + 24 * vertices:12 + 24 * vertices + 12 * triangles])
    return list(points), list(corners)


def write_parts(name, things, factor):
    with open(name, "wb") as out:
        out.write(struct.pack("<I", len(things)))
        for thing in things:
            surface = bmesh.new()
            surface.from_mesh(thing.data)
            bmesh.ops.triangulate(surface, faces=surface.faces)
            surface.verts.index_update()
            out.write(struct.pack("<II", len(surface.verts), len(surface.faces)))
            for vertex in surface.verts:
                out.write(struct.pack("<ddd", *(x / factor for x in thing.matrix_world @ vertex.co)))
            for face in surface.faces:
                out.write(struct.pack("<III", *(vertex.index for vertex in face.verts)))
            surface.free()


def run(source, made):
    for thing in made:
        bpy.data.meshes.remove(thing.data)
    bpy.ops.object.select_all(action="DESELECT")
    source.select_set(True)
    bpy.context.view_layer.objects.active = source
    before = set(bpy.data.objects)
    begin = time.perf_counter()
    bpy.ops.object.add_fracture_cell_objects(source={"VERT_CHILD"}, source_limit=0, source_noise=0.0, recursion=0,
                                             margin=0.0,
                                             use_recenter=False, use_island_split=True)
    milliseconds = 1e3 * (time.perf_counter() - begin)
    pieces = [thing for thing in bpy.data.objects if thing not in before and thing.type == "MESH"]
    say(f"done {milliseconds} {len(pieces)}")
    return pieces


def main():
    mesh, sites, _, threads = sys.argv[sys.argv.index("--") + 1:][:4]
    bpy.context.scene.render.threads_mode = "FIXED"
    bpy.context.scene.render.threads = int(threads)
    bpy.ops.preferences.addon_enable(module="object_fracture_cell")
    bpy.ops.object.select_all(action="SELECT")
    bpy.ops.object.delete()
    points, triangles = read_mesh(mesh)
    factor = UNITS / max(max(p[k] for p in points) - min(p[k] for p in points) for k in range(3))
    enlarged = [tuple(factor * x for x in point) for point in points]
    source = new_object("solid", enlarged, triangles)
    places = [tuple(factor * float(x) for x in line.split()) for line in open(sites, encoding="ascii")]
    points = new_object("sites", places, [])
    points.parent = source
    bpy.context.view_layer.update()
    say("ready Blender " + bpy.app.version_string + ", Cell Fracture")
    made = []
    for line in sys.stdin:
        try:
            if line == "run\n":
                made = run(source, made)
            elif line.startswith("write "):
                write_parts(line[6:-1], made, factor)
                say("written")
        except Exception as error:  # whatever Blender raises is a result
            say("failed " + str(error).replace("\n", " "))


main()
