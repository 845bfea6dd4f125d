# Imports GLB files of pieces into Blender and checks what a modeller would find there. Run by tools/check-blender:
#   blender --background --python tests/blender/check.py -- FILE.glb...
#
# Lines that begin with "check-blender: " are for people; Blender prints others besides.
import json
import struct
import sys
import traceback

import bmesh
import bpy

VOLUME_TOLERANCE = 1e-4  # relative; positions are 32-bit floats
MOST_COMPLAINTS = 10  # shown a file


def edge_complaints(mesh):
    """What is wrong with the surface, merged at equal positions, and its volume."""
    surface = bmesh.new()
    surface.from_mesh(mesh)
    # Not by remove_doubles: at distance 0 its search finds no pair, and at distances where it finds all (1e-7 of the
    # size) it also joins neighbours.
    first = {}
    doubles = {v: first[v.co[:]] for v in surface.verts if first.setdefault(v.co[:], v) is not v}
    bmesh.ops.weld_verts(surface, targetmap=doubles)
    rims = sum(1 for e in surface.edges if len(e.link_faces) < 2)
    crowded = sum(1 for e in surface.edges if len(e.link_faces) > 2)
    turned = sum(1 for e in surface.edges if len(e.link_faces) == 2 and not e.is_contiguous)
    volume = surface.calc_volume(signed=True)
    surface.free()
    counts = ((rims, "edges with fewer than two faces"), (crowded, "edges with more than two faces"),
              (turned, "edges whose faces are turned opposite ways"))
    return [f"{count} {what}" for count, what in counts if count], volume


def read_document(path):
    """The JSON of a GLB file."""
    with open(path, "rb") as file:
        head = file.read(20)
        return json.loads(file.read(struct.unpack_from("<I", head, 12)[0]))


def material_complaints(mesh, document, node):
    """Each primitive's material has its slot, and as many faces as the primitive has triangles."""
    wanted = {}
    for primitive in document["meshes"][node["mesh"]]["primitives"]:
        name = document["materials"][primitive["material"]]["name"]
        wanted[name] = wanted.get(name, 0) + document["accessors"][primitive["indices"]]["count"] // 3
    slots = [m.name if m else "none" for m in mesh.materials]
    found = {name: 0 for name in slots}
    for polygon in mesh.polygons:
        found[slots[polygon.material_index]] += 1
    return [] if found == wanted else [f"faces by material are {found} instead of {wanted}"]


def check(path):
    """The complaints about a file, and a line that says what was found."""
    document = read_document(path)
    # Pieces are the nodes that say their volume; the root has the certificate.
    extras = {node["name"]: node.get("extras", {}).get("brittle", {}) for node in document["nodes"]}
    pieces = {node["name"]: node for node in document["nodes"] if "volume" in extras[node["name"]]}
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if bpy.ops.import_scene.gltf(filepath=path) != {"FINISHED"}:
        return ["Blender does not import it"], ""
    complaints = []
    found = set()
    triangles = 0
    worst = 0.0
    for thing in bpy.data.objects:
        own = thing["brittle"].to_dict() if "brittle" in thing else {}
        if "certificate" in own and own["certificate"]["pieces"] != len(pieces):
            complaints.append(f"{len(pieces)} nodes for {own['certificate']['pieces']} pieces")
        if "volume" not in own:
            continue
        found.add(thing.name)
        if thing.type != "MESH" or thing.name not in pieces:
            complaints.append(f"{thing.name}: is no mesh, or no piece of the file")
            continue
        triangles += len(thing.data.polygons)
        wrong, volume = edge_complaints(thing.data)
        error = abs(volume - own["volume"]) / own["volume"]
        worst = max(worst, error)
        if not error <= VOLUME_TOLERANCE:
            wrong.append(f"volume {volume:.9g} instead of {own['volume']:.9g}")
        wrong += material_complaints(thing.data, document, pieces[thing.name])
        complaints += [f"{thing.name}: {what}" for what in wrong]
    complaints += [f"{name}: is not among the objects" for name in sorted(pieces.keys() - found)]
    if not pieces:
        complaints.append("no node says its volume; only pieces are checked")
    return complaints, f"{len(found)} pieces, {triangles} triangles, volumes off by {worst:.1e} at most"


def what_of(error):
    """The last line that says what went wrong; Blender's errors hold a whole traceback."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and not line.startswith("Location:")]
    return lines[-1] if lines else "no reason given"


def main(paths):
    try:
        import numpy  # Blender's importer needs it, and Debian only recommends it
    except ImportError:
        print("check-blender: Blender has no numpy, which its importer needs: apt-get install python3-numpy")
        sys.exit(77)
    # Debian 12's importer is older than its numpy: it says np.bool, which numpy 1.24 has no longer.
    if "bool" not in vars(numpy):
        numpy.bool = bool
    bad = 0
    for path in paths:
        try:
            complaints, found = check(path)
        except Exception as error:  # of the importer, too
            traceback.print_exc()
            complaints, found = [f"{type(error).__name__}: {what_of(error)}"], ""
        if complaints:
            bad = 1
            print(f"check-blender: {path}: WRONG in {len(complaints)} ways; {found}")
            for complaint in complaints[:MOST_COMPLAINTS]:
                print(f"check-blender:     {complaint}")
        else:
            print(f"check-blender: {path}: good; {found}")
    sys.stdout.flush()
    sys.exit(bad)


main(sys.argv[sys.argv.index("--") + 1:])
