"""Brittle for Blender: breaks objects into watertight pieces, for rigid bodies and rendering.

Panel: 3D view, sidebar, tab Brittle. Blender 3.4 and later. The package brittle lies in the folder `bundled` of the
add-on, or comes as a wheel with the extension.
"""
bl_info = {
    "name": "Brittle Fracture",
    "author": "Brittle",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Brittle",
    "description": "Breaks objects into watertight Voronoi pieces",
    "category": "Object",
}

from . import operators, panel, preview, settings


def register() -> None:
    for module in (settings, operators, panel):
        module.register()


def unregister() -> None:
    preview.hide()
    for module in (panel, operators, settings):
        module.unregister()
