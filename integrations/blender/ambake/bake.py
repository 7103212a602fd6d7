"""The operators: bake, cancel, and show the bake or what was there before."""

import os
import shutil
import tempfile
import time

import bpy
from mathutils import Vector

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
            self.of, self.settings = context.scene.name, _frozen(settings)
            self.lit = self.sent.lit if settings.light == "SCENE" else command.sky(self.settings)
            self.scene = scene
            self.run = command.Run(self.found, self.flags(context))
        except BaseException:
            self.close()
            raise

    def flags(self, _context):
        """What ambake is asked for."""
        return command.arguments(self.settings, self.scene, self.folder, self.sent.occluders, self.lit)

    def result(self):
        """What ambake tells when it has ended. A ValueError where it failed."""
        try:
            return self.run.result()
        except ValueError as problem:
            raise ValueError(str(problem).replace(f"{self.scene}: ", "")) from None

    def finish(self):
        """Brings the result back; one sentence for the status bar, and notes. A ValueError where ambake failed."""
        report = self.result()
        count, notes = receive.bring_back(bpy.data.scenes[self.of], self.settings, self.sent, self.folder, report)
        notes += command.untaken(report)
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


class Probes(Bake):
    """Light for what moves: the files of probes, in the folder of the settings. The scene stays as it is."""

    def __init__(self, context):
        if not context.scene.ambake.folder:
            raise ValueError("name a folder for the files of the probes, under Output and More")
        self.volume = _volume(context)
        super().__init__(context)

    def flags(self, _context):
        return command.probe_arguments(self.settings, self.scene, self.folder, self.lit, *self.volume)

    def finish(self):
        report = self.result()
        for receiver in self.sent.receivers:
            send.forget(receiver)
        seconds = time.monotonic() - self.started
        words = f"{report['probes']} probes in {seconds:.1f} s, error {report['std_err']:.4f}, in {self.folder}"
        within = f"{report['invalid']} probes are in solids and have the light of their neighbours"
        return words, [within] if report["invalid"] else []


def _volume(context):
    """The box of a light probe volume in glTF's axes, by two corners, and how many probes it has along each. A
    ValueError where there is none."""
    probes = [item for item in context.visible_objects if item.type == "LIGHT_PROBE"]
    volumes = [item for item in probes if item.data.type in {"VOLUME", "GRID"}]
    if context.active_object in volumes:
        volumes = [context.active_object]
    if len(volumes) != 1:
        raise ValueError(
            "add a light probe volume (Add, Light Probe, Volume) around the air in which things move"
            if not volumes
            else "there are several light probe volumes; select one"
        )
    (volume,) = volumes
    corners = [volume.matrix_world @ Vector((x, y, z)) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    # glTF's axes: x, z, -y of Blender's.
    turned = [(x, z, -y) for x, y, z in corners]
    low, high = [tuple(of(axis) for axis in zip(*turned)) for of in (min, max)]
    data = volume.data
    return low, high, (data.resolution_x, data.resolution_z, data.resolution_y)


class _frozen:
    """The settings as they were when the bake began: the user may go on changing them."""

    def __init__(self, settings):
        for name in settings.bl_rna.properties.keys():
            if name not in {"rna_type", "name"}:
                value = getattr(settings, name)
                setattr(self, name, tuple(value) if name == "sky" else value)
        self.uv_map = settings.uv_map or settings.bl_rna.properties["uv_map"].default
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


class _Job:
    """What the operators share. It is none itself: Blender loses a class of which another one is made."""

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
            bake = self.job(context)
        except ValueError as problem:
            return self._fail(problem)
        bake.run.wait()
        return self._end(context, bake)

    def invoke(self, context, _event):
        global _running
        try:
            _running = self.job(context)
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


class AMBAKE_OT_bake(_Job, bpy.types.Operator):
    """Bake ambient light into lightmaps with ambake"""

    bl_idname = "ambake.bake"
    bl_label = "Bake with ambake"
    job = Bake


class AMBAKE_OT_probes(_Job, bpy.types.Operator):
    """Gather the light that arrives in a light probe volume, and write it for game engines"""

    bl_idname = "ambake.probes"
    bl_label = "Write Light Probes"
    job = Probes


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
    """Show the bake, or objects and materials as they were"""

    bl_idname = "ambake.switch"
    bl_label = "Show Baked or Original"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, _context):
        return nodes.GROUP in bpy.data.node_groups

    def execute(self, _context):
        nodes.switch(not nodes.shown())
        self.report({"INFO"}, "the bake is shown" if nodes.shown() else "the scene is shown as it was")
        return {"FINISHED"}


def _redraw(context):
    for area in context.screen.areas if context.screen else ():
        if area.type == "PROPERTIES":
            area.tag_redraw()
