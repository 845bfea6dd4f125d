# Imports GLB files of pieces into Blender and checks what a modeller would find there. Run by tools/check-blender:
#   blender --background --python tests/blender/check.py -- FILE.glb...
#
# Lines that begin with "check-blender: " are for people; Blender prints others besides.
import json
import re
import struct
import sys
import traceback

import bmesh
import bpy

VOLUME_TOLERANCE = 1e-4  # relative; positions are 32-bit floats
MOST_COMPLAINTS = 10  # shown a file


def edge_complaints(mesh, may_touch):
    """What is wrong with the surface, merged at equal positions, its volume, and edges where parts of it touch.

    may_touch: the file tells points at one position apart (_POINT), which Blender does not read. Merged parts then have
    edges with an even number of faces.
    """
    surface = bmesh.new()
    surface.from_mesh(mesh)
    # Not by remove_doubles: at distance 0 its search finds no pair, and at distances where it finds all (1e-7 of the
    # size) it also joins neighbours.
    first = {}
    doubles = {v: first[v.co[:]] for v in surface.verts if first.setdefault(v.co[:], v) is not v}
    bmesh.ops.weld_verts(surface, targetmap=doubles)
    rims = sum(1 for e in surface.edges if len(e.link_faces) < 2)
    many = [len(e.link_faces) for e in surface.edges if len(e.link_faces) > 2]
    touching = sum(1 for faces in many if may_touch and faces % 2 == 0)
    crowded = len(many) - touching
    turned = sum(1 for e in surface.edges if len(e.link_faces) == 2 and not e.is_contiguous)
    volume = surface.calc_volume(signed=True)
    surface.free()
    counts = ((rims, "edges with fewer than two faces"), (crowded, "edges with more than two faces"),
              (turned, "edges whose faces are turned opposite ways"))
    return [f"{count} {what}" for count, what in counts if count], volume, touching


def read_document(path):
    """The JSON of a GLB file."""
    with open(path, "rb") as file:
        head = file.read(20)
        return json.loads(file.read(struct.unpack_from("<I", head, 12)[0]))


def plain(name):
    """A name without the number that Blender adds to one that is taken."""
    return re.sub(r"\.\d{3}$", "", name)


def primitives_of(document, node):
    return document["meshes"][node["mesh"]]["primitives"]


def material_complaints(mesh, document, node):
    """The materials of each name have as many faces as their primitives have triangles."""
    wanted = {}
    for primitive in primitives_of(document, node):
        name = plain(document["materials"][primitive["material"]]["name"])
        wanted[name] = wanted.get(name, 0) + document["accessors"][primitive["indices"]]["count"] // 3
    slots = [plain(m.name) if m else "none" for m in mesh.materials]
    found = {name: 0 for name in slots}
    for polygon in mesh.polygons:
        found[slots[polygon.material_index]] += 1
    return [] if found == wanted else [f"faces by material are {found} instead of {wanted}"]


def image_complaints(document):
    """Each material with a base colour texture shows an image that Blender can decode."""
    complaints = []
    for json_material in document["materials"]:
        if "baseColorTexture" not in json_material.get("pbrMetallicRoughness", {}):
            continue
        material = bpy.data.materials.get(json_material["name"])
        if material is None:
            continue  # no piece uses it
        images = [node.image for node in material.node_tree.nodes if node.type == "TEX_IMAGE" and node.image]
        if not any(image.has_data or len(image.pixels) > 0 for image in images):
            complaints.append(f"material {material.name}: has no image, or one that cannot be decoded")
    return complaints


def sum_complaints(volumes, certificate):
    """All pieces together fill the mesh."""
    whole = certificate["volume_input"]
    return [] if abs(volumes - whole) <= VOLUME_TOLERANCE * whole else [
        f"all pieces together have the volume {volumes:.9g} instead of {whole:.9g}"]


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
    triangles = touching = 0
    volumes = worst = 0.0
    certificate = {}
    for thing in bpy.data.objects:
        own = thing["brittle"].to_dict() if "brittle" in thing else {}
        certificate = own.get("certificate", certificate)
        if "volume" not in own:
            continue
        found.add(thing.name)
        if thing.type != "MESH" or thing.name not in pieces:
            complaints.append(f"{thing.name}: is no mesh, or no piece of the file")
            continue
        triangles += len(thing.data.polygons)
        primitives = primitives_of(document, pieces[thing.name])
        wrong, volume, touches = edge_complaints(thing.data, any("_POINT" in p["attributes"] for p in primitives))
        touching += touches
        volumes += volume
        error = abs(volume - own["volume"]) / own["volume"]
        worst = max(worst, error)
        if not error <= VOLUME_TOLERANCE:
            wrong.append(f"volume {volume:.9g} instead of {own['volume']:.9g}")
        wrong += material_complaints(thing.data, document, pieces[thing.name])
        complaints += [f"{thing.name}: {what}" for what in wrong]
    complaints += [f"{name}: is not among the objects" for name in sorted(pieces.keys() - found)]
    if certificate and certificate["pieces"] != len(pieces):
        complaints.append(f"{len(pieces)} nodes for {certificate['pieces']} pieces")
    if certificate:
        complaints += sum_complaints(volumes, certificate)
    complaints += image_complaints(document)
    if not pieces:
        complaints.append("no node says its volume; only pieces are checked")
    touch = f", {touching} edges where parts of a piece touch" if touching else ""
    return complaints, f"{len(found)} pieces, {triangles} triangles, volumes off by {worst:.1e} at most{touch}"


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
