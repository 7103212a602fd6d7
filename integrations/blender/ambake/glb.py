"""GLB files as plain JSON and numpy arrays. Knows what Blender's exporter and ambake write, nothing of Blender."""

import json
import struct

import numpy as np

_MAGIC, _JSON, _BIN = 0x46546C67, 0x4E4F534A, 0x004E4942
_TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    """A GLB file: `json` is its document, `binary` its first buffer."""

    def __init__(self, document, binary):
        self.json = document
        self.binary = binary

    @classmethod
    def read(cls, path):
        """The file at `path`; a ValueError names it where it is no GLB."""
        with open(path, "rb") as file:
            data = file.read()
        document, binary, at = None, b"", 12
        if len(data) < 20 or struct.unpack_from("<I", data)[0] != _MAGIC:
            raise ValueError(f"{path} is not a GLB file")
        while at + 8 <= len(data):
            length, kind = struct.unpack_from("<II", data, at)
            chunk = data[at + 8 : at + 8 + length]
            if kind == _JSON:
                document = json.loads(chunk)
            elif kind == _BIN:
                binary = chunk
            at += 8 + length
        if document is None:
            raise ValueError(f"{path} has no glTF document")
        return cls(document, binary)

    def write(self, path):
        """Writes it to `path`."""
        text = json.dumps(self.json, ensure_ascii=False, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        binary = self.binary + b"\0" * (-len(self.binary) % 4)
        chunks = struct.pack("<II", len(text), _JSON) + text
        if binary:
            chunks += struct.pack("<II", len(binary), _BIN) + binary
        with open(path, "wb") as file:
            file.write(struct.pack("<III", _MAGIC, 2, 12 + len(chunks)) + chunks)

    def accessor(self, number):
        """Its elements, one a row."""
        accessor = self.json["accessors"][number]
        dtype = np.dtype(_TYPES[accessor["componentType"]])
        count, width = accessor["count"], _WIDTHS[accessor["type"]]
        view = self.json["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride") or width * dtype.itemsize
        shape, strides = (count, width), (stride, dtype.itemsize)
        return np.ndarray(shape, dtype, self.binary, start, strides)

    def mesh_nodes(self):
        """The nodes that have a mesh, as (node, names of its parents and itself)."""
        nodes = self.json.get("nodes", [])
        parents = {child: n for n, node in enumerate(nodes) for child in node.get("children", [])}

        def path(number):
            names = []
            while number is not None:
                names.append(nodes[number].get("name", ""))
                number = parents.get(number)
            return names[::-1]

        return [(node, path(n)) for n, node in enumerate(nodes) if "mesh" in node]
