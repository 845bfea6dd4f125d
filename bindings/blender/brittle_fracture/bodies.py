"""Rigid bodies of pieces, and constraints where they touch, which break at the strength of the material."""
from __future__ import annotations

import bpy

from .engine import brittle


def _collection(world: bpy.types.RigidBodyWorld, attribute: str, name: str) -> bpy.types.Collection:
    found = getattr(world, attribute)
    if found is None:
        found = bpy.data.collections.new(name)
        setattr(world, attribute, found)
    return found


def _world(scene: bpy.types.Scene) -> bpy.types.RigidBodyWorld:
    if scene.rigidbody_world is None:
        bpy.ops.rigidbody.world_add()
    return scene.rigidbody_world


def add_bodies(scene: bpy.types.Scene, objects: list[bpy.types.Object], broken: "brittle.Fracture",
               material: "brittle.Material") -> None:
    """Gives each piece a body with its mass and convex hull. The bodies sleep until something hits them."""
    bodies = _collection(_world(scene), "collection", "RigidBodyWorld")
    for thing, volume in zip(objects, broken.volumes):
        bodies.objects.link(thing)
        body = thing.rigid_body
        body.mass = max(float(volume) * material.density, 1e-3)  # the least that Blender takes, kg
        body.collision_shape = "CONVEX_HULL"
        body.friction, body.restitution = material.friction, material.restitution
        body.use_deactivation = body.use_start_deactivated = True


def add_bonds(scene: bpy.types.Scene, collection: bpy.types.Collection, objects: list[bpy.types.Object],
              broken: "brittle.Fracture", material: "brittle.Material", strength: float) -> list[bpy.types.Object]:
    """Holds each two pieces that touch together until the stress on their contact exceeds a share of the material's
    tensile strength. Returns the empties that carry the constraints."""
    world = _world(scene)
    constraints = _collection(world, "constraints", "RigidBodyConstraints")
    # Blender compares impulses of one substep.
    seconds = scene.render.fps_base / (scene.render.fps * world.substeps_per_frame)
    holders = []
    for (first, second), area, centre in zip(broken.bonds, broken.bond_areas, broken.bond_centroids):
        holder = bpy.data.objects.new(f"bond {objects[first].name} {objects[second].name}", None)
        holder.location = centre
        holder.empty_display_size = 0.2 * float(area) ** 0.5
        collection.objects.link(holder)
        constraints.objects.link(holder)
        bond = holder.rigid_body_constraint
        bond.type = "FIXED"
        bond.object1, bond.object2 = objects[first], objects[second]
        bond.use_breaking = True
        bond.breaking_threshold = strength * material.tensile * float(area) * seconds
        holders.append(holder)
    return holders
