"""The light of the scene for a bake: the world and the lamps that render, and what a user should know of it."""

import numpy as np

from . import lamps, world
from .rendered import listed


def gather(context, folder, hidden, shines, notes):
    """Flags of ambake, and spots for the file. `hidden` holds the objects that do not render, `shines` tells whether a
    material sends light."""
    graph = context.evaluated_depsgraph_get()
    found = lamps.Lamps(*_extent(graph))
    for instance in graph.object_instances:
        if instance.object.type != "LIGHT" or not instance.show_self:
            continue
        item = instance.object.original
        stands = instance.parent.original if instance.is_instance else item
        if item in hidden or stands in hidden or not stands.visible_get() or not item.visible_diffuse:
            continue
        if getattr(getattr(item.data, "cycles", None), "is_portal", False):
            continue
        found.add(item.name, instance.object.data, instance.matrix_world)
        if _linked(item):
            found.say("baked without light linking", item.name)
    notes += [f"of the lamps {listed(names)}: {words}" for words, names in found.approximated.items()]
    sky = world.sky(context, folder, notes)
    if sky == "0,0,0" and not found.flags and not found.spots and not shines:
        notes.append("no lamp, no world and no material lights the scene: add one, or choose Sky of ambake as light")
    flags = ["--sky", sky, *found.flags]
    return flags + ["--lights", "file"] * bool(found.spots), found.spots


def _extent(graph):
    """Middle in glTF's axes and size of the box about all meshes."""
    corners = [
        np.array(instance.matrix_world) @ (*corner, 1.0)
        for instance in graph.object_instances
        if instance.object.type == "MESH"
        for corner in instance.object.bound_box
    ]
    if not corners:
        return (0.0, 0.0, 0.0), 0.0
    low, high = np.min(corners, axis=0)[:3], np.max(corners, axis=0)[:3]
    return lamps.AXES @ (low + high) / 2.0, float(np.max(high - low))


def _linked(item):
    linking = getattr(item, "light_linking", None)
    return linking is not None and (linking.receiver_collection is not None or linking.blocker_collection is not None)
