"""Tests of the Blender add-on, inside Blender: tools/test-blender installs it into a fresh profile and runs them.

    blender --background --python test_addon.py -- OUTPUT_FOLDER
"""
import contextlib
import io
import pathlib
import re
import subprocess
import sys
import unittest

import bpy
import numpy as np
from mathutils import Matrix, Vector

OUTPUT = pathlib.Path(sys.argv[sys.argv.index("--") + 1])
BUNNY = "/usr/share/glmark2/models/bunny.obj"
ROOT = pathlib.Path(__file__).resolve().parents[2]


def vertices_of(thing) -> np.ndarray:
    values = np.empty(3 * len(thing.data.vertices), np.float32)
    thing.data.vertices.foreach_get("co", values)
    return values.reshape(-1, 3).astype(float)


def faces_of(thing) -> np.ndarray:
    return np.array([polygon.vertices[:] for polygon in thing.data.polygons])


def is_closed(thing) -> bool:
    edges = [(a, b) for f in faces_of(thing) for a, b in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0]))]
    return len(set(edges)) == len(edges) and set(edges) == {(b, a) for a, b in edges}


def volume(thing) -> float:
    a, b, c = (vertices_of(thing)[faces_of(thing)[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def pieces_of(name: str) -> list:
    return [thing for thing in bpy.data.collections[f"{name} pieces"].objects if thing.type == "MESH"]


class AddonTest(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_homefile(use_factory_startup=False, use_empty=True)
        bpy.context.view_layer.update()

    def add(self, shape: str, **options):
        getattr(bpy.ops.mesh, f"primitive_{shape}_add")(**options)
        return bpy.context.object

    def fracture(self, thing, **settings) -> list:
        for name, value in settings.items():
            setattr(thing.brittle, name, value)
        bpy.context.view_layer.objects.active = thing
        self.assertEqual(bpy.ops.brittle.fracture(), {"FINISHED"})
        return pieces_of(thing.name)

    def test_pieces_are_closed_and_fill_the_object(self):
        ball = self.add("ico_sphere", subdivisions=3, location=(3, -1, 2))
        whole = volume(ball)
        pieces = self.fracture(ball, count=15, material="NONE")
        self.assertEqual(len(pieces), 15)
        self.assertTrue(all(is_closed(piece) for piece in pieces))
        self.assertAlmostEqual(sum(volume(piece) for piece in pieces), whole, delta=1e-5 * whole)
        self.assertTrue(ball.hide_get() and ball.hide_render)
        for piece in pieces:
            self.assertEqual(piece.parent.name, "Icosphere fractured")
            self.assertAlmostEqual(volume(piece), piece["volume"], delta=1e-5 * whole)
            at = piece.matrix_world.translation  # the origin is the centre of mass, in the place of the object
            self.assertLess((at - ball.location).length, 1.0)
            corners, faces = vertices_of(piece), faces_of(piece)
            a, b, c = (corners[faces[:, k]] for k in range(3))
            weights = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
            centre = (weights[:, None] * (a + b + c) / 4).sum(axis=0) / weights.sum()
            self.assertLess(np.linalg.norm(centre), 1e-5)

    def test_hash_is_that_of_the_command_line(self):
        from brittle_fracture import fracture
        from brittle_fracture.engine import brittle

        def command_hash(path) -> str:
            printed = subprocess.run([ROOT / "build/release/bin/brittle", "fracture", path, "-n", "100", "--seed", "1",
                                      "-o", OUTPUT / "pieces.ply"], check=True, capture_output=True, text=True).stdout
            return re.search(r"^ *hash +(\w+)", printed, re.MULTILINE)[1]

        self.assertEqual(brittle.fracture(brittle.load(BUNNY), 100, seed=1).hash, command_hash(BUNNY))
        # Blender's own import rounds to single precision, so its mesh is compared as a file of its own.
        bpy.ops.import_scene.obj(filepath=BUNNY, axis_forward="Y", axis_up="Z")
        bunny = bpy.context.selected_objects[0]
        bunny.brittle.material, bunny.brittle.count = "NONE", 100
        depsgraph = bpy.context.evaluated_depsgraph_get()
        fracture.solid_of(bunny, depsgraph)[0].export(OUTPUT / "bunny.ply")
        self.assertEqual(fracture.plan(bunny, depsgraph).work().hash, command_hash(OUTPUT / "bunny.ply"))

    def test_transforms(self):
        cube = self.add("cube", size=1)
        # Turned, mirrored and scaled along an axis.
        cube.matrix_world = Matrix.Translation((1, 2, 3)) @ Matrix.Rotation(0.7, 4, (1, 2, 3)) \
            @ Matrix.Diagonal((2, -1, 0.5, 1))
        bpy.context.view_layer.update()
        pieces = self.fracture(cube, count=9, material="NONE")
        self.assertTrue(all(is_closed(piece) and volume(piece) > 0 for piece in pieces))
        self.assertAlmostEqual(sum(volume(piece) for piece in pieces), 1.0, delta=1e-5)
        corners = [cube.matrix_world @ Vector(corner) for corner in cube.bound_box]
        points = np.concatenate([vertices_of(piece) + np.array(piece.matrix_world.translation) for piece in pieces])
        for corner in corners:
            self.assertLess(np.linalg.norm(points - np.array(corner), axis=1).min(), 1e-5)

    def test_modifiers_curves_and_text(self):
        cube = self.add("cube", size=2)
        cube.modifiers.new("Subdivision", "SUBSURF").levels = 2
        pieces = self.fracture(cube, count=5, material="NONE")
        self.assertLess(sum(volume(piece) for piece in pieces), 7.0)  # rounder than the cube
        bpy.ops.object.text_add()
        bpy.context.object.data.body = "Ab"
        bpy.context.object.data.extrude = 0.2
        pieces = self.fracture(bpy.context.object, count=8, material="NONE")
        self.assertTrue(len(pieces) >= 8 and all(is_closed(piece) for piece in pieces))

    def test_attributes_are_kept(self):
        cube = self.add("cube", size=2)
        for name in ("red", "blue"):
            cube.data.materials.append(bpy.data.materials.new(name))
        for polygon in cube.data.polygons:
            polygon.material_index = 1 if polygon.normal.z > 0.5 else 0
            polygon.use_smooth = True
        layer = cube.data.uv_layers.active.data
        for loop in cube.data.loops:  # texture coordinates from positions, so that they can be checked anywhere
            x, y, z = cube.data.vertices[loop.vertex_index].co
            layer[loop.index].uv = (0.2 * x + 0.05 * z, 0.3 * y - 0.07 * z)
        pieces = self.fracture(cube, count=10, material="GLASS", use_roughness=True, roughness=0.0)
        checked, normals_of_cuts = 0, 0
        for piece in pieces:
            names = [material.name for material in piece.data.materials]
            self.assertEqual(names, ["red", "blue", "Fracture glass"])
            piece.data.calc_normals_split()  # moves the other layers
            at, uv = piece.matrix_world.translation, piece.data.uv_layers.active.data
            for polygon in piece.data.polygons:
                middle = np.array(polygon.center + at)
                outside = np.abs(middle).max() > 1 - 1e-5
                self.assertEqual(polygon.material_index == 2, not outside)
                if not outside:
                    self.assertFalse(polygon.use_smooth)
                    for k in polygon.loop_indices:
                        normals_of_cuts += 1
                        self.assertGreater(piece.data.loops[k].normal.dot(polygon.normal), 0.999)
                    continue
                self.assertEqual(polygon.material_index, 1 if middle[2] > 1 - 1e-5 else 0)
                self.assertTrue(polygon.use_smooth)
                for k in polygon.loop_indices:
                    x, y, z = piece.data.vertices[piece.data.loops[k].vertex_index].co + at
                    self.assertLess((uv[k].uv - Vector((0.2 * x + 0.05 * z, 0.3 * y - 0.07 * z))).length, 1e-4)
                    # Smooth normals of a cube point from its middle, between its corners.
                    self.assertGreater(piece.data.loops[k].normal.dot(Vector((x, y, z)).normalized()), 0.8)
                    checked += 1
        self.assertGreater(checked, 100)
        self.assertGreater(normals_of_cuts, 100)

    def add_layers(self, cube):
        """Texture coordinates and colours that are linear in the place, so that they can be checked anywhere."""
        mesh = cube.data
        mesh.uv_layers[0].name = "Bark"
        moss = mesh.uv_layers.new(name="Moss")
        moss.active_render = True
        mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
        mesh.color_attributes.new("Mask", "BYTE_COLOR", "CORNER")
        names = [layer.name for layer in mesh.color_attributes]
        mesh.color_attributes.active_color_index = names.index("Mask")
        mesh.color_attributes.render_color_index = names.index("Paint")
        for name, layer in self.values_of_layers().items():
            for loop in mesh.loops:
                place = mesh.vertices[loop.vertex_index].co
                if name in mesh.uv_layers:
                    mesh.uv_layers[name].data[loop.index].uv = layer(place)
                else:
                    at = loop.vertex_index if name == "Paint" else loop.index
                    mesh.color_attributes[name].data[at].color = layer(place)

    def values_of_layers(self) -> dict:
        return {"Bark": lambda p: (0.2 * p.x + 0.05 * p.z, 0.3 * p.y - 0.07 * p.z),
                "Moss": lambda p: (0.1 * p.y, 0.4 * p.z + 0.02 * p.x),
                "Paint": lambda p: (0.5 + 0.2 * p.x, 0.5 - 0.1 * p.y, 0.4 + 0.3 * p.z, 1.0),
                "Mask": lambda p: (0.5 + 0.4 * p.z, 0.25, 0.5, 1.0)}

    def check_layers(self, piece) -> int:
        at, checked, mesh = piece.matrix_world.translation, 0, piece.data
        self.assertEqual([layer.name for layer in mesh.uv_layers], ["Bark", "Moss"])
        self.assertEqual(sorted(layer.name for layer in mesh.color_attributes), ["Mask", "Paint"])
        self.assertEqual(mesh.uv_layers.active.name, "Bark")
        self.assertTrue(mesh.uv_layers["Moss"].active_render)
        self.assertEqual(mesh.color_attributes.active_color.name, "Mask")
        self.assertEqual(mesh.color_attributes[mesh.color_attributes.render_color_index].name, "Paint")
        for polygon in mesh.polygons:
            outside = max(abs(x) for x in polygon.center + at) > 1 - 1e-5
            for k in polygon.loop_indices:
                for name, layer in self.values_of_layers().items():
                    colours = name not in mesh.uv_layers
                    got = (mesh.color_attributes[name].data[k].color if colours else mesh.uv_layers[name].data[k].uv)[:]
                    if not outside:
                        self.assertTrue(not colours or got == (1.0, 1.0, 1.0, 1.0))
                        continue
                    expected = layer(mesh.vertices[mesh.loops[k].vertex_index].co + at)
                    bound = 0.01 if name == "Mask" else 1e-5  # of a byte
                    self.assertLess(max(abs(a - b) for a, b in zip(got, expected)), bound, name)
                    checked += 1
        return checked

    def test_layers_of_texture_coordinates_and_colours(self):
        for roughness in (0.0, 0.3):
            cube = self.add("cube", size=2)
            self.add_layers(cube)
            pieces = self.fracture(cube, count=10, material="STONE", use_roughness=True, roughness=roughness,
                                   repair=roughness > 0.0)  # a repair that changes nothing keeps all layers
            self.assertGreater(sum(self.check_layers(piece) for piece in pieces), 400)

    def test_a_changed_mesh_keeps_the_active_layer(self):
        cube = self.add("cube", size=2)
        self.add_layers(cube)
        bpy.ops.mesh.primitive_cube_add(size=1, location=(1, 0, 0))
        cube.select_set(True)
        bpy.context.view_layer.objects.active = cube
        bpy.ops.object.join()
        pieces = self.fracture(cube, count=6, material="STONE", unite=True)
        for piece in pieces:
            self.assertEqual([layer.name for layer in piece.data.uv_layers], ["Bark"])
            self.assertTrue(is_closed(piece))

    def test_open_mesh_is_refused_with_a_reason_and_repaired(self):
        plane = self.add("grid", x_subdivisions=2, y_subdivisions=2)
        cube = self.add("cube", size=2)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        cube.data.polygons[0].select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.delete(type="FACE")
        bpy.ops.object.mode_set(mode="OBJECT")
        for thing in (plane, cube):
            bpy.context.view_layer.objects.active = thing
            with self.assertRaisesRegex(RuntimeError, "open edges"):
                bpy.ops.brittle.fracture()
            self.assertNotIn(f"{thing.name} pieces", bpy.data.collections)
        bpy.ops.brittle.check()
        self.assertEqual(cube.brittle.verdict, "Not a solid: 4 open edges")
        bpy.ops.brittle.repair()
        self.assertIn("Solid of 8 m", cube.brittle.verdict)
        self.assertAlmostEqual(sum(volume(piece) for piece in self.fracture(cube, count=4)), 8.0, delta=1e-4)

    def test_parts_that_cross_are_united(self):
        cube = self.add("cube", size=1)
        other = self.add("cube", size=1, location=(0.5, 0.5, 0.5))
        other.select_set(True)
        cube.select_set(True)
        bpy.context.view_layer.objects.active = cube
        bpy.ops.object.join()
        bpy.ops.brittle.check()
        self.assertIn("cross", cube.brittle.verdict)
        pieces = self.fracture(cube, count=6, material="NONE", unite=True)
        self.assertAlmostEqual(sum(volume(piece) for piece in pieces), 2 - 0.125, delta=1e-4)

    def test_sources_of_sites(self):
        ball = self.add("uv_sphere")
        empty = bpy.data.objects.new("sites", None)
        bpy.context.collection.objects.link(empty)
        for x in (-0.5, 0.0, 0.5):
            child = bpy.data.objects.new("site", None)
            child.location, child.parent = (x, 0, 0), empty
            bpy.context.collection.objects.link(child)
        bpy.context.view_layer.update()
        pieces = self.fracture(ball, source="EMPTY", empty=empty, material="NONE")
        centres = sorted(piece.matrix_world.translation.x for piece in pieces)
        self.assertEqual(len(pieces), 3)
        self.assertLess(centres[0], -0.25)
        self.assertAlmostEqual(centres[1], 0.0, places=4)
        from brittle_fracture import fracture
        from brittle_fracture.sites import sites_of

        def sites(**settings):
            for name, value in settings.items():
                setattr(ball.brittle, name, value)
            depsgraph = bpy.context.evaluated_depsgraph_get()
            return np.array(sites_of(ball, fracture.solid_of(ball, depsgraph)[0], depsgraph).positions)

        lone = bpy.data.objects.new("focus", None)
        lone.location, lone.empty_display_size = (0, 0, 0.9), 0.05
        bpy.context.collection.objects.link(lone)
        bpy.context.view_layer.update()
        self.assertGreater(np.median(sites(empty=lone, count=100)[:, 2]), 0.7)

        with self.assertRaisesRegex(Exception, "no particle system"):
            sites(source="PARTICLES")
        bpy.context.view_layer.objects.active = ball
        ball.hide_set(False)
        bpy.ops.object.particle_system_add()
        particles = ball.particle_systems.active.settings
        particles.count, particles.frame_end, particles.emit_from = 50, 1, "VOLUME"
        bpy.context.scene.frame_set(2)
        self.assertEqual(len(sites(count=40)), 40)
        self.assertTrue((np.linalg.norm(sites(count=40), axis=1) < 1.1).all())

        with self.assertRaisesRegex(Exception, "vertex group"):
            sites(source="WEIGHTS")
        group = ball.vertex_groups.new(name="weight")
        group.add([v.index for v in ball.data.vertices if v.co.x > 0.5], 1.0, "REPLACE")
        found = sites(source="WEIGHTS", count=60)
        self.assertEqual(len(found), 60)
        self.assertGreater((found[:, 0] > 0.2).mean(), 0.9)
        self.assertTrue(np.array_equal(found, sites(source="WEIGHTS", count=60)))

        with self.assertRaisesRegex(Exception, "grease pencil"):
            sites(source="STROKE")
        pencil = bpy.data.grease_pencils.new("pencil")
        stroke = pencil.layers.new("crack").frames.new(1).strokes.new()
        stroke.points.add(12)
        for k, point in enumerate(stroke.points):
            point.co = (-1 + 2 * k / 11, 0.1, 0.2)
        drawing = bpy.data.objects.new("pencil", pencil)
        bpy.context.collection.objects.link(drawing)
        bpy.context.view_layer.update()
        found = sites(source="STROKE", stroke=drawing, count=200)
        away = np.linalg.norm(found[:, 1:] - [0.1, 0.2], axis=1)
        self.assertLess(np.median(away), 0.25)

    def test_rigid_bodies_fall_and_bonds_hold(self):
        self.add("plane", size=20)
        bpy.ops.rigidbody.object_add(type="PASSIVE")
        wall = self.add("cube", size=1, location=(0, 0, 0.5))
        pieces = self.fracture(wall, count=8, material="STONE", bonds=True)
        masses = sum(piece.rigid_body.mass for piece in pieces)
        self.assertAlmostEqual(masses, 2600.0, delta=1.0)
        scene = bpy.context.scene
        holders = scene.rigidbody_world.constraints.objects
        self.assertGreater(len(holders), 8)
        for holder in holders:
            bond = holder.rigid_body_constraint
            self.assertTrue(bond.use_breaking and bond.object1 in pieces and bond.object2 in pieces)
            self.assertGreater(bond.breaking_threshold, 0.0)
        before = {piece.name: piece.matrix_world.translation.copy() for piece in pieces}

        def play(frames):
            for frame in range(1, frames + 1):
                scene.frame_set(frame)
            depsgraph = bpy.context.evaluated_depsgraph_get()
            return {piece.name: piece.evaluated_get(depsgraph).matrix_world.translation.copy() for piece in pieces}

        after = play(25)
        self.assertLess(max((after[name] - at).length for name, at in before.items()), 0.01)  # no motion at birth
        ball = self.add("uv_sphere", radius=0.4, location=(4, 0, 0.6))
        bpy.ops.rigidbody.object_add(type="ACTIVE")
        ball.rigid_body.mass = 5000
        ball.rigid_body.kinematic = True
        ball.keyframe_insert("location", frame=1)
        ball.location.x = -4
        ball.keyframe_insert("location", frame=12)
        scene.frame_set(1)
        bpy.ops.ptcache.free_bake_all()
        after = play(25)
        self.assertGreater(max((after[name] - at).length for name, at in before.items()), 0.5)

    def test_equal_settings_give_equal_pieces_and_another_seed_others(self):
        hashes = []
        from brittle_fracture import fracture
        cube = self.add("cube")
        for seed in (1, 1, 2):
            cube.brittle.seed = seed
            hashes.append(fracture.plan(cube, bpy.context.evaluated_depsgraph_get()).work().hash)
        self.assertEqual(hashes[0], hashes[1])
        self.assertNotEqual(hashes[0], hashes[2])

    def test_preview_draws_the_edges_of_the_cells(self):
        from brittle_fracture import preview
        from brittle_fracture.engine import brittle
        lines = preview.cracks(brittle.fracture(brittle.box((1, 1, 1)), [[-0.25, 0, 0], [0.25, 0, 0]]))
        lengths = np.linalg.norm(lines[0::2] - lines[1::2], axis=1)
        self.assertAlmostEqual(lengths.sum(), 2 * 4.0, places=5)  # the square of the cut, from both sides
        self.assertTrue((lines[:, 0] == 0).all())
        cube = self.add("cube")
        cube.brittle.preview = True
        preview.refresh()
        self.assertEqual(preview.fault_of(cube), "")
        cube.brittle.source = "PARTICLES"
        preview.refresh()
        self.assertIn("particle system", preview.fault_of(cube))
        cube.brittle.preview = False

    def test_undo(self):
        cube = self.add("cube")
        bpy.ops.ed.undo_push(message="cube")
        self.fracture(cube, count=4)
        bpy.ops.ed.undo_push(message="fracture")
        bpy.ops.ed.undo()
        self.assertNotIn("Cube pieces", bpy.data.collections)
        self.assertFalse(bpy.data.objects["Cube"].hide_render)

    def test_example_of_the_documentation(self):
        page = (ROOT / "docs/bindings.md").read_text(encoding="utf-8")
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(re.search(r"^```blender\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)[1], {})
        self.assertRegex(printed.getvalue(), r"(?m)^3\d pieces$")

    def test_picture(self):
        """Renders OUTPUT/pieces.png, to be looked at."""
        scene = bpy.context.scene
        monkey = self.add("monkey", size=2)
        monkey.modifiers.new("Subdivision", "SUBSURF").levels = 2
        bpy.ops.object.shade_smooth()
        green = bpy.data.materials.new("green")
        green.use_nodes = True
        green.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.1, 0.4, 0.25, 1)
        monkey.data.materials.append(green)
        for piece in self.fracture(monkey, count=30, material="STONE", repair=True, unite=True):
            piece.location += 0.3 * piece.matrix_world.translation
        bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.2, 0.5))
        bpy.context.object.data.energy = 4
        bpy.ops.object.camera_add(location=(2.6, -5.2, 1.6), rotation=(1.32, 0, 0.46))
        scene.camera = bpy.context.object
        world = bpy.data.worlds.new("sky")
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.6, 0.65, 0.7, 1)
        scene.world = world
        scene.render.engine = "CYCLES"
        scene.cycles.samples, scene.cycles.use_denoising = 24, False
        scene.render.resolution_x, scene.render.resolution_y = 640, 480
        scene.render.resolution_percentage = 100
        scene.render.filepath = str(OUTPUT / "pieces.png")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.array(image.pixels[:]).reshape(-1, 4)[:, :3]
        green, brown = pixels[:, 1] > 1.3 * pixels[:, 0], pixels[:, 0] > 1.15 * pixels[:, 2]
        self.assertGreater(green.mean(), 0.05)  # the outside
        self.assertGreater(brown.mean(), 0.02)  # cuts in the colour of broken stone


if __name__ == "__main__":
    report = io.StringIO()
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(AddonTest)
    result = unittest.TextTestRunner(stream=report, verbosity=2).run(suite)
    print(report.getvalue())
    print(f"add-on: {result.testsRun} tests, {len(result.failures) + len(result.errors)} failed")
    sys.exit(0 if result.wasSuccessful() else 1)
