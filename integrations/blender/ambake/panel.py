"""The panel in the Render properties."""

import bpy

from . import bake, nodes


class AMBAKE_PT_bake(bpy.types.Panel):
    bl_label = "ambake"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.ambake
        layout.use_property_split = True
        layout.use_property_decorate = False
        running = bake.running()
        if running:
            progress = running.run.progress
            layout.progress(factor=progress.share, text=progress.text)
            layout.operator("ambake.cancel", icon="X")
            return
        row = layout.row()
        row.scale_y = 1.4
        row.operator("ambake.bake", icon="RENDER_STILL")
        layout.operator("ambake.switch", icon="HIDE_OFF", text="Show Originals" if nodes.shown() else "Show Baked")
        layout.operator("ambake.probes", icon="OUTLINER_OB_LIGHTPROBE")
        for name in ("targets", "show", "light", "bounces", "size", "effort"):
            layout.prop(settings, name)
        names = ("rays",) if settings.effort == "RAYS" else ("target_error", "target_relative", "max_rays")
        for name in names:
            layout.prop(settings, name)
        layout.prop(settings, "denoise")


class _Part:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_parent_id = "AMBAKE_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}
    names = ()

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        for name in self.shown(context.scene.ambake):
            self.layout.prop(context.scene.ambake, name)

    def shown(self, _settings):
        return self.names


class AMBAKE_PT_light(_Part, bpy.types.Panel):
    bl_label = "Light"
    names = ("max_distance", "normal_maps")

    def shown(self, settings):
        return ("sky", "sky_file", *self.names) if settings.light == "SKY" else self.names


class AMBAKE_PT_layout(_Part, bpy.types.Panel):
    bl_label = "Layout"
    names = ("density", "uv", "gutter", "mips", "seams")


class AMBAKE_PT_output(_Part, bpy.types.Panel):
    bl_label = "Output and More"
    names = ("uv_map", "image_name", "layers", "folder", "probe_engines", "backend", "threads", "seed", "further")
