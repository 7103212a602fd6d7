"""Baked copies: objects whose own mesh cannot hold a lightmap are shown by a copy in a collection of its own, and
hidden.

That is so where modifiers add or remove faces, where ambake cuts a polygon, and where objects share a mesh that
modifiers bend in different ways."""

import bpy

from .corners import MARK

COLLECTION = "ambake baked"
# Property of a copy: the object that it stands for.
OF = "ambake of"
# Property of a new copy: that its object was selected.
CHOSEN = "ambake chosen"
# Property of an object: that a copy stands for it, and it is hidden for that.
HIDDEN = "ambake hidden"


def all_of_them():
    """The copy of each object that has one."""
    collection = bpy.data.collections.get(COLLECTION)
    found = {item.get(OF): item for item in collection.objects} if collection else {}
    found.pop(None, None)
    return found


def shown():
    """Whether the copies are shown, and not the objects that they stand for."""
    return any(not copy.hide_render for copy in all_of_them().values())


def show(on):
    """Shows the copies, or the objects that they stand for. Those whose copies were deleted are shown in either
    case."""
    pairs = all_of_them()
    for original, copy in pairs.items():
        original.hide_viewport = original.hide_render = on
        copy.hide_viewport = copy.hide_render = not on
    for item in bpy.data.objects:
        if item.get(HIDDEN) and item not in pairs:
            _unhide(item)


def show_originals():
    """Shows the objects that copies stand for. Returns what puts them and the copies back as they were."""
    pairs = all_of_them()
    before = [(item, item.hide_viewport, item.hide_render) for pair in pairs.items() for item in pair]
    show(False)

    def back():
        for item, viewport, render in before:
            item.hide_viewport, item.hide_render = viewport, render

    return back


def _unhide(item):
    item.hide_viewport = item.hide_render = False
    item.pop(HIDDEN, None)


def make(scene, item, mesh, applied, old):
    """A copy of an object that shows `mesh`, in place of the old one; without modifiers where they are applied."""
    seen = bpy.context.view_layer.objects
    chosen = any(of.name in seen and of.select_get() for of in (item, old) if of)
    remove(item, old)
    copy = item.copy()
    copy[CHOSEN] = chosen
    copy.name, copy.data = f"{item.name} baked", mesh
    copy.hide_viewport = copy.hide_render = False
    if applied:
        copy.modifiers.clear()
    copy[OF] = item
    collection = bpy.data.collections.get(COLLECTION) or bpy.data.collections.new(COLLECTION)
    if collection not in scene.collection.children_recursive:
        scene.collection.children.link(collection)
    collection.objects.link(copy)
    item.hide_viewport = item.hide_render = item[HIDDEN] = True
    return copy


def select(scene):
    """Selects the new copies of what was selected, so that a second bake finds the same."""
    for layer in scene.view_layers:
        layer.update()
        for copy in all_of_them().values():
            if copy.pop(CHOSEN, False) and copy.name in layer.objects:
                copy.select_set(True, view_layer=layer)


def remove(item, old):
    """Takes the old copy of an object away, if it has one, and shows the object."""
    if old is None:
        return
    mesh = old.data
    bpy.data.objects.remove(old)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)
    _unhide(item)


def marked(mesh):
    """The names of the UV maps of a mesh that bakes wrote."""
    return [name for name in mesh.get(MARK, "").split("\n") if name]


def mark(mesh, uv_map):
    """Remembers that a bake wrote this UV map."""
    mesh[MARK] = "\n".join(dict.fromkeys([*marked(mesh), uv_map]))
