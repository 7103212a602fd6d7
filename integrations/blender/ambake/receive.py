"""Brings a finished bake back onto the objects it was made from: UV map, images, materials."""

import os

import bmesh
import bpy
import numpy as np

from . import command, copies, corners, linked, nodes
from .exr import Page
from .glb import Glb
from .send import forget, shape


def bring_back(scene, settings, sent, folder, report):
    """Gives every receiver its lightmap. Returns the number of objects and notes for the user."""
    stem = os.path.splitext(next(name for name in report["files"] if name.endswith(".glb")))[0]
    stem = os.path.basename(stem)
    parts = corners.baked(Glb.read(os.path.join(folder, f"{stem}.glb")))
    images = _images(settings, folder, stem, report)
    notes = list(sent.notes)
    earlier, copied, done = copies.all_of_them(), 0, {}
    found = []
    for receiver in sent.receivers:
        item = bpy.data.objects.get(receiver.name)
        part = parts.get(receiver.name)
        problem = _problem(item, receiver, part)
        if problem:
            notes.append(f"{receiver.name} got no lightmap: {problem}")
            forget(receiver)
            continue
        mesh = bpy.data.meshes[receiver.applied] if receiver.applied else item.data
        found.append((item, mesh, part))
    taken = set()
    for group in linked.groups([(mesh, part) for _, mesh, part in found]):
        items = [found[number][0] for number, _ in group]
        _, mesh, part = found[group[0][0]]
        unfolded = _unfold(mesh, part)
        applied = mesh != items[0].data
        # What shows the bake: the mesh itself, or one that holds other polygons or is laid out in another way.
        if not applied and (unfolded.cut or mesh in taken):
            mesh = mesh.copy()
        taken.add(mesh)
        problem, pages, first = _write(mesh, unfolded, settings.uv_map)
        if problem:
            notes += [f"{item.name} got no lightmap: {problem}" for item in items]
            if mesh != items[0].data:
                bpy.data.meshes.remove(mesh)
            continue
        for item, (_, place) in zip(items, group):
            if mesh != item.data:
                item = copies.make(scene, item, mesh, applied, earlier.get(item))
                copied += 1
            else:
                copies.remove(item, earlier.get(item))
            place.after(first).put(item)
            done[item] = place.page(pages)
    if copied:
        notes.append(f"{copied} object{'s are' if copied > 1 else ' is'} shown by baked copies in the collection "
                     f"{copies.COLLECTION}; Show Originals goes back")
    copies.select(scene)
    nodes.show(done, images, settings.show, settings.uv_map)
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
            images[layer, number] = _image(f"{settings.image_name or stem} {layer} {number}", exr.layer(layer))
    return images


def _image(name, values):
    """A float image inside the .blend. An earlier one of the name makes way, and whatever shows it shows the new
    one."""
    height, width = values.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=False, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = values[::-1]
    image.pixels.foreach_set(pixels.reshape(-1))
    image.update()
    image.pack()
    # A layer that no material shows is kept when the file is saved.
    image.use_fake_user = True
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


def _write(mesh, unfolded, uv_map):
    """Writes the UV map, and cuts polygons that a chart or a page ends inside of. Returns why it could not, or None
    with the page of each polygon and the place of the layout as seen from the UV map."""
    uvs = unfolded.uvs.astype(np.float32)
    layer = mesh.uv_layers.get(uv_map)
    if layer and uv_map not in copies.marked(mesh):
        own = np.empty_like(uvs)
        layer.uv.foreach_get("vector", own.reshape(-1))
        if not unfolded.cut and np.abs(own - uvs).max(initial=0.0) <= 1e-4:
            return None, unfolded.pages, linked.Place()
        place = None if unfolded.cut else linked.fit(own.astype(float), unfolded.uvs, 1e-4)
        problem = f"its own UV map {uv_map} cannot be the layout as it stands; choose another name"
        return (None, unfolded.pages, place) if place else (problem, None, None)
    layer = layer or mesh.uv_layers.new(name=uv_map, do_init=False)
    if layer is None:
        return "it has eight UV maps already, remove one", None, None
    copies.mark(mesh, uv_map)
    layer.uv.foreach_set("vector", uvs.reshape(-1))
    return None, _cut(mesh, unfolded, uv_map) if unfolded.cut else unfolded.pages, linked.Place()


def _cut(mesh, unfolded, uv_map):
    """Replaces torn polygons by their triangles, which keep everything else that their corners had."""
    edit = bmesh.new()
    edit.from_mesh(mesh)
    # A new layer moves the data of all faces, so it comes before anything is looked up.
    page = edit.faces.layers.int.new("ambake page")
    uv = edit.loops.layers.uv[uv_map]
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
