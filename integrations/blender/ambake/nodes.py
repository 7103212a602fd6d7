"""Node set-ups that show a lightmap, alike in Cycles and Eevee: an emission of the baked light beside the shader that
the material had, and one switch between the two for the whole file."""

import bpy
import numpy as np

from . import copies, linked

# Name of the node group, of its node in each material, and of the switch in the group.
GROUP = "ambake"
# Name of the group, and of its node in each material, that carries the UV map to the place of an object.
PLACE = "ambake place"
SWITCH = "Show Baked"
# Property of a material that a bake copied.
COPY = "ambake copy"
# Albedo of a surface without a material.
BARE = 0.8
# What the group takes of the shader beside the light.
INPUTS = "Base Color", "Alpha", "Emission Color", "Emission Strength"
# Layers that are light, to which that of the surface itself is added.
LIT = {"irradiance", "lambert", "ggx", "phong"}


def show(pages, images, layer, uv_map):
    """Lets materials show `layer` by that UV map. `pages` has the page of each polygon of each object that is baked."""
    outside = _materials_outside(pages)
    made, of_mesh = {}, {}
    for item in pages:
        of_mesh.setdefault(item.data, []).append(item)
    for mesh, items in of_mesh.items():
        if not mesh.materials:
            mesh.materials.append(None)
        before = [[slot.material for slot in item.material_slots] for item in items]
        first = pages[items[0]]
        # The mesh has the materials where all that use it show the same; else each object has its own.
        same = [of == before[0] and (pages[item] == first).all() for of, item in zip(before, items)]
        alike = mesh.users == len(items) and all(same)
        slots = np.empty(len(mesh.polygons), np.int32)
        mesh.polygons.foreach_get("material_index", slots)
        slots = slots.clip(0, len(mesh.materials) - 1)
        for index in range(len(before[0])):
            own = (slots == index) & (first >= 0)
            for k, page in enumerate(np.unique(first[own]).tolist()):
                slot = index
                faces = own & (first == page)
                if k > 0:
                    slot = len(mesh.materials)
                    mesh.materials.append(mesh.materials[index])
                    slots[faces] = slot
                for item, sources in zip(items, before):
                    # Objects that share a mesh may lie on other pages, all faces of one together.
                    number = int(pages[item][faces][0])
                    material = _material(made, outside, sources[index], number)
                    _wire(material, images[layer, number], layer, uv_map)
                    if not alike:
                        item.material_slots[slot].link = "OBJECT"
                    item.material_slots[slot].material = material
        mesh.polygons.foreach_set("material_index", slots)
        mesh.update()
    for material in [of for of in bpy.data.materials if COPY in of and of.users == 0]:
        bpy.data.materials.remove(material)
    switch(True)


def switch(on):
    """Shows the bake or what was there before, in every material and object."""
    group = bpy.data.node_groups.get(GROUP)
    if group is not None:
        group.nodes[SWITCH].outputs[0].default_value = float(on)
    copies.show(on)


def shown():
    """Whether the bake is shown."""
    group = bpy.data.node_groups.get(GROUP)
    return group is not None and group.nodes[SWITCH].outputs[0].default_value > 0.5


def bypass(material):
    """Leads the output of a material to the shader that it had before any bake, and returns what leads it back; an
    exporter must see the material, not the bake."""
    tree = material.node_tree
    switcher = tree.nodes.get(GROUP) if tree else None
    ends = [link.to_socket for link in switcher.outputs[0].links] if switcher else []
    before = [link.from_socket for link in switcher.inputs["Shader"].links] if switcher else []
    for end in ends:
        for link in list(end.links):
            tree.links.remove(link)
        for socket in before:
            tree.links.new(socket, end)

    def restore():
        for end in ends:
            tree.links.new(switcher.outputs[0], end)

    return restore


def _materials_outside(items):
    """Materials that objects outside of the bake use too: those must go on looking as they do. Objects that a copy
    stands for are not seen beside it."""
    inside = {*items, *copies.all_of_them()}
    others = [item for item in bpy.data.objects if item not in inside]
    return {slot.material for item in others for slot in item.material_slots if slot.material}


def _material(made, outside, source, page):
    """The material that shows a page in place of `source`: itself, or a copy where it must serve another page or
    others."""
    key = (source, page)
    if key not in made:
        first = not any(of == source for of, _ in made)
        if source is None:
            material = _bare()
        elif first and source not in outside and source.is_editable:
            material = source
        else:
            material = source.copy()
            material.name = f"{source.name} page {page}"
            material[COPY] = True
        made[key] = material
    return made[key]


