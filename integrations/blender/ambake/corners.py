"""Which lightmap coordinates each corner of each object got. Knows GLB files and numbers, nothing of Blender.

Before the export every corner (Blender: loop) of a mesh is numbered in an attribute. The exporter splits and reorders
vertices, ambake cuts charts; the number stays with the corner, so nothing is matched by position."""

import re
from dataclasses import dataclass

import numpy as np

# Attributes whose names begin with an underscore are an application's own in glTF.
ATTRIBUTE = "_AMBAKE_CORNER"
# The exporter stores numbers as 32-bit floats, which count this far without a gap.
MOST_CORNERS = 1 << 24
# Objects with this before their names cast shadows and take no texels.
OCCLUDER = "ambake-occluder: "
# Property of a mesh that names the UV maps which bakes wrote.
MARK = "ambake UV map"


@dataclass
class Baked:
    """An object's triangles: numbers of their corners, coordinates (v grows up) and page."""

    corners: np.ndarray  # (triangles, 3) integers
    uvs: np.ndarray  # (triangles, 3, 2) floats
    pages: np.ndarray  # (triangles,) integers


def set_apart(glb, receivers):
    """Renames every object that takes no texels, so that one `--exclude` names them all.

    `receivers` maps the names of those that do to the names of their parents and themselves. A collection instance
    repeats names; the object itself is the one below its own parents. Returns the names that were found, and whether
    anything else casts shadows."""
    nodes = glb.mesh_nodes()
    counts = {}
    for node, _ in nodes:
        counts[node.get("name")] = counts.get(node.get("name"), 0) + 1
    found, others = set(), False
    for node, path in nodes:
        name = node.get("name", "")
        alone = counts[node.get("name")] == 1
        if name in receivers and name not in found and (alone or path == receivers[name]):
            found.add(name)
        else:
            node["name"], others = OCCLUDER + name, True
    return found, others


def leave_out(glb, names):
    """Takes the surfaces of these objects out of the file, whatever stands below them."""
    for node, path in glb.mesh_nodes():
        if path[-1] in names:
            del node["mesh"]


def let_through(glb, names):
    """Lets these objects block no light."""
    for node, path in glb.mesh_nodes():
        if path[-1] in names:
            node.setdefault("extras", {})["ambake"] = {"cast": False}


def shines(glb):
    """Whether a material sends light of its own."""
    return any(any(material.get("emissiveFactor", ())) for material in glb.json.get("materials", ()))


def drop_uv_sets(glb, mesh_sets):
    """Takes the UV sets of earlier bakes out of meshes, so that they are not taken for the artist's.

    `mesh_sets` maps names of nodes to the numbers of these sets. Only last sets can go: glTF wants them without
    gaps."""
    for node, path in glb.mesh_nodes():
        for primitive in glb.json["meshes"][node["mesh"]]["primitives"]:
            attributes = primitive["attributes"]
            for number in sorted(mesh_sets.get(path[-1], ()), reverse=True):
                if f"TEXCOORD_{number + 1}" not in attributes:
                    attributes.pop(f"TEXCOORD_{number}", None)


def baked(glb):
    """What each object got, by its name. Objects without texels are not among them."""
    result = {}
    for node, path in glb.mesh_nodes():
        parts = [_part(glb, p) for p in glb.json["meshes"][node["mesh"]]["primitives"]]
        parts = [part for part in parts if part is not None]
        if parts and not path[-1].startswith(OCCLUDER):
            result[path[-1]] = Baked(*(np.concatenate(list(of)) for of in zip(*parts)))
    return result


def _part(glb, primitive):
    attributes = primitive["attributes"]
    found = _occlusion(glb, primitive)
    if found is None or ATTRIBUTE not in attributes:
        return None
    page, uv_set = found
    triangles = glb.accessor(primitive["indices"])[:, 0].reshape(-1, 3)
    numbers = glb.accessor(attributes[ATTRIBUTE])[:, 0]
    corners = np.rint(numbers).astype(np.int64)[triangles]
    uvs = glb.accessor(attributes[f"TEXCOORD_{uv_set}"]).astype(np.float64)[triangles]
    uvs[..., 1] = 1.0 - uvs[..., 1]
    return corners, uvs, np.full(len(triangles), page)


def _occlusion(glb, primitive):
    """Page and UV set of the occlusion texture, which ambake calls STEM.PAGE.occlusion."""
    if "material" not in primitive:
        return None
    texture = glb.json["materials"][primitive["material"]].get("occlusionTexture")
    if texture is None:
        return None
    source = glb.json["textures"][texture["index"]].get("source")
    name = glb.json["images"][source].get("name", "") if source is not None else ""
    page = re.search(r"\.(\d+)\.occlusion$", name)
    return (int(page[1]), texture.get("texCoord", 0)) if page else None


@dataclass
class Unfolded:
    """Coordinates of a mesh with polygons."""

    uvs: np.ndarray  # (corners, 2)
    pages: np.ndarray  # (polygons,); -1 where the polygon has no texel
    cut: dict  # polygon -> its triangles as (corners (3,), uvs (3, 2), page), where a chart or a page ends inside of it


def unfold(part, starts, totals):
    """Carries triangles onto polygons. `starts` and `totals` are the first corner and the number of corners of each
    polygon, in order."""
    count = int(totals.sum())
    polygon_of = np.repeat(np.arange(len(totals)), totals)
    flat, coordinates = part.corners.reshape(-1), part.uvs.reshape(-1, 2)
    uvs = np.full((count, 2), np.nan)
    uvs[flat] = coordinates
    pages = np.full(len(totals), -1)
    of_triangle = polygon_of[part.corners[:, 0]]
    pages[of_triangle] = part.pages
    apart = np.abs(uvs[flat] - coordinates).max(axis=1) > 1e-6
    torn = set(polygon_of[flat[apart]].tolist()) | set(of_triangle[pages[of_triangle] != part.pages].tolist())
    cut = {polygon: [] for polygon in torn}
    if torn:
        for t in np.flatnonzero(np.isin(of_triangle, list(torn))):
            cut[int(of_triangle[t])].append((part.corners[t], part.uvs[t], int(part.pages[t])))
    # A corner of triangles without area alone: no texel shows it, any place inside of its polygon will do.
    for corner in np.flatnonzero(np.isnan(uvs[:, 0])):
        polygon = polygon_of[corner]
        own = uvs[starts[polygon] : starts[polygon] + totals[polygon]]
        known = own[~np.isnan(own[:, 0])]
        uvs[corner] = known[0] if len(known) else 0.0
    return Unfolded(uvs, pages, cut)
