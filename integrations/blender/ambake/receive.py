"""Brings a finished bake back onto the objects it was made from: UV map, images, materials."""

import os

import bmesh
import bpy
import numpy as np

from . import command, corners, nodes
from .exr import Page
from .glb import Glb
from .send import forget, shape


def bring_back(settings, sent, folder, report):
    """Gives every receiver its lightmap. Returns the number of objects and notes for the user."""
    stem = os.path.splitext(next(name for name in report["files"] if name.endswith(".glb")))[0]
    stem = os.path.basename(stem)
    parts = corners.baked(Glb.read(os.path.join(folder, f"{stem}.glb")))
    images = _images(settings, folder, stem, report)
    notes = list(sent.notes)
    copied, done = [], []
    for receiver in sent.receivers:
        item = bpy.data.objects.get(receiver.name)
        part = parts.get(receiver.name)
        problem = _problem(item, receiver, part)
        if problem:
            notes.append(f"{receiver.name} got no lightmap: {problem}")
            forget(receiver)
            continue
        if receiver.applied:
            item.modifiers.clear()
            item.data = bpy.data.meshes[receiver.applied]
        elif item.data.users > 1:
            copied.append(item.name)
            item.data = item.data.copy()
        unfolded = _unfold(item.data, part)
        pages = _write(item.data, unfolded)
        if pages is None:
            notes.append(f"{item.name} got no lightmap: it has eight UV maps already, remove one")
            continue
        done.append((item, pages))
    if copied:
        notes.append(f"{len(copied)} object{'s' * (len(copied) > 1)} got a mesh of their own, for every lightmap differs")
    nodes.show([item for item, _ in done], dict(done), images, settings.show)
    return len(done), notes


def _problem(item, receiver, part):
    if item is None:
        return "it was removed or renamed during the bake"
    if part is None:
        return "it has no texels; its faces have no area, or --exclude names it"
    if receiver.applied:
        return None if receiver.applied in bpy.data.meshes else "it was undone during the bake"
    if shape(item.data) != receiver.shape:
        return "its faces were changed during the bake; bake again"
    return None


def _images(settings, folder, stem, report):
    """Image of each (layer, page)."""
    images = {}
    for page in report["pages"]:
        number = page["page"]
        exr = Page(os.path.join(folder, f"{stem}.{number}.exr"))
        for layer in command.layers(settings):
            images[layer, number] = _image(f"{stem} {layer} {number}", exr.layer(layer))
    return images


def _image(name, values):
    """A float image inside the .blend. An earlier one of the name makes way, and whatever shows it shows the new one."""
    height, width = values.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=False, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = values[::-1]
    image.pixels.foreach_set(pixels.reshape(-1))
    image.update()
    image.pack()
    old = bpy.data.images.get(name)
    if old is not None and old != image:
        old.user_remap(image)
        bpy.data.images.remove(old)
        image.name = name
    return image


def _unfold(mesh, part):
    starts, totals = (np.empty(len(mesh.polygons), np.int32) for _ in range(2))
    mesh.polygons.foreach_get("loop_start", starts)
    mesh.polygons.foreach_get("loop_total", totals)
    return corners.unfold(part, starts, totals)


def _write(mesh, unfolded):
    """Writes the UV map, cuts polygons that a chart or a page ends inside of, and returns the page of each polygon; None
    where the mesh cannot hold another UV map."""
    layer = mesh.uv_layers.get(corners.UV_MAP) or mesh.uv_layers.new(name=corners.UV_MAP, do_init=False)
    if layer is None:
        return None
    layer.uv.foreach_set("vector", unfolded.uvs.astype(np.float32).reshape(-1))
    if not unfolded.cut:
        return unfolded.pages
    return _cut(mesh, unfolded)


def _cut(mesh, unfolded):
    """Replaces torn polygons by their triangles, which keep everything else that their corners had."""
    edit = bmesh.new()
    edit.from_mesh(mesh)
    # A new layer moves the data of all faces, so it comes before anything is looked up.
    page = edit.faces.layers.int.new("ambake page")
    uv = edit.loops.layers.uv[corners.UV_MAP]
    faces = list(edit.faces)
    for face in faces:
        face[page] = int(unfolded.pages[face.index])
    old = []
    starts = np.concatenate([[0], np.cumsum([len(face.loops) for face in faces])])
    for polygon, triangles in unfolded.cut.items():
        face = faces[polygon]
        loops = list(face.loops)
        for numbers, uvs, number in triangles:
            of = [loops[corner - starts[polygon]] for corner in numbers]
            new = edit.faces.new([loop.vert for loop in of], face)
            new[page] = number
            for k in range(3):
                new.loops[k].copy_from(of[k])
                new.loops[k][uv].uv = uvs[k]
        old.append(face)
    bmesh.ops.delete(edit, geom=old, context="FACES_ONLY")
    edit.faces.index_update()
    pages = np.array([face[page] for face in edit.faces])
    edit.faces.layers.int.remove(page)
    edit.to_mesh(mesh)
    edit.free()
    return pages
