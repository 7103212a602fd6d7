"""The world of a Blender scene as ambake's sky: one colour, or a panorama that Cycles draws of it."""

import math
import os

import bpy

# What a light path says of light that reaches a matt surface. A world often hides itself from the camera by it.
_PATH = {"Is Diffuse Ray": 1.0, "Ray Depth": 1.0, "Diffuse Depth": 1.0}
_WIDTHS = 256, 2048


def sky(context, folder, notes):
    """What `--sky` is given: a colour, or the path of a picture that is written into `folder`."""
    world = context.scene.world
    if world is None or not _seen(world):
        return "0,0,0"
    if not world.use_nodes or world.node_tree is None:
        return _words(world.color)
    output = _output(world)
    if output is None:
        return "0,0,0"
    if output.inputs["Volume"].is_linked:
        notes.append("the volume of the world is not baked")
    if not output.inputs["Surface"].is_linked:
        return "0,0,0"
    node = output.inputs["Surface"].links[0].from_node
    colour, strength = node.inputs.get("Color"), node.inputs.get("Strength")
    if node.type == "BACKGROUND" and not colour.is_linked and not strength.is_linked:
        return _words(value * strength.default_value for value in colour.default_value[:3])
    try:
        return _draw(context, world, os.path.join(folder, "sky.exr"))
    except (RuntimeError, TypeError, AttributeError) as problem:
        notes.append(f"the world is not baked: Cycles, which draws it, is not at hand ({problem})")
        return "0,0,0"


def _seen(world):
    visibility = getattr(world, "cycles_visibility", None)
    return visibility is None or visibility.diffuse


def _words(colour):
    return ",".join(f"{max(value, 0.0):.7g}" for value in colour)


def _output(world):
    return world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")


def _draw(context, world, path):
    """Draws the world in ambake's polar projection: glTF's +z, which is Blender's -y, in the middle, and +x to its
    right."""
    scene = bpy.data.scenes.new("ambake sky")
    copy = world.copy()
    camera = bpy.data.cameras.new("ambake sky")
    item = bpy.data.objects.new("ambake sky", camera)
    try:
        _settle(copy.node_tree)
        scene.world, scene.camera = copy, item
        scene.collection.objects.link(item)
        scene.frame_set(context.scene.frame_current)
        item.rotation_euler = (math.pi / 2.0, 0.0, math.pi)
        scene.render.engine = "CYCLES"
        camera.type = "PANO"
        pano = camera if hasattr(camera, "panorama_type") else camera.cycles
        pano.panorama_type = "EQUIRECTANGULAR"
        # ambake's picture is that of a globe seen from outside: left and right are exchanged.
        pano.longitude_min, pano.longitude_max = math.pi, -math.pi
        width = _width(copy.node_tree)
        _quality(scene, width)
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True, scene=scene.name)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(item)
        bpy.data.cameras.remove(camera)
        bpy.data.worlds.remove(copy)
    return path


def _quality(scene, width):
    """Each texel is the mean over its area, as small suns need it."""
    cycles, render = scene.cycles, scene.render
    cycles.device, cycles.samples = "CPU", 16
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, width // 2, 100
    render.use_file_extension = render.use_compositing = render.use_sequencer = False
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"


def _width(tree):
    """Texels across: those of the largest picture, and the most where a sun may stand in a sky."""
    widths = [512]
    for node in tree.nodes:
        if node.type == "TEX_ENVIRONMENT" and node.image:
            widths.append(node.image.size[0])
        elif node.type in {"TEX_SKY", "GROUP"}:
            widths.append(_WIDTHS[1])
    return min(max(max(widths), _WIDTHS[0]), _WIDTHS[1]) // 4 * 4


def _settle(tree):
    """Answers every question for the light path as light on a matt surface does."""
    for node in [node for node in tree.nodes if node.type == "LIGHT_PATH"]:
        for output in node.outputs:
            for link in list(output.links):
                end, value = link.to_socket, _PATH.get(output.name, 0.0)
                tree.links.remove(link)
                if end.type == "RGBA":
                    end.default_value = (value, value, value, 1.0)
                elif end.type == "VECTOR":
                    end.default_value = (value, value, value)
                else:
                    end.default_value = value
