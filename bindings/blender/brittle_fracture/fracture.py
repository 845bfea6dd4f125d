"""The steps from an object to its pieces, without user interface."""
from __future__ import annotations

from typing import Callable, Optional

import bpy

from .engine import brittle
from .meshes import mesh_of
from .sites import SourceError, sites_of

FAULTS = (brittle.BrittleError, SourceError, ValueError)


def solid_of(thing: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> "brittle.Mesh":
    """The mesh of an object, repaired and united as its settings say."""
    mesh = mesh_of(thing, depsgraph)
    if thing.brittle.repair:
        mesh = mesh.repair()
    return mesh.unite() if thing.brittle.unite else mesh


def plan(thing: bpy.types.Object, depsgraph: bpy.types.Depsgraph, flat: bool = False,
         **options) -> Callable[[], "brittle.Fracture"]:
    """Reads everything from the scene, and returns the work that any thread may do. flat: without roughness."""
    mesh = solid_of(thing, depsgraph)
    sites = sites_of(thing, mesh, depsgraph)
    settings = thing.brittle
    stuff = None if settings.material == "NONE" else settings.material.lower()
    roughness, seed = 0.0 if flat else settings.roughness_of_cuts(), settings.seed
    return lambda: brittle.fracture(mesh, sites, seed=seed, material=stuff, roughness=roughness, **options)


def check(thing: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Optional[str]:
    """Why an object cannot be broken, or None. Fills the verdict of its settings."""
    try:
        found = solid_of(thing, depsgraph).inspect()
    except FAULTS as fault:
        thing.brittle.verdict = str(fault)
        return str(fault)
    flaws = [f"{count} {name}" for name, count in (
        ("open edges", found.open_edges), ("edges of several faces", found.non_manifold_edges),
        ("edges with opposite faces", found.misoriented_edges)) if count]
    if found.refusal is not None:
        reason = ", ".join(flaws) or found.refusal.replace("_", " ")
        thing.brittle.verdict = f"Not a solid: {reason}"
        return thing.brittle.verdict
    crossing = f", {found.intersections} pairs of faces cross" if found.intersections else ""
    thing.brittle.verdict = f"Solid of {found.volume:.4g} m\u00b3{crossing}"
    return None
