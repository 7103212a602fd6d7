"""Reads the pages that ambake writes: OpenEXR, one part, scan lines, ZIP, 32-bit floats. Blender itself reads only
channels that are called R, G and B. The format: openexr.com, "OpenEXR File Layout"."""

import struct
import zlib

import numpy as np

_FLOAT, _ZIP, _LINES = 2, 3, 16


class Page:
    """One page: `channels` are its names, `channel(name)` the values with row 0 at the top."""

    def __init__(self, path):
        with open(path, "rb") as file:
            self._data = file.read()
        self._path = path
        if self._data[:4] != b"\x76\x2f\x31\x01":
            raise ValueError(f"{path} is not an OpenEXR file")
        self.channels, at = [], 8
        while self._data[at]:
            name, at = self._text(at)
            _, at = self._text(at)
            size = struct.unpack_from("<i", self._data, at)[0]
            self._attribute(name, at + 4, at + 4 + size)
            at += 4 + size
        self._table = at + 1
        self._planes = None

    def _text(self, at):
        end = self._data.index(b"\0", at)
        return self._data[at:end].decode(), end + 1

    def _attribute(self, name, at, end):
        if name == "channels":
            while self._data[at]:
                channel, at = self._text(at)
                if struct.unpack_from("<i", self._data, at)[0] != _FLOAT:
                    raise ValueError(f"{self._path}: channel {channel} does not hold 32-bit floats")
                self.channels.append(channel)
                at += 16
        elif name == "compression" and self._data[at] != _ZIP:
            raise ValueError(f"{self._path} is not compressed as ambake's pages are")
        elif name == "dataWindow":
            left, top, right, bottom = struct.unpack_from("<4i", self._data, at)
            self.width, self.height = right - left + 1, bottom - top + 1

    def channel(self, name):
        """(height, width) floats; a ValueError where there is no such channel."""
        if name not in self.channels:
            raise ValueError(f"{self._path} has no channel {name}; it has {', '.join(self.channels)}")
        if self._planes is None:
            self._planes = self._decode()
        return self._planes[self.channels.index(name)]

    def layer(self, name):
        """(height, width, 3) floats of a layer; a layer of one channel is grey."""
        if name in self.channels:
            return np.repeat(self.channel(name)[..., None], 3, axis=2)
        return np.stack([self.channel(f"{name}.{c}") for c in self._suffixes(name)], axis=2)

    def _suffixes(self, name):
        return "XYZ" if f"{name}.X" in self.channels else "RGB"

    def _decode(self):
        planes = np.empty((len(self.channels), self.height, self.width), np.float32)
        blocks = -(-self.height // _LINES)
        for block, at in enumerate(struct.unpack_from(f"<{blocks}Q", self._data, self._table)):
            size = struct.unpack_from("<i", self._data, at + 4)[0]
            rows = min(_LINES, self.height - block * _LINES)
            packed = self._data[at + 8 : at + 8 + size]
            wanted = rows * len(self.channels) * self.width * 4
            raw = packed if size == wanted else _unzip(packed)
            lines = np.frombuffer(raw, "<f4").reshape(rows, len(self.channels), self.width)
            planes[:, block * _LINES : block * _LINES + rows] = lines.transpose(1, 0, 2)
        return planes


def _unzip(packed):
    """Undoes OpenEXR's ZIP: deflate, then differences of bytes, then halves interleaved."""
    coded = np.frombuffer(zlib.decompress(packed), np.uint8).astype(np.int64)
    coded[1:] -= 128
    plain = (np.cumsum(coded) & 255).astype(np.uint8)
    result, half = np.empty_like(plain), (len(plain) + 1) // 2
    result[0::2], result[1::2] = plain[:half], plain[half:]
    return result.tobytes()
