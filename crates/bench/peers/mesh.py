"""Reads ambake's written GLB and rasterises its lightmap coordinates, so that every baker gets the same texels."""

import json
import struct
import zlib

import numpy as np

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}


def read_glb(path):
    """Positions (n, 3), TEXCOORD_1 (n, 2) with v = 0 in row 0, faces (m, 3). Nodes must not move their meshes."""
    data = open(path, "rb").read()
    length = struct.unpack_from("<I", data, 12)[0]
    root = json.loads(data[20 : 20 + length])
    blob = data[28 + length :]

    def accessor(k):
        a = root["accessors"][k]
        view = root["bufferViews"][a["bufferView"]]
        kind, width = np.dtype(TYPES[a["componentType"]]), WIDTHS[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        return np.ndarray((a["count"], width), kind, blob, start, (stride, kind.itemsize))

    positions, coordinates, faces, base = [], [], [], 0
    for node in root["nodes"]:
        if "mesh" not in node:
            continue
        if {"matrix", "translation", "rotation", "scale"} & node.keys():
            raise ValueError(f"{path}: node {node.get('name')} is moved; give a scene without transforms")
        for primitive in root["meshes"][node["mesh"]]["primitives"]:
            attributes = primitive["attributes"]
            positions.append(accessor(attributes["POSITION"]))
            coordinates.append(accessor(attributes["TEXCOORD_1"]))
            faces.append(accessor(primitive["indices"]).reshape(-1, 3).astype(np.int64) + base)
            base += len(positions[-1])
    return np.concatenate(positions), np.concatenate(coordinates), np.concatenate(faces)


def texel_centres(positions, uv, faces, size):
    """Texel index, position and geometric normal of every texel whose centre lies in a triangle's chart."""
    corners = uv[faces].astype(np.float64) * size - 0.5
    low = np.maximum(np.ceil(corners.min(1)), 0).astype(np.int64)
    high = np.minimum(np.floor(corners.max(1)), size - 1).astype(np.int64)
    extent = np.maximum(high - low + 1, 0)
    count = extent[:, 0] * extent[:, 1]
    triangle = np.repeat(np.arange(len(faces)), count)
    inside = np.arange(len(triangle)) - np.repeat(np.cumsum(count) - count, count)
    x = low[triangle, 0] + inside % extent[triangle, 0]
    y = low[triangle, 1] + inside // extent[triangle, 0]
    a, b, c = corners[triangle, 0], corners[triangle, 1], corners[triangle, 2]
    p = np.stack((x, y), 1)

    def cross(u, v):
        return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]

    area = cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.stack((cross(c - b, p - b), cross(a - c, p - c), cross(b - a, p - a)), 1) / area[:, None]
    keep = (weight >= 0).all(1)
    texel, first = np.unique((y * size + x)[keep], return_index=True)
    triangle, weight = triangle[keep][first], weight[keep][first]
    at = positions[faces[triangle]].astype(np.float64)
    normal = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return texel, (at * weight[:, :, None]).sum(1), normal


def read_exr(path):
    """Channels by name, (rows, columns) float32, of a page that ambake writes: one part, rows of ZIP blocks of 16."""
    data = open(path, "rb").read()

    def text(at):
        end = data.index(b"\0", at)
        return data[at:end].decode(), end + 1

    at, names, size = 8, [], None
    while data[at]:
        name, at = text(at)
        kind, at = text(at)
        length = struct.unpack_from("<i", data, at)[0]
        value, at = at + 4, at + 4 + length
        if name == "channels":
            while data[value]:
                channel, value = text(value)
                names.append(channel)
                value += 16
        elif name == "dataWindow":
            x0, y0, x1, y1 = struct.unpack_from("<4i", data, value)
            size = (y1 - y0 + 1, x1 - x0 + 1)
    height, width = size
    planes = {name: np.empty(size, np.float32) for name in names}
    for block, offset in enumerate(struct.unpack_from(f"<{-(-height // 16)}Q", data, at + 1)):
        rows = min(16, height - 16 * block)
        length = struct.unpack_from("<i", data, offset + 4)[0]
        packed, plain = data[offset + 8 : offset + 8 + length], rows * width * 4 * len(names)
        if length < plain:
            steps = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
            steps[1:] -= 128
            halves = np.cumsum(steps).astype(np.uint8)
            packed = np.empty(plain, np.uint8)
            middle = (plain + 1) // 2
            packed[0::2], packed[1::2] = halves[:middle], halves[middle:]
        values = np.frombuffer(packed, np.float32).reshape(rows, len(names), width)
        for channel, name in enumerate(names):
            planes[name][16 * block : 16 * block + rows] = values[:, channel]
    return planes
