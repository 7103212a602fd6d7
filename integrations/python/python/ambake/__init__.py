"""ambake bakes ambient light into lightmaps, on the processor, and states the error.

    baked = ambake.bake(vertices, faces, size=256, rays=64)
    baked["diffuse"]      # (256, 256) float32, row 0 is v = 0
    baked.uvs             # (faces, 3, 2): where the corners of each face lie on the page

Options have the names of the flags of `ambake bake`, with underscores; `OPTIONS` lists them. Python's other threads run
during a bake, and Ctrl-C stops it.
"""

import copy
import os
import tempfile

import numpy as np

from . import _ambake
from ._ambake import LAYERS, OPTIONS, __version__

__all__ = ["LAYERS", "OPTIONS", "Baked", "Object", "Probes", "__version__", "bake", "bake_file", "probes"]

# Names of all layers, each with the suffixes of its channels.
LAYERS = dict(LAYERS)
# Names of all options.
OPTIONS = tuple(OPTIONS)


class Object:
    """An object of a baked scene, and where its faces lie.

    * `name`: its name; objects may share one.
    * `faces`: (n,) number of each face in the mesh that it came from; faces without area have been left out.
    * `pages`: (n,) page of each face.
    * `uvs`: (n, 3, 2) float32, the corners of each face in 0..1 of its page; v = 0 is row 0.
    * `corners`: (n, 3, 3) float64, where they stand in the scene, counter-clockwise seen from the front
      unless `mirrored`.
    """

    __slots__ = ("corners", "faces", "mirrored", "name", "pages", "uvs")

    def __init__(self, name, mirrored, parts):
        faces, pages, uvs, corners = parts
        self.name, self.mirrored = name, mirrored
        self.faces, self.pages = (np.frombuffer(values, "<u4").astype(np.int64) for values in (faces, pages))
        self.uvs = np.frombuffer(uvs, "<f4").reshape(-1, 3, 2)
        self.corners = np.frombuffer(corners, "<f8").reshape(-1, 3, 3)

    def __eq__(self, other):
        if not isinstance(other, Object):
            return NotImplemented
        return all(np.array_equal(getattr(self, part), getattr(other, part)) for part in self.__slots__)

    __hash__ = None

    def __repr__(self):
        return f"<ambake.Object {self.name!r} of {len(self.faces)} faces>"


