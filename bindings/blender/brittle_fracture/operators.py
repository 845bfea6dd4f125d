"""The operators: check, fracture, remove the pieces."""
from __future__ import annotations

import threading

import bpy

from . import bodies, fracture, pieces, preview
from .engine import brittle


def _breakable(context: bpy.types.Context) -> bool:
    thing = context.active_object
    return thing is not None and thing.type in ("MESH", "CURVE", "SURFACE", "FONT", "META") and context.mode == "OBJECT"


class BRITTLE_OT_check(bpy.types.Operator):
    """Find out whether the object can be broken, and what to do if not"""

    bl_idname = "brittle.check"
    bl_label = "Check Mesh"

    @classmethod
    def poll(cls, context):
        return _breakable(context)

    def execute(self, context):
        reason = fracture.check(context.active_object, context.evaluated_depsgraph_get())
        if reason is not None:
            self.report({"WARNING"}, f"{reason}. Repair First may help")
        return {"FINISHED"}


class BRITTLE_OT_fracture(bpy.types.Operator):
    """Break the object into watertight pieces. Escape cancels"""

    bl_idname = "brittle.fracture"
    bl_label = "Fracture"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _breakable(context)

    def execute(self, context):
        thing = context.active_object
        try:
            self._plan = fracture.plan(thing, context.evaluated_depsgraph_get())
            broken = self._plan.work()
        except fracture.FAULTS as fault:
            return self._refuse(thing, fault)
        return self._build(context, thing, broken)

    def invoke(self, context, _event):
        """Breaks on another thread, so that the window stays alive."""
        self._thing, self._share, self._outcome = context.active_object, 0.0, None
        self._token = brittle.CancelToken()
        try:
            self._plan = fracture.plan(self._thing, context.evaluated_depsgraph_get(), cancel=self._token,
                                       progress=self._progress)
        except fracture.FAULTS as fault:
            return self._refuse(self._thing, fault)
        self._thread = threading.Thread(target=self._run, args=(self._plan.work,), daemon=True)
        self._thread.start()
        self._thread.join(0.1)  # most meshes break sooner than a timer fires
        if not self._thread.is_alive():
            return self._end(context)
        context.window_manager.progress_begin(0.0, 1.0)
        self._timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._token.cancel()
        if event.type == "TIMER":
            context.window_manager.progress_update(self._share)
            context.workspace.status_text_set(f"Fracture: {100 * self._share:.0f} %. Escape cancels.")
        if self._thread.is_alive():
            return {"RUNNING_MODAL"}
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        return self._end(context)

    def _run(self, work) -> None:
        try:
            self._outcome = work()
        except Exception as fault:  # shown by the main thread
            self._outcome = fault

    def _progress(self, share: float) -> None:
        self._share = share

    def _end(self, context):
        if isinstance(self._outcome, brittle.Cancelled):
            self.report({"INFO"}, "Fracture cancelled")
            return {"CANCELLED"}
        if isinstance(self._outcome, Exception):
            return self._refuse(self._thing, self._outcome)
        return self._build(context, self._thing, self._outcome)

    def _refuse(self, thing, fault):
        thing.brittle.verdict = str(fault)
        self.report({"ERROR"}, str(fault))
        return {"CANCELLED"}

    def _build(self, context, thing, broken):
        settings = thing.brittle
        settings.preview = False
        collection, objects = pieces.build(thing, broken, self._plan.layers)
        context.view_layer.update()
        if settings.rigid_bodies or settings.bonds:
            bodies.add_bodies(context.scene, objects, broken, settings.stuff())
        if settings.bonds:
            bodies.add_bonds(context.scene, collection, objects, broken, settings.stuff(), settings.strength)
        for selected in context.selected_objects:
            selected.select_set(False)
        for part in objects:
            part.select_set(True)
        context.view_layer.objects.active = objects[0] if objects else thing
        certificate = broken.certificate
        settings.verdict = (f"{certificate.pieces} pieces, all closed" if certificate.closed
                            else f"{certificate.open_pieces} of {certificate.pieces} pieces are open")
        self.report({"INFO"}, f"{thing.name}: {settings.verdict}")
        return {"FINISHED"}


class BRITTLE_OT_repair(bpy.types.Operator):
    """Repair the mesh before each fracture, and check it"""

    bl_idname = "brittle.repair"
    bl_label = "Repair"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _breakable(context)

    def execute(self, context):
        context.active_object.brittle.repair = True
        return bpy.ops.brittle.check()


_CLASSES = BRITTLE_OT_check, BRITTLE_OT_fracture, BRITTLE_OT_repair


def register() -> None:
    for kind in _CLASSES:
        bpy.utils.register_class(kind)


def unregister() -> None:
    preview.hide()
    for kind in reversed(_CLASSES):
        bpy.utils.unregister_class(kind)
