"""Objects that share a mesh share the UV map of their lightmap too: ambake lays a mesh out once, and each object has a
rectangle of texels of its own. Two properties of the object carry the map there.

    place on the page = UV + UV * growth + offset

An object without the properties is one whose UV map says the place itself."""

import numpy as np

# Properties of an object: three numbers each, of which the third is 0.
GROWTH, OFFSET = "ambake growth", "ambake offset"
# How far places of corners may lie from where the rectangle puts them: a 60th of a texel on a page of 16384.
_APART = 1e-6


class Place:
    """Where an object lies, as seen from a UV map: a scale and an offset in u and v, and how many pages later than
    what the map was made for."""

    def __init__(self, scale=(1.0, 1.0), offset=(0.0, 0.0), pages=0):
        self.scale, self.offset, self.pages = scale, offset, pages

    def put(self, item):
        """Tells an object its place."""
        forget(item)
        if self.scale != (1.0, 1.0) or self.offset != (0.0, 0.0):
            item[GROWTH] = (self.scale[0] - 1.0, self.scale[1] - 1.0, 0.0)
            item[OFFSET] = (*self.offset, 0.0)

    def page(self, pages):
        """The pages of polygons, of which the UV map was made for these."""
        return np.where(pages < 0, pages, pages + self.pages)

    def after(self, first):
        """The place that `first` leads to and this one from there."""
        scale = tuple(a * b for a, b in zip(first.scale, self.scale))
        offset = tuple(a * b + c for a, b, c in zip(first.offset, self.scale, self.offset))
        return Place(scale, offset, self.pages)


def forget(item):
    """Takes the place of an earlier bake away."""
    for name in (GROWTH, OFFSET):
        item.pop(name, None)


def fit(old, new, apart):
    """The place that carries coordinates onto others, each (corners, 2), to within `apart`; None where none does."""
    scale, offset = [], []
    for a, b in zip(old.T, new.T):
        low, high = a.argmin(), a.argmax()
        if a[high] <= a[low]:
            return None
        scale.append(float((b[high] - b[low]) / (a[high] - a[low])))
        offset.append(float(b[low] - a[low] * scale[-1]))
        if np.abs(a * scale[-1] + offset[-1] - b).max() > apart:
            return None
    return Place(tuple(scale), tuple(offset))


def _place(first, other):
    """The place of an object whose triangles are `other` (`corners.Baked`), as seen from one with the triangles
    `first`; None where no rectangle says it."""
    if first.corners.shape != other.corners.shape or (first.corners != other.corners).any():
        return None
    later = other.pages - first.pages
    found = fit(first.uvs.reshape(-1, 2), other.uvs.reshape(-1, 2), _APART)
    if found is None or (later != later[0]).any():
        return None
    found.pages = int(later[0])
    return found


def groups(parts):
    """Objects that one UV map serves. `parts` are pairs of the mesh and the triangles of each object. Returns a list
    of groups, each a list of pairs: the number of an object, and its place as seen from the first of its group."""
    found = []
    for number, (mesh, part) in enumerate(parts):
        for group in found:
            first_mesh, first = parts[group[0][0]]
            its = _place(first, part) if first_mesh == mesh else None
            if its:
                group.append((number, its))
                break
        else:
            found.append([(number, Place())])
    return found