class Baked(dict):
    """A finished bake: layer names to float32 arrays, (height, width) or (height, width, 3), a list of them where there are
    several pages. Row 0 is v = 0. Texels that no face touches have coverage 0.

    * `objects`: the objects that took texels, in the order of the scene.
    * `page_count`, `size`: how many pages there are, and their edge in texels.
    * `stats`: a dict for each page with `texels`, `rays` and `rmse`, the root mean square error of the diffuse term.
    * `warnings`: sentences about what was repaired, ignored or is doubtful.

    It can be pickled, all but what `write` and `write_gltf` need: what comes back has the arrays and the objects.
    """

    def __init__(self, native, faces=0):
        self._native, self._faces = native, faces
        self.size = native.size
        self.stats = [dict(zip(("texels", "rays", "rmse"), page)) for page in native.stats()]
        self.page_count = len(self.stats)
        self.warnings = native.warnings()
        self.objects = [Object(*row) for row in native.objects()]
        super().__init__((name, self._shaped(name, pages)) for name, pages in native.layers())

    def __repr__(self):
        counts = [(len(self), "layer"), (self.page_count, "page"), (len(self.objects), "object")]
        layers, pages, objects = (f"{n} {what}" + "s" * (n != 1) for n, what in counts)
        worst = max(page["rmse"] for page in self.stats)
        return f"<ambake.Baked: {layers} on {pages} of {self.size} x {self.size} texels, {objects}, rmse {worst:.2g}>"

    def __eq__(self, other):
        if not isinstance(other, Baked):
            return False
        parts = ("size", "stats", "warnings", "objects")
        same = all(getattr(self, part) == getattr(other, part) for part in parts)
        return same and self.keys() == other.keys() and all(np.array_equal(self[layer], other[layer]) for layer in self)

    def __ne__(self, other):  # that of dict does not ask __eq__
        return not self == other

    __hash__ = None

    def __reduce__(self):
        return Baked.__new__, (Baked,), {**vars(self), "_native": None}, None, iter(self.items())

    def __copy__(self):
        made = Baked.__new__(Baked)
        vars(made).update(vars(self))
        made.update(self)
        return made

    def __deepcopy__(self, memo):
        made = self.__copy__()
        made.update({layer: copy.deepcopy(values, memo) for layer, values in self.items()})
        return made

    def _shaped(self, name, pages):
        channels = len(LAYERS[name])
        shape = (self.size, self.size) if channels == 1 else (self.size, self.size, channels)
        arrays = [np.frombuffer(page, "<f4").reshape(shape) for page in pages]
        return arrays[0] if len(arrays) == 1 else arrays

    @property
    def uvs(self):
        """(faces, 3, 2) coordinates of the only object, as `bake` was given it; faces without area lie at 0, 0."""
        return self._of_faces("uvs", (3, 2), np.float32)

    @property
    def pages(self):
        """(faces,) page of each face of the only object, as `bake` was given it; -1 for faces without area."""
        return self._of_faces("pages", (), np.int64, -1)

    def _of_faces(self, what, shape, dtype, empty=0):
        if len(self.objects) != 1:
            raise ValueError(f"there are {len(self.objects)} objects; see objects, each of which has its own {what}")
        (only,) = self.objects
        count = max(self._faces, int(only.faces.max()) + 1)
        result = np.full((count, *shape), empty, dtype)
        result[only.faces] = getattr(only, what)
        return result

    def to_trimesh(self, layer="lambert"):
        """The baked surfaces as trimesh shows them: a layer as the texture, in sRGB, cut off above 1.

        A `trimesh.Trimesh` where one object lies on one page, else a `trimesh.Scene` with one for each object and page.
        Vertices are in the axes of the scene; those on the border of a chart are doubled. Needs trimesh and Pillow.
        """
        import trimesh
        from PIL import Image

        if layer not in self:
            raise ValueError(f"layer: there is no {layer!r} in this bake; there are {', '.join(self)}")
        if len(LAYERS[layer]) not in (1, 3):
            raise ValueError(f"layer: {layer!r} has {len(LAYERS[layer])} channels, a texture has 1 or 3")
        planes = self[layer] if self.page_count > 1 else [self[layer]]
        pictures = [Image.fromarray(_srgb(plane)) for plane in planes]
        meshes = []
        for item in self.objects:
            for page in np.unique(item.pages):
                there = item.pages == page
                rows = np.concatenate([item.corners[there], item.uvs[there]], axis=2).reshape(-1, 5)
                rows, faces = np.unique(rows, axis=0, return_inverse=True)
                faces = faces.reshape(-1, 3)[:, :: -1 if item.mirrored else 1]
                # trimesh counts v from the bottom of a picture.
                uv = rows[:, 3:] * [1, -1] + [0, 1]
                visual = trimesh.visual.TextureVisuals(uv=uv, image=pictures[page])
                mesh = trimesh.Trimesh(rows[:, :3], faces, visual=visual, process=False, metadata={"name": item.name})
                meshes.append(mesh)
        if len(meshes) == 1:
            return meshes[0]
        scene = trimesh.Scene()
        for mesh in meshes:
            scene.add_geometry(mesh, geom_name=mesh.metadata["name"])
        return scene

    def write(self, folder):
        """Writes what the command line writes into a folder: EXR pages, PNG previews, a GLB and bake.json, and the files
        of the engines that `for_` named. Returns the files."""
        return self._writer().write(os.fspath(folder))

    def write_gltf(self, path):
        """Writes the scene as a GLB file, with lightmap coordinates as TEXCOORD_1 and the diffuse term as occlusion."""
        self._writer().write_gltf(os.fspath(path))

    def _writer(self):
        if self._native is None:
            raise ValueError("a pickled bake does not have its scene: write it where it was baked")
        return self._native


