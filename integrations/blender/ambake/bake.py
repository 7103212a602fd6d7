"""The operators: bake, cancel, and show the bake or what was there before."""

import os
import shutil
import tempfile
import time

import bpy

from . import command, nodes, receive, send
from .settings import program

# The one bake that runs, if any.
_running = None


class Bake:
    """A bake between its export and its return."""

    def __init__(self, context):
        settings = context.scene.ambake
        self.found = program(context)
        self.started = time.monotonic()
        self.temporary = tempfile.mkdtemp(prefix="ambake-")
        try:
            self.folder = _folder(settings, self.temporary)
            name = bpy.path.clean_name(context.scene.name) or "scene"
            scene = os.path.join(self.temporary, "scene", f"{name}.glb")
            os.makedirs(os.path.dirname(scene))
            self.sent = send.export(context, settings, scene)
            self.settings = _frozen(settings)
            flags = command.arguments(self.settings, scene, self.folder, self.sent.occluders)
            self.run = command.Run(self.found, flags)
            self.scene = scene
        except BaseException:
            self.close()
            raise

    def finish(self):
        """Brings the result back; one sentence for the status bar, and notes. A ValueError where ambake failed."""
        try:
            report = self.run.result()
        except ValueError as problem:
            raise ValueError(str(problem).replace(f"{self.scene}: ", "")) from None
        count, notes = receive.bring_back(self.settings, self.sent, self.folder, report)
        pages = report["pages"]
        error = max((page["rmse"] for page in pages), default=0.0)
        seconds = time.monotonic() - self.started
        words = f"{count} object{'s' * (count != 1)} baked on {len(pages)} page{'s' * (len(pages) != 1)}"
        return f"{words} in {seconds:.1f} s, error {error:.4f} (root mean square)", notes

    def cancel(self):
        """Stops it; the scene is as it was."""
        self.run.cancel()
        for receiver in self.sent.receivers:
            send.forget(receiver)

    def close(self):
        """Removes its temporary files."""
        shutil.rmtree(self.temporary, ignore_errors=True)


class _frozen:
    """The settings as they were when the bake began: the user may go on changing them."""

    def __init__(self, settings):
        for name in settings.bl_rna.properties.keys():
            if name not in {"rna_type", "name"}:
                value = getattr(settings, name)
                setattr(self, name, tuple(value) if name == "sky" else value)
        self.sky_file = bpy.path.abspath(settings.sky_file)


def _folder(settings, temporary):
    if not settings.folder:
        return os.path.join(temporary, "bake")
    if settings.folder.startswith("//") and not bpy.data.filepath:
        raise ValueError("the folder is relative to the .blend file: save the file first, or leave the folder empty")
    return bpy.path.abspath(settings.folder)


def running():
    """The bake that runs, or None."""
    return _running


class AMBAKE_OT_bake(bpy.types.Operator):
    """Bake ambient light into lightmaps with ambake"""

    bl_idname = "ambake.bake"
    bl_label = "Bake with ambake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if context.mode != "OBJECT":
            cls.poll_message_set("leave Edit Mode first")
            return False
        return _running is None

    def execute(self, context):
        """Without a window, as in a script: waits for the end."""
        try:
            bake = Bake(context)
        except ValueError as problem:
            return self._fail(problem)
        bake.run.wait()
        return self._end(context, bake)

    def invoke(self, context, _event):
        global _running
        try:
            _running = Bake(context)
        except ValueError as problem:
            return self._fail(problem)
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        self.timer = manager.event_timer_add(0.2, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        global _running
        bake = _running
        if event.type == "ESC" and event.value == "PRESS":
            bake.cancel()
        elif event.type != "TIMER":
            return {"PASS_THROUGH"}
        if bake.run.running():
            progress = bake.run.progress
            context.window_manager.progress_update(progress.share)
            context.workspace.status_text_set(f"ambake: {100 * progress.share:.0f} %, {progress.text} (Esc cancels)")
            _redraw(context)
            return {"PASS_THROUGH"}
        _running = None
        context.window_manager.event_timer_remove(self.timer)
        context.window_manager.progress_end()
        context.workspace.status_text_set(None)
        _redraw(context)
        return self._end(context, bake)

    def _end(self, context, bake):
        try:
            if bake.run.cancelled:
                self.report({"INFO"}, "the bake was cancelled; nothing has changed")
                return {"CANCELLED"}
            words, notes = bake.finish()
        except ValueError as problem:
            bake.cancel()
            return self._fail(problem)
        finally:
            bake.close()
        for note in notes:
            self.report({"WARNING"}, note)
        self.report({"INFO"}, words)
        context.view_layer.update()
        return {"FINISHED"}

    def _fail(self, problem):
        self.report({"ERROR"}, str(problem))
        return {"CANCELLED"}


class AMBAKE_OT_cancel(bpy.types.Operator):
    """Stop the bake that runs; nothing will have changed"""

    bl_idname = "ambake.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, _context):
        return _running is not None

    def execute(self, _context):
        _running.cancel()
        return {"FINISHED"}


class AMBAKE_OT_switch(bpy.types.Operator):
    """Show the bake, or the materials as they were, in every object"""

    bl_idname = "ambake.switch"
    bl_label = "Show Baked or Original"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, _context):
        return nodes.GROUP in bpy.data.node_groups

    def execute(self, _context):
        shown = nodes.switch()
        self.report({"INFO"}, "the bake is shown" if shown else "the materials are shown as they were")
        return {"FINISHED"}


def _redraw(context):
    for area in context.screen.areas if context.screen else ():
        if area.type == "PROPERTIES":
            area.tag_redraw()
