"""The steps from an object to its pieces, without user interface."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional

import bpy
import numpy as np

from .engine import brittle
from .layers import Layers
from .meshes import mesh_of
from .sites import SourceError, sites_of

FAULTS = (brittle.BrittleError, SourceError, ValueError)


def solid_of(thing: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple["brittle.Mesh", Layers]:
    """The mesh of an object, repaired and united as its settings say, and its layers."""
    read, layers = mesh_of(thing, depsgraph)
    mesh = read.repair() if thing.brittle.repair else read
    mesh = mesh.unite() if thing.brittle.unite else mesh
    if mesh is not read:
        layers.follow = (layers.follow and np.array_equal(mesh.faces, read.faces)
                         and np.array_equal(mesh.vertices, read.vertices))
    return mesh, layers


@dataclass
class Plan:
    """The work of a fracture, which any thread may do, and what its pieces are built with."""

    work: Callable[[], "brittle.Fracture"]
    layers: Layers


def plan(thing: bpy.types.Object, depsgraph: bpy.types.Depsgraph, flat: bool = False, **options) -> Plan:
    """Reads everything from the scene. flat: without roughness."""
    mesh, layers = solid_of(thing, depsgraph)
    sites = sites_of(thing, mesh, depsgraph)
    settings = thing.brittle
    stuff = None if settings.material == "NONE" else settings.material.lower()
    roughness, seed = 0.0 if flat else settings.roughness_of_cuts(), settings.seed
    return Plan(lambda: brittle.fracture(mesh, sites, seed=seed, material=stuff, roughness=roughness, **options),
                layers)


def check(thing: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Optional[str]:
    """Why an object cannot be broken, or None. Fills the verdict of its settings."""
    try:
        found = solid_of(thing, depsgraph)[0].inspect()
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
