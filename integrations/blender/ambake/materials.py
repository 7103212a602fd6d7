"""What the glTF exporter cannot say of materials: colours of shaders other than Principled, which are put into the
file, and colours that are computed, which a note names."""

import bpy

from . import nodes
from .rendered import listed

# Nodes that the exporter reads where a colour is linked to them, although no picture comes of it.
_PLAIN = {"RGB", "VERTEX_COLOR", "ATTRIBUTE"}


def mend(glb, notes):
    """Puts colours into the materials of a file, and names those that are baked with a plain colour in place of their
    own."""
    computed = []
    _without_material(glb.json)
    for described in glb.json.get("materials", []):
        material = bpy.data.materials.get(described.get("name", ""))
        if material is None:
            continue
        if not material.use_nodes or material.node_tree is None:
            _plain(described, material.diffuse_color)
            continue
        surface = nodes.surface(material)
        if surface is None:
            continue
        glows = surface.type == "EMISSION"
        colour = None if glows else surface.inputs.get("Base Color") or surface.inputs.get("Color")
        emitted = surface.inputs.get("Color") if glows else surface.inputs.get("Emission Color")
        textured = "baseColorTexture" in described.get("pbrMetallicRoughness", {})
        if colour is not None and not textured:
            if _computed(colour):
                computed.append(material.name)
            if _computed(colour) or "pbrMetallicRoughness" not in described:
                _plain(described, colour.default_value)
        if emitted is not None and any(described.get("emissiveFactor", ())) and "emissiveTexture" not in described:
            if _computed(emitted):
                described["emissiveFactor"] = [min(max(value, 0.0), 1.0) for value in emitted.default_value[:3]]
                computed += [material.name] * (material.name not in computed)
    if computed:
        notes.append(f"the colour of {listed(computed)} is computed and baked as a plain one: make it a picture first")


def _without_material(document):
    """A surface without a material is matt and light grey in Cycles, and in what shows its bake (`nodes`)."""
    primitives = [p for mesh in document.get("meshes", []) for p in mesh["primitives"] if "material" not in p]
    if not primitives:
        return
    described = document.setdefault("materials", [])
    for primitive in primitives:
        primitive["material"] = len(described)
    matt = {"KHR_materials_specular": {"specularFactor": 0.0}}
    bare = {"name": "ambake: none", "doubleSided": True, "extensions": matt}
    _plain(bare, (nodes.BARE,) * 3)
    described.append(bare)
    used = document.setdefault("extensionsUsed", [])
    if "KHR_materials_specular" not in used:
        used.append("KHR_materials_specular")


def _computed(socket):
    return socket.is_linked and socket.links[0].from_node.type not in _PLAIN


def _plain(described, colour):
    surface = described.setdefault("pbrMetallicRoughness", {"metallicFactor": 0.0, "roughnessFactor": 1.0})
    alpha = surface.get("baseColorFactor", [1.0] * 4)[3]
    surface["baseColorFactor"] = [min(max(value, 0.0), 1.0) for value in (*colour[:3], alpha)]