def bake(vertices, faces=None, *, uvs=None, normals=None, name="mesh", output=None, progress=None, **options):
    """The lightmap of a mesh.

    * `vertices`: (n, 3) positions; or a trimesh.Trimesh or trimesh.Scene alone, which brings its materials along.
    * `faces`: (m, 3) numbers of vertices, counter-clockwise seen from the front.
    * `uvs`: (n, 2) texture coordinates, v growing down as in glTF. They are kept as the layout where they are usable as one.
    * `normals`: (n, 3) shading normals; without them faces are flat.
    * `output`: a folder that also gets what `ambake bake -o` writes. A bake that was stopped goes on there, and a later
      one can name it as `update`.
    * `progress`: called as `progress(texels_done, texels)` now and then. What it raises stops the bake.
    * `options`: those of the command line, such as `size=512`, `rays=256`, `target_error=0.005`,
      `layers="bent,position"`, `for_="three,godot"`. `sky` also takes an array (height, 2 * height, 3) of linear radiance:
      row 0 looks up (+y), the middle column toward +z, and +x lies to its right.

    Raises ValueError where an array or an option has a value that it cannot have, and TypeError for an unknown option.
    """
    if faces is None:
        for what, given in [("uvs", uvs), ("normals", normals)]:
            if given is not None:
                raise ValueError(f"{what}: a trimesh brings its own, leave them out")
        return _bake_trimesh(vertices, output, progress, options)
    vertices = _rows("vertices", vertices, 3, "<f4")
    faces = _faces(faces, len(vertices))
    mesh = _Mesh(name, vertices, faces, _rows("normals", normals, 3, "<f4"), _rows("uvs", uvs, 2, "<f4"))
    return Baked(_ambake.bake_meshes([mesh], _native(options), _path(output), progress), len(faces))


def bake_file(source, *, output=None, progress=None, **options):
    """The lightmap of the scene in an OBJ, glTF or GLB file, or in the bytes of a GLB file.

    What else it takes and raises is that of `bake`; FileNotFoundError where there is no such file.
    """
    options, output = _native(options), _path(output)
    if isinstance(source, (bytes, bytearray, memoryview)):
        with tempfile.TemporaryDirectory(prefix="ambake-") as folder:
            path = os.path.join(folder, "scene.glb")
            with open(path, "wb") as file:
                file.write(source)
            return _without(folder + os.sep, lambda: Baked(_ambake.bake_file(path, options, output, progress)))
    return Baked(_ambake.bake_file(os.fspath(source), options, output, progress))


class Probes:
    """Light that arrives at places of a scene, as real spherical harmonics, orthonormal, in the axes of the scene's file.

    * `positions`: (n, 3) float64. `grid`: of a volume a dict with `low`, `cell` and `counts`, else None; x runs first, then y, then z.
    * `sh`, `std_err`: (n, k, 3) float32, k coefficients of red, green and blue with their standard errors; 1 from all directions is
      2 sqrt(pi) in the first.
    * `validity`: (n,) float32, share of the directions that meet no back of a surface. `invalid`: (n,) bool, those in no air.
    """

    def __init__(self, native):
        self._native = native
        self.grid = native.grid and dict(zip(("low", "cell", "counts"), map(tuple, native.grid)))
        self.positions = np.frombuffer(native.positions(), "<f8").reshape(-1, 3)
        count = len(self.positions)
        self.sh, self.std_err = (np.frombuffer(of(), "<f4").reshape(count, -1, 3) for of in (native.sh, native.std_err))
        self.validity = np.frombuffer(native.validity(), "<f4")
        self.invalid = np.frombuffer(native.invalid(), "?")

    def __repr__(self):
        return f"<ambake.Probes: {len(self.positions)} places, {self.sh.shape[1]} harmonics each>"

    def write(self, folder, engines=()):
        """Writes what the command line writes into a folder, files for engines such as "bevy,three" among them. Returns
        the files."""
        return self._native.write(os.fspath(folder), engines or [])


