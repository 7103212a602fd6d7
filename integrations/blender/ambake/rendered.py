"""Which objects of a scene render, and which of them block light: what the outliner's camera and Ray Visibility say."""

import bpy


def hidden(context):
    """The objects that are disabled in renders, each by itself or by all collections of the scene that hold it."""
    shown = _shown(context.view_layer.layer_collection)
    scene = {context.scene.collection, *context.scene.collection.children_recursive}
    found = set()
    for item in bpy.data.objects:
        holders = [holder for holder in item.users_collection if holder in scene]
        if holders:
            off = not any(holder in shown for holder in holders)
        else:
            # It stands in the scene as an instance alone.
            off = bool(item.users_collection) and all(holder.hide_render for holder in item.users_collection)
        if item.hide_render or off:
            found.add(item)
    return found


def uncast(items, notes):
    """The names of those that Ray Visibility takes from what blocks light. ambake has one switch for lamps and sky,
    Cycles has two, so a note names those for which they differ."""
    found = [item for item in items if not (item.visible_shadow and item.visible_diffuse)]
    half = [item.name for item in found if item.visible_shadow or item.visible_diffuse]
    if half:
        notes.append(
            f"{listed(half)} block{s(half)} neither lamps nor sky: Ray Visibility has one of Shadow and Diffuse off, "
            "and ambake knows both or none"
        )
    return {item.name for item in found}


def listed(names):
    """The names of a sentence: three of them, and how many more."""
    return ", ".join(names[:3]) + (f" and {len(names) - 3} more" if len(names) > 3 else "")


def s(names):
    """The ending of the verb that follows these names."""
    return "s" if len(names) == 1 else ""


def _shown(layer):
    """The collections of a view layer that render: none above them is excluded or disabled."""
    if layer.exclude or layer.collection.hide_render:
        return set()
    return {layer.collection}.union(*(_shown(child) for child in layer.children))
