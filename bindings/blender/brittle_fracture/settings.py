"""How an object is to break. The settings are stored with the object."""
from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty
from bpy.props import StringProperty

from . import preview
from .engine import brittle

_PATTERNS = (
    ("UNIFORM", "Uniform", "Cells of equal likelihood everywhere"),
    ("CLUSTERED", "Clustered", "Small cells in the middle, large ones elsewhere"),
    ("RADIAL", "Radial", "Rings of shards, as glass breaks"),
    ("GRID", "Grid", "Rows of blocks"),
    ("BRICKS", "Bricks", "Courses of bricks"),
    ("SLICES", "Slices", "Cuts across the axis"),
    ("SPLINTERS", "Splinters", "Long cells along the axis, as wood breaks"),
    ("CURVE", "Crack", "Small cells along a crack"),
    ("CURVATURE", "Curvature", "Small cells where the surface bends"),
    ("THICKNESS", "Thickness", "Small cells where the solid is thin"),
)
_SOURCES = (
    ("PATTERN", "Pattern", "The pattern above places the cells"),
    ("EMPTY", "Empty", "The children of an empty are the sites; without children, cells are small near it"),
    ("PARTICLES", "Particles", "The particles of the active particle system are the sites"),
    ("STROKE", "Grease Pencil", "Cells are small along strokes of grease pencil"),
    ("WEIGHTS", "Weights", "Cells are small where the weights of the active vertex group are high"),
)


def _update_preview(settings: "ObjectSettings", _context: bpy.types.Context) -> None:
    if settings.preview:
        preview.request(settings.id_data)
    else:
        preview.hide(settings.id_data)


def _strokes_only(_settings: "ObjectSettings", thing: bpy.types.Object) -> bool:
    return thing.type in ("GPENCIL", "GREASEPENCIL")


def _empties_only(_settings: "ObjectSettings", thing: bpy.types.Object) -> bool:
    return thing.type == "EMPTY"


class ObjectSettings(bpy.types.PropertyGroup):
    """Object.brittle."""

    material: EnumProperty(
        name="Material", description="Stuff that decides pattern, roughness, mass and strength",
        items=[("NONE", "None", "Flat cuts and the density of stone"),
               *((name.upper(), name.capitalize(), f"Breaks as {name} does") for name in brittle.MATERIALS)],
        default="STONE", update=_update_preview)
    pattern: EnumProperty(name="Pattern", description="Arrangement of the cells",
                          items=[("MATERIAL", "Of the Material", "The pattern of the material"), *_PATTERNS],
                          default="MATERIAL", update=_update_preview)
    source: EnumProperty(name="Cells From", description="What places the cells", items=_SOURCES, default="PATTERN",
                         update=_update_preview)
    empty: PointerProperty(name="Empty", type=bpy.types.Object, poll=_empties_only, update=_update_preview)
    stroke: PointerProperty(name="Stroke", type=bpy.types.Object, poll=_strokes_only, update=_update_preview)
    count: IntProperty(name="Pieces", description="Number of cells", default=20, min=1, max=100_000, soft_max=1000,
                       update=_update_preview)
    seed: IntProperty(name="Seed", description="Another seed gives other pieces", default=1, min=0,
                      update=_update_preview)
    axis: FloatVectorProperty(name="Axis", description="Direction of slices, splinters and shards, in the world",
                              subtype="XYZ", default=(0.0, 0.0, 1.0), update=_update_preview)
    cells_per_piece: IntProperty(name="Cells/Piece", description="Cells that make up a piece: 1 gives convex "
                                 "pieces, 16 pieces of many facets", default=1, min=1, max=1000, update=_update_preview)
    use_roughness: BoolProperty(name="Own Roughness", description="Use the roughness below in place of the material's")
    roughness: FloatProperty(name="Roughness", description="Roughness of the cuts: 0 is flat", default=0.3, min=0.0,
                             max=1.0, subtype="FACTOR")
    interior: PointerProperty(name="Interior", description="Material of the cuts; empty: one in the colour of the stuff",
                              type=bpy.types.Material)
    repair: BoolProperty(name="Repair First", description="Close holes, turn faces and separate edges of several faces",
                         update=_update_preview)
    unite: BoolProperty(name="Unite First", description="Make one solid of parts that pass through each other",
                        update=_update_preview)
    rigid_bodies: BoolProperty(name="Rigid Bodies", description="Give pieces bodies with their mass, asleep until they "
                               "are hit", default=True)
    bonds: BoolProperty(name="Bonds", description="Hold pieces together by constraints that break", default=False)
    strength: FloatProperty(name="Strength", description="Share of the handbook strength at which bonds break; flaws "
                            "leave a tenth of it", default=0.1, min=1e-4, soft_max=1.0, max=100.0)
    preview: BoolProperty(name="Preview", description="Draw where the cracks will be", update=_update_preview)
    verdict: StringProperty(description="What the last check found")

    def stuff(self) -> "brittle.Material":
        """The material, that of stone where there is none."""
        return brittle.material("stone" if self.material == "NONE" else self.material.lower())

    def roughness_of_cuts(self) -> float:
        if self.use_roughness:
            return self.roughness
        return 0.0 if self.material == "NONE" else self.stuff().roughness


def register() -> None:
    bpy.utils.register_class(ObjectSettings)
    bpy.types.Object.brittle = PointerProperty(type=ObjectSettings)


def unregister() -> None:
    del bpy.types.Object.brittle
    bpy.utils.unregister_class(ObjectSettings)
