"""ambake in Blender: the panel *ambake* in the Render properties bakes ambient light into lightmaps and shows them."""

import bpy

from . import bake, panel, settings

CLASSES = (
    settings.AMBAKE_PG_settings,
    settings.AMBAKE_AP_preferences,
    bake.AMBAKE_OT_bake,
    bake.AMBAKE_OT_probes,
    bake.AMBAKE_OT_cancel,
    bake.AMBAKE_OT_switch,
    panel.AMBAKE_PT_bake,
    panel.AMBAKE_PT_light,
    panel.AMBAKE_PT_layout,
    panel.AMBAKE_PT_output,
)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.ambake = bpy.props.PointerProperty(type=settings.AMBAKE_PG_settings)


def unregister():
    if bake.running():
        bake.running().cancel()
    del bpy.types.Scene.ambake
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
