"""The panel in the sidebar of the 3D view."""
from __future__ import annotations

import textwrap

import bpy

from . import preview


def _text(layout: bpy.types.UILayout, context: bpy.types.Context, words: str, icon: str = "NONE") -> None:
    """A text in as many lines as the width of the panel needs."""
    width = max(int(context.region.width / (8 * context.preferences.system.ui_scale)) - 6, 16)
    column = layout.column(align=True)
    for row, line in enumerate(textwrap.wrap(words, width)):
        column.label(text=line, icon=icon if row == 0 else "BLANK1" if icon != "NONE" else "NONE")


class BRITTLE_PT_fracture(bpy.types.Panel):
    bl_label = "Brittle Fracture"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Brittle"
    bl_context = "objectmode"

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        thing = context.active_object
        if thing is None or thing.type not in ("MESH", "CURVE", "SURFACE", "FONT", "META"):
            layout.label(text="Select a mesh", icon="INFO")
            return
        settings = thing.brittle

        column = layout.column()
        column.prop(settings, "material")
        column.prop(settings, "source")
        if settings.source == "PATTERN":
            column.prop(settings, "pattern")
        elif settings.source == "EMPTY":
            column.prop(settings, "empty")
        elif settings.source == "STROKE":
            column.prop(settings, "stroke")
        column.prop(settings, "count")
        column.prop(settings, "seed")
        column.prop(settings, "cells_per_piece")
        pattern = settings.stuff().pattern.upper() if settings.pattern == "MATERIAL" else settings.pattern
        if settings.source == "PATTERN" and pattern in ("RADIAL", "SLICES", "SPLINTERS"):
            column.prop(settings, "axis")

        column = layout.column(heading="Roughness")
        row = column.row(align=True)
        row.prop(settings, "use_roughness", text="")
        value = row.row()
        value.active = settings.use_roughness
        value.prop(settings, "roughness", text="")
        layout.prop(settings, "interior")

        column = layout.column(heading="Mesh")
        column.prop(settings, "repair")
        column.prop(settings, "unite")
        column = layout.column(heading="Physics")
        column.prop(settings, "rigid_bodies")
        column.prop(settings, "bonds")
        if settings.bonds:
            column.prop(settings, "strength")

        layout.prop(settings, "preview", toggle=True, icon="HIDE_OFF" if settings.preview else "HIDE_ON")
        row = layout.row()
        row.scale_y = 1.5
        row.operator("brittle.fracture", icon="MOD_EXPLODE")
        words = preview.fault_of(thing) or settings.verdict
        if words:
            _text(layout, context, words, "INFO")
            if not settings.repair and ("open edges" in words or words.startswith("Not a solid")):
                layout.operator("brittle.repair", icon="MODIFIER")
        layout.operator("brittle.check", icon="CHECKMARK")


def register() -> None:
    bpy.utils.register_class(BRITTLE_PT_fracture)


def unregister() -> None:
    bpy.utils.unregister_class(BRITTLE_PT_fracture)