def probes(source, *, progress=None, **options):
    """Light for what moves: what arrives at places of the scene in an OBJ, glTF or GLB file.

    Options have the names of the flags of `ambake probes`; one of `at` (n places), `grid` (numbers along x, y and z) and `spacing` is
    needed. Errors are those of `bake_file`.
    """
    if options.get("at") is not None:
        options["at"] = _rows("at", options["at"], 3, "<f8").tolist()
    return Probes(_ambake.probes_file(os.fspath(source), _native(options), progress))


class _Mesh:
    """What the native half takes: bytes."""

    def __init__(self, name, positions, triangles, normals, uvs):
        self.name = name
        self.positions, self.triangles = positions.tobytes(), triangles.tobytes()
        self.normals = None if normals is None else normals.tobytes()
        self.uvs = None if uvs is None else uvs.tobytes()


class _Pixels:
    """A polar map as the native half takes it."""

    def __init__(self, rows):
        if rows.ndim != 3 or rows.shape[2] != 3:
            raise ValueError(f"sky: expected (red, green, blue) or shape (height, width, 3), got {rows.shape}")
        self.height, self.width = rows.shape[:2]
        self.pixels = rows.tobytes()


def _native(options):
    """Options with arrays as the native half takes them."""
    sky = options.get("sky")
    if hasattr(sky, "__array__"):
        try:
            rows = np.asarray(sky, "<f4")
        except (TypeError, ValueError) as problem:
            raise ValueError(f"sky: not an array of numbers ({problem})") from None
        options = {**options, "sky": rows.tolist() if rows.shape == (3,) else _Pixels(rows)}
    return options


def _path(folder):
    return None if folder is None else os.fspath(folder)


def _srgb(plane):
    """Linear radiance in 0..1 as the bytes of a picture."""
    linear = np.clip(plane.astype(np.float64), 0, 1)
    curve = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255 * curve).astype(np.uint8)


def _bake_trimesh(mesh, output, progress, options):
    export = getattr(mesh, "export", None)
    if export is None or not hasattr(mesh, "bounds"):
        raise TypeError(f"faces: give them, or a trimesh in place of the vertices; a {type(mesh).__name__} is none")
    baked = bake_file(export(file_type="glb"), output=output, progress=progress, **options)
    baked._faces = len(getattr(mesh, "faces", ()))
    return baked


def _rows(name, values, width, dtype):
    if values is None:
        return None
    try:
        rows = np.asarray(values, dtype)
    except (TypeError, ValueError) as problem:
        raise ValueError(f"{name}: not an array of numbers ({problem})") from None
    if rows.ndim != 2 or rows.shape[1] != width:
        raise ValueError(f"{name}: expected shape (n, {width}), got {rows.shape}")
    return np.ascontiguousarray(rows)


def _faces(faces, vertices):
    whole = np.asarray(faces)
    if whole.dtype.kind not in "iu":
        raise ValueError(f"faces: expected whole numbers, got {whole.dtype}")
    rows = _rows("faces", whole, 3, "<i8")
    if rows.size and (rows.min() < 0 or rows.max() >= vertices):
        wrong = rows.min() if rows.min() < 0 else rows.max()
        raise ValueError(f"faces: vertex {wrong} does not exist, there are {vertices}, numbered from 0")
    return rows.astype("<u4")


def _without(prefix, run):
    """Runs something; errors do not show where the temporary file was."""
    try:
        return run()
    except ValueError as problem:
        raise ValueError(str(problem).replace(prefix, "")) from None
