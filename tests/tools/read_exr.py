"""Read one EXR page with OpenEXR's own Python package and print what it holds as JSON.

Usage: read_exr.py FILE. Exit status 77 where the package OpenEXR is absent (`pip install -r requirements.txt`).
"""

import json
import sys

try:
    import OpenEXR
except ImportError:
    sys.exit(77)

with OpenEXR.File(sys.argv[1], separate_channels=True) as file:
    header = file.header()
    channels = {}
    for name, channel in file.channels().items():
        pixels = channel.pixels
        bits = 0
        for word in pixels.view("uint32").ravel().tolist():
            bits = (bits * 31 + word) & 0xFFFFFFFF
        channels[name] = {
            "type": str(pixels.dtype),
            "first": float(pixels[0, 0]),
            "last": float(pixels[-1, -1]),
            "hash": bits,
        }
    print(
        json.dumps(
            {
                "width": pixels.shape[1],
                "height": pixels.shape[0],
                "compression": header["compression"].name.removesuffix("_COMPRESSION"),
                "attributes": {k: v for k, v in header.items() if isinstance(v, str)},
                "channels": channels,
            }
        )
    )