def _bare():
    """What a surface without a material looks like in Cycles."""
    material = bpy.data.materials.new("ambake")
    material.use_nodes = True
    surface = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    surface.inputs["Base Color"].default_value = (BARE, BARE, BARE, 1.0)
    surface.inputs["Roughness"].default_value, surface.inputs["Specular IOR Level"].default_value = 1.0, 0.0
    return material


def _wire(material, image, layer, uv_map):
    if material.node_tree is None or not material.use_nodes:
        colour, material.use_nodes = tuple(material.diffuse_color), True
        for node in material.node_tree.nodes:
            if node.type == "BSDF_PRINCIPLED":
                node.inputs["Base Color"].default_value = colour
    tree = material.node_tree
    output = tree.get_output_node("ALL") or tree.nodes.new("ShaderNodeOutputMaterial")
    switcher = tree.nodes.get(GROUP)
    if switcher is None:
        switcher = _place(tree, output)
    tree.nodes["ambake UV"].uv_map = uv_map
    _carry(tree)
    picture = tree.nodes["ambake image"]
    picture.image = image
    picture.label = layer
    _tint(tree, switcher, layer)


def _place(tree, output):
    """Adds the nodes: UV map, image, and the group between the shader and the output."""
    x, y = output.location
    before = [link.from_socket for link in output.inputs["Surface"].links]
    switcher = tree.nodes.new("ShaderNodeGroup")
    switcher.name, switcher.node_tree, switcher.location = GROUP, _group(), (x, y + 160)
    output.location = (x + 220, y)
    picture = tree.nodes.new("ShaderNodeTexImage")
    picture.name, picture.location, picture.extension = "ambake image", (x - 320, y + 420), "EXTEND"
    place = tree.nodes.new("ShaderNodeUVMap")
    place.name, place.location = "ambake UV", (x - 520, y + 420)
    tree.links.new(picture.outputs["Color"], switcher.inputs["Light"])
    for socket in before:
        tree.links.new(socket, switcher.inputs["Shader"])
    tree.links.new(switcher.outputs["Shader"], output.inputs["Surface"])
    return switcher


def _carry(tree):
    """Leads the UV map through the group that carries it to the place of the object, of which earlier extensions knew
    nothing."""
    carrier = tree.nodes.get(PLACE)
    if carrier is None:
        start, end = tree.nodes["ambake UV"], tree.nodes["ambake image"]
        carrier = tree.nodes.new("ShaderNodeGroup")
        carrier.name, carrier.node_tree, carrier.location = PLACE, _place_group(), start.location
        start.location = (start.location[0] - 200, start.location[1])
        tree.links.new(start.outputs["UV"], carrier.inputs["UV"])
        tree.links.new(carrier.outputs["UV"], end.inputs["Vector"])


def _tint(tree, switcher, layer):
    """Irradiance is multiplied by the base colour, the other layers stand for themselves. Alpha holds for all. To
    layers of light comes what the surface sends of its own."""
    surface = _first(switcher.inputs["Shader"])
    sockets = colour, alpha, glow, strength = [switcher.inputs[name] for name in INPUTS]
    for link in [link for socket in sockets for link in socket.links]:
        tree.links.remove(link)
    colour.default_value, alpha.default_value = (1.0, 1.0, 1.0, 1.0), 1.0
    glow.default_value, strength.default_value = (0.0, 0.0, 0.0, 1.0), 0.0
    if surface is None:
        return
    shines = surface.type == "EMISSION"
    if layer == "irradiance" and shines:
        colour.default_value = (0.0, 0.0, 0.0, 1.0)
    elif layer == "irradiance":
        _follow(tree, surface, ("Base Color", "Color"), colour)
    if layer in LIT:
        _follow(tree, surface, ("Color",) if shines else ("Emission Color",), glow)
        _follow(tree, surface, ("Strength",) if shines else ("Emission Strength",), strength)
    _follow(tree, surface, ("Alpha",), alpha)


def _follow(tree, node, names, socket):
    for name in names:
        source = node.inputs.get(name)
        if source is None:
            continue
        if source.is_linked:
            tree.links.new(source.links[0].from_socket, socket)
        else:
            socket.default_value = source.default_value
        return


def surface(material):
    """The node that gives a material its colour; None where it has none."""
    switcher = material.node_tree.nodes.get(GROUP)
    output = material.node_tree.get_output_node("ALL")
    if switcher is None and output is None:
        return None
    return _first(switcher.inputs["Shader"] if switcher else output.inputs["Surface"])


