"""Exports the scene with Blender's own glTF exporter. Nothing in the scene is different afterwards."""

import contextlib
import os
from dataclasses import dataclass, field

import bpy
import numpy as np

from . import copies, corners, lamps, materials, nodes, rendered, scene_light
from .glb import Glb
from .rendered import listed, s

# Objects that have a surface.
_KINDS = {"MESH", "CURVE", "FONT", "SURFACE", "META"}


@dataclass
class Receiver:
    """An object that gets a lightmap."""

    name: str
    shape: tuple  # what of its mesh must not change during the bake
    applied: str = ""  # name of the mesh as its modifiers make it, where they add or remove faces


@dataclass
class Sent:
    """What was exported: receivers, and what a user should know."""

    receivers: list
    notes: list = field(default_factory=list)
    occluders: bool = False  # other objects were exported too
    lit: list = field(default_factory=list)  # flags of the light of the scene, where that is asked for


def shape(mesh):
    """Tells whether corners still mean what they meant: counts, and which corner uses which vertex."""
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", vertices)
    totals = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", totals)
    return len(mesh.vertices), vertices.tobytes(), totals.tobytes()


def export(context, settings, path):
    """Writes the visible scene to `path`, receivers marked, and says what was left out. A ValueError where nothing can
    be baked."""
    sent = Sent([])
    with contextlib.ExitStack() as undo:
        undo.callback(_select, context.view_layer, list(context.selected_objects))
        selected = {item.get(copies.OF, item) for item in context.selected_objects}
        undo.callback(copies.show_originals())
        context.view_layer.update()
        hidden = rendered.hidden(context)
        chosen = _chosen(context, settings, hidden, selected, sent)
        receivers = []
        for item in chosen:
            receiver = _prepare(context, item, sent, undo)
            if receiver:
                receivers.append((item, receiver))
        if not receivers:
            raise ValueError("; ".join(["no object can get a lightmap", *sent.notes]))
        for mesh in {item.data for item, _ in receivers}:
            _number(mesh, undo)
        for item in hidden:
            if item.instance_type == "COLLECTION":
                undo.callback(setattr, item, "instance_type", "COLLECTION")
                item.instance_type = "NONE"
        for material in bpy.data.materials:
            undo.callback(nodes.bypass(material))
        context.view_layer.update()
        _export_gltf(path)
        paths = {item.name: _path(item) for item, _ in receivers}
        old = {item.name: _earlier(item.data) for item, _ in receivers}
    glb = Glb.read(path)
    corners.leave_out(glb, {item.name for item in hidden})
    items = [item for item in bpy.data.objects if item.type in _KINDS and item not in hidden]
    corners.let_through(glb, rendered.uncast(items, sent.notes))
    materials.mend(glb, sent.notes)
    shines = corners.shines(glb)
    if shines and settings.bounces == 0:
        sent.notes.append("materials that shine light nothing without a bounce: set Bounces to 1 or more")
    if settings.light == "SCENE":
        sent.lit, spots = scene_light.gather(context, os.path.dirname(path), hidden, shines, sent.notes)
        lamps.add_spots(glb, spots)
    found, sent.occluders = corners.set_apart(glb, paths)
    corners.drop_uv_sets(glb, old)
    glb.write(path)
    sent.receivers = [receiver for _, receiver in receivers if receiver.name in found]
    for _, receiver in receivers:
        if receiver.name not in found:
            sent.notes.append(f"{receiver.name} was not exported")
            forget(receiver)
    if not sent.receivers:
        raise ValueError("; ".join(["no object can get a lightmap", *sent.notes]))
    return sent


def _select(layer, items):
    """Selects what was selected: Blender forgets that of what is hidden for a while."""
    layer.update()
    for item in items:
        item.select_set(True, view_layer=layer)


def forget(receiver):
    """Removes what `export` made for a receiver that is not baked after all."""
    mesh = bpy.data.meshes.get(receiver.applied) if receiver.applied else None
    if mesh and mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def _chosen(context, settings, hidden, selected, sent):
    """Objects that are asked to get a lightmap."""
    visible = [item for item in context.view_layer.objects if item.visible_get() and item not in hidden]
    if settings.targets == "SELECTED":
        visible = [item for item in visible if item in selected]
    meshes = [item for item in visible if item.type == "MESH" and len(item.data.polygons)]
    for what, kinds in [("curve, text or surface", _KINDS - {"MESH"})]:
        others = [item.name for item in visible if item.type in kinds]
        if others:
            sent.notes.append(f"{listed(others)} only cast{s(others)} shadows: convert each {what} to a mesh first")
    instanced = [item.name for item in visible if item.instance_type != "NONE"]
    if instanced:
        sent.notes.append(f"instances of {listed(instanced)} only cast shadows: make them real first")
    if not meshes:
        raise ValueError(f"no {settings.targets.lower()} mesh has a face to bake")
    return meshes


def _prepare(context, item, sent, undo):
    """The object as receiver; None, with a note, where it can only cast shadows."""
    mesh = item.data
    if not mesh.is_editable or not item.is_editable:
        sent.notes.append(f"{item.name} only casts shadows: it is linked from another file")
        return None
    if len(mesh.loops) >= corners.MOST_CORNERS:
        sent.notes.append(f"{item.name} only casts shadows: it has over 16 million corners, split it")
        return None
    evaluated = item.evaluated_get(context.evaluated_depsgraph_get())
    result = evaluated.to_mesh()
    same = shape(result) == shape(mesh)
    evaluated.to_mesh_clear()
    if same:
        return Receiver(item.name, shape(mesh))
    graph = context.evaluated_depsgraph_get()
    real = bpy.data.meshes.new_from_object(item.evaluated_get(graph), preserve_all_data_layers=True, depsgraph=graph)
    real.name = mesh.name
    shown = [(modifier, modifier.show_viewport) for modifier in item.modifiers]

    def restore():
        item.data = mesh
        for modifier, was in shown:
            modifier.show_viewport = was

    undo.callback(restore)
    item.data = real
    for modifier, _ in shown:
        modifier.show_viewport = False
    return Receiver(item.name, shape(real), real.name)


def _earlier(mesh):
    """The numbers of the UV maps that earlier bakes wrote."""
    return [n for n, layer in enumerate(mesh.uv_layers) if layer.name in copies.marked(mesh)]


def _number(mesh, undo):
    """Numbers the corners of a mesh until the export is over."""
    attribute = mesh.attributes.new(corners.ATTRIBUTE, "FLOAT", "CORNER")
    name = attribute.name
    attribute.data.foreach_set("value", np.arange(len(mesh.loops), dtype=np.float32))
    undo.callback(lambda: mesh.attributes.remove(mesh.attributes[name]))


def _export_gltf(path):
    wanted = {
        "export_format": "GLB",
        "use_visible": True,
        "use_active_scene": True,
        "export_apply": True,
        "export_attributes": True,
        "export_animations": False,
        "export_skins": False,
        "export_morph": False,
        "export_extras": False,
        "export_yup": True,
        "export_gpu_instances": False,
        "check_existing": False,
    }
    known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
    bpy.ops.export_scene.gltf(filepath=path, **{k: v for k, v in wanted.items() if k in known})


def _path(item):
    names = []
    while item:
        names.append(item.name)
        item = item.parent
    return names[::-1]
