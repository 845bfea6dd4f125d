"""Voronoi fracture of triangle meshes, and destruction while a simulation runs.

    import brittle

    mesh = brittle.load("bunny.obj")
    broken = brittle.fracture(mesh, sites=100, seed=1, material="stone")
    print(broken.pieces[0].vertices, broken.certificate.closed)
    broken.export("pieces.glb")

Right-handed coordinates, Y up, metres, kilograms, seconds. Arrays that come out are read-only numpy views, which keep
their owner alive. Every call releases the interpreter lock, so several threads break meshes at once. Errors are
BrittleError, with the name of the status. brittle.dataset makes data sets of many fractures.
"""
from ._fracture import Certificate, Fracture, Piece, Sites, SurfacePart, fracture, load_sites, make_sites
from ._library import (ArgumentError, BrittleError, Cancelled, CancelToken, MissingFileError, OutOfMemoryError,
                       version as _version)
from ._material import MATERIALS, Material, material
from ._mesh import Inspection, Mesh, box, load, load_bytes, shape
from ._run import Recipe, Replay, Run, RunObject, replay
from ._world import AddedPiece, Events, World

__version__ = _version()
__all__ = ["AddedPiece", "ArgumentError", "BrittleError", "CancelToken", "Cancelled", "Certificate", "Events",
           "Fracture", "Inspection", "MATERIALS", "Material", "Mesh", "MissingFileError", "OutOfMemoryError", "Piece",
           "Recipe", "Replay", "Run", "RunObject", "Sites", "SurfacePart", "World", "box", "fracture", "load", "load_bytes",
           "load_sites", "make_sites", "material", "replay", "shape"]
