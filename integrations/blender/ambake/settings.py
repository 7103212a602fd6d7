"""What the panel asks: the options of `ambake bake` under the names of their flags, kept with the scene."""

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    StringProperty,
)

SHOWN = [
    ("irradiance", "Light", "Light that arrives, times the base colour of the material at its full resolution"),
    ("diffuse", "Ambient occlusion", "The diffuse term: cosine-weighted share of the sky that is open"),
    ("visibility", "Open sky", "Share of the hemisphere that is open: the traditional occlusion factor"),
    ("lambert", "Lambert", "Light that a matt surface sends back, colour included"),
    ("ggx", "Shiny", "Lambert and the highlight of the material, as glTF and Principled BSDF define it"),
    ("phong", "Phong", "Lambert and the highlight of the paper's Phong lobe"),
    ("traditional", "Traditional", "Colour times occlusion factor: the baseline"),
]

# Paths may begin with //, the folder of the .blend; Blender 4.5 and later want to be told so.
RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5) else set()


def _plain(*words):
    return [(word, word.capitalize(), "") for word in words]


class AMBAKE_PG_settings(bpy.types.PropertyGroup):
    targets: EnumProperty(
        name="Bake",
        items=[
            ("VISIBLE", "Visible objects", "Every visible mesh gets a lightmap"),
            ("SELECTED", "Selected objects", "Selected meshes get a lightmap, other visible objects cast shadows"),
        ],
    )
    show: EnumProperty(name="Show", description="Layer that the materials show after the bake", items=SHOWN)
    size: IntProperty(name="Page Size", description="Page edge in texels", default=1024, min=1, max=16384)
    density: FloatProperty(
        name="Density", description="Texels per metre of every object; 0 shares one page by a rule", min=0.0
    )
    uv: EnumProperty(
        name="UVs",
        description="Keep the second UV map as layout where it is usable, insist on it, or unwrap anew",
        items=_plain("auto", "keep", "unwrap"),
    )
    gutter: IntProperty(name="Gutter", description="Texels kept empty around every chart", default=2, min=0, max=128)
    mips: IntProperty(name="Mip Levels", description="Mip levels that stay free of bleeding", min=0, max=6)
    effort: EnumProperty(
        name="Effort",
        items=[
            ("RAYS", "Rays", "The same number of rays for every texel"),
            ("TARGET", "Target error", "Each texel stops at its own standard error"),
        ],
    )
    rays: IntProperty(name="Rays", description="Rays per texel over the hemisphere", default=256, min=1, max=1 << 24)
    target_error: FloatProperty(
        name="Target Error", description="Root mean square of a page's standard errors",
        default=0.01, min=1e-5, max=0.99, precision=4,
    )
    target_relative: FloatProperty(
        name="Relative", description="An error of this share of the value counts as the target, where that is more",
        min=0.0, max=0.99, precision=4,
    )
    max_rays: IntProperty(
        name="Most Rays", description="Most rays of a texel", default=16384, min=16, max=1 << 24
    )
    denoise: EnumProperty(name="Denoise", items=_plain("regression", "off", "oidn"))
    seams: EnumProperty(
        name="Seams",
        description="Charts between which look-ups are made to agree: none, those of one object, or of any objects",
        items=_plain("off", "object", "scene"),
        default="scene",
    )
    light: EnumProperty(
        name="Light",
        items=[
            ("SCENE", "Scene lights", "The world and the lamps that render, as in Cycles"),
            ("SKY", "Sky of ambake", "The sky below, and no lamps"),
        ],
    )
    bounces: IntProperty(
        name="Bounces", default=4, min=0, max=64,
        description="How often surfaces send on the light that they receive. Materials that shine need one",
    )
    sky: FloatVectorProperty(
        name="Sky", description="Radiance of the uniform sky, linear", subtype="COLOR", size=3, default=(1, 1, 1),
        min=0.0, soft_max=1.0,
    )
    sky_file: StringProperty(
        name="Sky Map", description="Illumination map (.hdr, .exr) in place of the uniform sky", subtype="FILE_PATH",
        options=RELATIVE,
    )
    max_distance: FloatProperty(
        name="Max Distance", description="Occluders farther than this many metres do not count; 0 for no limit",
        min=0.0,
    )
    normal_maps: BoolProperty(name="Normal Maps", description="Normal maps bend the shading normals")
    layers: StringProperty(
        name="Layers", description="Further layers that come back as images, separated by commas, such as bent, error"
    )
    backend: EnumProperty(
        name="Backend",
        items=[("auto", "Automatic", "Embree where it is built in, else obvhs"), ("embree", "Embree", ""),
               ("obvhs", "obvhs", "Pure Rust")],
    )
    threads: IntProperty(name="Threads", description="Worker threads; 0 for all cores", min=0, max=1024)
    seed: IntProperty(name="Seed", description="Seed of the sample points", min=0)
    further: StringProperty(
        name="More Flags", description="Any further flags of `ambake bake`, as on the command line"
    )
    probe_engines: StringProperty(
        name="Probes For", default="bevy, three, unity, godot",
        description="Engines that light probes are written for, separated by commas: bevy, three, unity, godot",
    )
    uv_map: StringProperty(
        name="UV Map", default="ambake",
        description="Name of the UV map that holds the layout. It is made where there is none; one of yours of this "
        "name must be usable as it stands",
    )
    image_name: StringProperty(
        name="Images", description="What the names of the images begin with; empty for the name of the scene"
    )
    folder: StringProperty(
        name="Folder",
        description="Where the EXR pages, the GLB and bake.json stay; empty to keep none of them. The images are in "
        "the .blend either way", subtype="DIR_PATH", options=RELATIVE,
    )


class AMBAKE_AP_preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program", subtype="FILE_PATH",
        description="Path of the program ambake; empty for the one inside of the extension, else the one on the PATH",
    )

    def draw(self, _context):
        from . import command

        self.layout.prop(self, "program")
        try:
            self.layout.label(text=f"Found: {command.find(self.program)}", icon="CHECKMARK")
        except ValueError as problem:
            self.layout.label(text=str(problem), icon="ERROR")


def program(context):
    """The program's path as preferred, else where `command.find` looks for it."""
    from . import command

    addon = context.preferences.addons.get(__package__)
    return command.find(addon.preferences.program if addon and addon.preferences else "")
