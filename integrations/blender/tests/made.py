"""The scene that the end-to-end test makes: names with spaces, signs and dots, a mesh with two users, a collection
that is instanced, a cut-out card, an object under a parent, a modifier that adds faces and one that only moves
them."""

import bpy


def material(name, colour, alpha=None):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    surface = made.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*colour, 1.0)
    surface.inputs["Roughness"].default_value = 1.0
    surface.inputs["Specular IOR Level"].default_value = 0.0
    return made


def add(name, kind, made=None, **how):
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(**how)
    item = bpy.context.object
    item.name = name
    if made:
        item.data.materials.append(made)
    return item


def make():
    """Builds it in an empty file; returns the objects by what they are for."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    grey, red = material("grey 50 %", (0.5, 0.5, 0.5)), material("red", (0.6, 0.1, 0.1))
    objects = {"floor": add("floor 100% *", "plane", grey, size=4.0)}
    first = add("box #1", "cube", red, size=0.6, location=(0.7, 0.7, 0.3))
    second = bpy.data.objects.new("box #1.copy", first.data)
    second.location, second.rotation_euler, second.scale = (-0.8, 0.6, 0.45), (0.0, 0.0, 0.5), (1.0, 1.0, 1.5)
    bpy.context.collection.objects.link(second)
    objects["twins"] = [first, second]
    child = add("child of box", "uv_sphere", None, segments=12, ring_count=6, radius=0.2)
    child.parent, child.location = first, (0.0, 0.0, 0.5)
    objects["child"] = child
    divided = {"x_subdivisions": 4, "y_subdivisions": 4}
    bent = add("bent (moved only)", "grid", grey, size=1.0, location=(-0.8, -0.9, 0.4), **divided)
    wave = bent.modifiers.new("Wave", "CAST")
    wave.factor = 0.3
    objects["bent"] = bent
    doubled = add("mirrored", "cube", grey, size=0.3, location=(0.9, -0.9, 0.15))
    doubled.modifiers.new("Array", "ARRAY").count = 2
    objects["doubled"] = doubled
    disc = {"vertices": 24, "radius": 0.4, "depth": 0.1, "end_fill_type": "NGON"}
    fan = add("round table", "cylinder", red, location=(0.0, -0.2, 0.4), **disc)
    objects["fan"] = fan
    # A collection outside of the view layer whose object stands in the scene as an instance alone.
    hidden = bpy.data.collections.new("shelf")
    inner = bpy.data.objects.new("inner", first.data.copy())
    hidden.objects.link(inner)
    empty = bpy.data.objects.new("shelf here", None)
    empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", hidden, (1.5, -0.2, 0.3)
    bpy.context.collection.objects.link(empty)
    objects["instance"] = inner
    bpy.context.view_layer.update()
    return objects