def _first(socket):
    """The first of the shaders that a socket is given."""
    waiting = [link.from_node for link in socket.links]
    seen = []
    while waiting:
        node = waiting.pop(0)
        if node.inputs.get("Base Color") or node.type.startswith(("BSDF", "EMISSION")):
            if node.type != "BSDF_TRANSPARENT":
                return node
        for socket in node.inputs:
            if socket.type == "SHADER":
                waiting.extend(link.from_node for link in socket.links if link.from_node not in seen)
        seen.append(node)
    return None


def _place_group():
    """The group that carries a UV map to the place of the object that is drawn."""
    group = bpy.data.node_groups.get(PLACE)
    if group is not None:
        return group
    group = bpy.data.node_groups.new(PLACE, "ShaderNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        group.interface.new_socket("UV", in_out=in_out, socket_type="NodeSocketVector")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    grown, sum_ = group.nodes.new("ShaderNodeVectorMath"), group.nodes.new("ShaderNodeVectorMath")
    grown.operation, sum_.operation = "MULTIPLY_ADD", "ADD"
    group.links.new(start.outputs[0], grown.inputs[0])
    for k, name in ((1, linked.GROWTH), (2, linked.OFFSET)):
        told = group.nodes.new("ShaderNodeAttribute")
        told.attribute_type, told.attribute_name, told.location = "OBJECT", name, (-200, -200 * k)
        group.links.new(told.outputs["Vector"], grown.inputs[k])
    group.links.new(grown.outputs[0], sum_.inputs[0])
    group.links.new(start.outputs[0], sum_.inputs[1])
    group.links.new(sum_.outputs[0], end.inputs[0])
    for node, x in ((start, -400), (grown, 0), (sum_, 200), (end, 400)):
        node.location = (x, 0)
    return group


def _group():
    """The group that all materials share."""
    group = bpy.data.node_groups.get(GROUP) or bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    face = group.interface
    known = {(socket.name, socket.in_out) for socket in face.items_tree}
    if all((name, "INPUT") in known for name in INPUTS):
        return group
    # A new one, or one of a file that an earlier extension baked: its sockets stay, for materials are linked to them.
    for name, in_out, kind, value in (
        ("Shader", "INPUT", "Shader", None),
        ("Light", "INPUT", "Color", None),
        ("Base Color", "INPUT", "Color", None),
        ("Alpha", "INPUT", "Float", 1.0),
        ("Emission Color", "INPUT", "Color", None),
        ("Emission Strength", "INPUT", "Float", 0.0),
        ("Shader", "OUTPUT", "Shader", None),
    ):
        if (name, in_out) not in known:
            socket = face.new_socket(name, in_out=in_out, socket_type=f"NodeSocket{kind}")
            if value is not None:
                socket.default_value = value
    group.nodes.clear()

    def node(kind, x, y):
        made = group.nodes.new(kind)
        made.location = (x, y)
        return made

    start, end = node("NodeGroupInput", -600, 0), node("NodeGroupOutput", 600, 0)
    own, sum_ = node("ShaderNodeVectorMath", -400, -260), node("ShaderNodeVectorMath", -300, -80)
    times, glow = node("ShaderNodeVectorMath", -400, -80), node("ShaderNodeEmission", -200, -80)
    own.operation, times.operation, sum_.operation = "SCALE", "MULTIPLY", "ADD"
    clear, cut = node("ShaderNodeBsdfTransparent", -200, -220), node("ShaderNodeMixShader", 0, -120)
    choose, value = node("ShaderNodeMixShader", 300, 0), node("ShaderNodeValue", 0, 120)
    value.name = value.label = SWITCH
    link = group.links.new
    link(start.outputs["Light"], times.inputs[0])
    link(start.outputs["Base Color"], times.inputs[1])
    link(start.outputs["Emission Color"], own.inputs[0])
    link(start.outputs["Emission Strength"], own.inputs["Scale"])
    link(times.outputs[0], sum_.inputs[0])
    link(own.outputs[0], sum_.inputs[1])
    link(sum_.outputs[0], glow.inputs["Color"])
    link(start.outputs["Alpha"], cut.inputs[0])
    link(clear.outputs[0], cut.inputs[1])
    link(glow.outputs[0], cut.inputs[2])
    link(value.outputs[0], choose.inputs[0])
    link(start.outputs["Shader"], choose.inputs[1])
    link(cut.outputs[0], choose.inputs[2])
    link(choose.outputs[0], end.inputs["Shader"])
    return group
