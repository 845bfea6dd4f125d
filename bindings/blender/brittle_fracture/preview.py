"""The cracks, drawn over the 3D view while settings change."""
from __future__ import annotations

from typing import Optional

import bpy
import numpy as np

from . import fracture
from .engine import brittle

_DELAY = 0.05  #: seconds after the last change
_COLOUR = (1.0, 0.55, 0.1)
_HIDDEN = 0.12  #: opacity of what lies inside or behind
_TOWARDS_EYE = 0.003  #: of the distance of the view


class _State:
    thing: Optional[str] = None  #: name of the object
    lines = np.zeros((0, 3), np.float32)
    fault = ""
    handler = None


def cracks(broken: "brittle.Fracture") -> np.ndarray:
    """(2k, 3): ends of the edges where a cut meets the outside or another cut."""
    lines = [np.zeros((0, 3))]
    for piece in broken.pieces:
        faces = piece.faces.astype(np.int64)
        source = piece.face_sources.astype(np.int64)
        source[:piece.exterior_faces] = -1  # the outside is one
        edges = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
        owner = np.repeat(source, 3)
        edges.sort(axis=1)
        order = np.lexsort((edges[:, 1], edges[:, 0]))  # the two faces of an edge come together
        edges, owner = edges[order], owner[order]
        border = owner[0::2] != owner[1::2]
        lines.append(piece.vertices[edges[0::2][border]].reshape(-1, 3))
    return np.concatenate(lines).astype(np.float32)


def refresh() -> None:
    """Computes the cracks of the object whose preview is on."""
    thing = bpy.data.objects.get(_State.thing or "")
    if thing is None:
        return
    try:
        _State.lines = cracks(fracture.plan(thing, bpy.context.evaluated_depsgraph_get(), flat=True).work())
        _State.fault = ""
    except fracture.FAULTS as fault:
        _State.lines, _State.fault = np.zeros((0, 3), np.float32), str(fault)
    _redraw()


def fault_of(thing: bpy.types.Object) -> str:
    """Why there is no preview of an object; empty where there is one."""
    return _State.fault if _State.thing == thing.name else ""


def request(thing: bpy.types.Object) -> None:
    """Shows the cracks of an object soon; those of another one are hidden."""
    _State.thing = thing.name
    if _State.handler is None and not bpy.app.background:
        _State.handler = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")
    if bpy.app.timers.is_registered(refresh):
        bpy.app.timers.unregister(refresh)
    bpy.app.timers.register(refresh, first_interval=_DELAY)


def hide(thing: Optional[bpy.types.Object] = None) -> None:
    """Hides the cracks, or only those of an object."""
    if thing is not None and _State.thing != thing.name:
        return
    _State.thing, _State.lines, _State.fault = None, np.zeros((0, 3), np.float32), ""
    if _State.handler is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_State.handler, "WINDOW")
        _State.handler = None
    _redraw()


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _draw() -> None:
    if len(_State.lines) == 0:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    view = bpy.context.region_data
    name = "3D_POLYLINE_UNIFORM_COLOR" if bpy.app.version < (4, 0, 0) else "POLYLINE_UNIFORM_COLOR"
    shader = gpu.shader.from_builtin(name)
    batch = batch_for_shader(shader, "LINES", {"pos": _State.lines})
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", 1.5 * bpy.context.preferences.system.pixel_size)
    gpu.state.blend_set("ALPHA")
    with gpu.matrix.push_pop():
        # A little towards the eye, so that lines on the surface are before it.
        gpu.matrix.translate(_TOWARDS_EYE * view.view_distance * view.view_matrix.to_3x3().inverted().col[2])
        for depth_test, opacity in (("NONE", _HIDDEN), ("LESS_EQUAL", 1.0)):
            gpu.state.depth_test_set(depth_test)
            shader.uniform_float("color", (*_COLOUR, opacity))
            batch.draw(shader)
    gpu.state.depth_test_set("NONE")
    gpu.state.blend_set("NONE")
