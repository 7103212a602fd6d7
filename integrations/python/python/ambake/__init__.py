"""ambake bakes ambient light into lightmaps, on the processor, and states the error.

    baked = ambake.bake(vertices, faces, size=256, rays=64)
    baked["diffuse"]      # (256, 256) float32, row 0 is v = 0
    baked.uvs             # (faces, 3, 2): where the corners of each face lie on the page

Options have the names of the flags of `ambake bake`, with underscores; `OPTIONS` lists them. Python's other threads run
during a bake, and Ctrl-C stops it.
"""

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
    """

    __slots__ = ("faces", "name", "pages", "uvs")

    def __init__(self, name, faces, pages, uvs):
        self.name, self.faces, self.pages, self.uvs = name, faces, pages, uvs

    def __repr__(self):
        return f"<ambake.Object {self.name!r} of {len(self.faces)} faces>"


class Baked(dict):
    """A finished bake: layer names to float32 arrays, (height, width) or (height, width, 3), a list of them where there are
    several pages. Row 0 is v = 0. Texels that no face touches have coverage 0.

    * `objects`: the objects that took texels, in the order of the scene.
    * `page_count`, `size`: how many pages there are, and their edge in texels.
    * `stats`: a dict for each page with `texels`, `rays` and `rmse`, the root mean square error of the diffuse term.
    * `warnings`: sentences about what was repaired, ignored or is doubtful.
    """

    def __init__(self, native):
        self._native = native
        self.size = native.size
        self.stats = [dict(zip(("texels", "rays", "rmse"), page)) for page in native.stats()]
        self.page_count = len(self.stats)
        self.warnings = native.warnings()
        self.objects = [_object(*row) for row in native.objects()]
        super().__init__((name, self._shaped(name, pages)) for name, pages in native.layers())

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
        count = max(getattr(self, "_faces", 0), int(only.faces.max()) + 1)
        result = np.full((count, *shape), empty, dtype)
        result[only.faces] = getattr(only, what)
        return result

    def write(self, folder):
        """Writes what the command line writes into a folder: EXR pages, PNG previews, a GLB and bake.json. Returns the
        files."""
        return self._native.write(os.fspath(folder))

    def write_gltf(self, path):
        """Writes the scene as a GLB file, with lightmap coordinates as TEXCOORD_1 and the diffuse term as occlusion."""
        self._native.write_gltf(os.fspath(path))


def _object(name, faces, pages, uvs):
    numbers = [np.frombuffer(values, "<u4").astype(np.int64) for values in (faces, pages)]
    return Object(name, *numbers, np.frombuffer(uvs, "<f4").reshape(-1, 3, 2))


def bake(vertices, faces=None, *, uvs=None, normals=None, name="mesh", progress=None, **options):
    """The lightmap of a mesh.

    * `vertices`: (n, 3) positions; or a trimesh.Trimesh or trimesh.Scene alone, which brings its materials along.
    * `faces`: (m, 3) numbers of vertices, counter-clockwise seen from the front.
    * `uvs`: (n, 2) texture coordinates, v growing down as in glTF. They are kept as the layout where they are usable as one.
    * `normals`: (n, 3) shading normals; without them faces are flat.
    * `progress`: called as `progress(texels_done, texels)` now and then. What it raises stops the bake.
    * `options`: those of the command line, such as `size=512`, `rays=256`, `target_error=0.005`, `layers=["bent"]`.

    Raises ValueError where an array or an option has a value that it cannot have, and TypeError for an unknown option.
    """
    if faces is None:
        for what, given in [("uvs", uvs), ("normals", normals)]:
            if given is not None:
                raise ValueError(f"{what}: a trimesh brings its own, leave them out")
        return _bake_trimesh(vertices, progress, options)
    vertices = _rows("vertices", vertices, 3, "<f4")
    faces = _faces(faces, len(vertices))
    mesh = _Mesh(name, vertices, faces, _rows("normals", normals, 3, "<f4"), _rows("uvs", uvs, 2, "<f4"))
    baked = Baked(_ambake.bake_meshes([mesh], options, progress))
    baked._faces = len(faces)
    return baked


def bake_file(source, *, progress=None, **options):
    """The lightmap of the scene in an OBJ, glTF or GLB file, or in the bytes of a GLB file.

    Its options and errors are those of `bake`; FileNotFoundError where there is no such file.
    """
    if isinstance(source, (bytes, bytearray, memoryview)):
        with tempfile.TemporaryDirectory(prefix="ambake-") as folder:
            path = os.path.join(folder, "scene.glb")
            with open(path, "wb") as file:
                file.write(source)
            return _without(folder + os.sep, lambda: Baked(_ambake.bake_file(path, options, progress)))
    return Baked(_ambake.bake_file(os.fspath(source), options, progress))


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

    def write(self, folder, engines=()):
        """Writes what the command line writes into a folder, files for engines such as "bevy" among them. Returns the files."""
        return self._native.write(os.fspath(folder), list(engines))


def probes(source, *, progress=None, **options):
    """Light for what moves: what arrives at places of the scene in an OBJ, glTF or GLB file.

    Options have the names of the flags of `ambake probes`; one of `at` (n places), `grid` (numbers along x, y and z) and `spacing` is
    needed. Errors are those of `bake_file`.
    """
    if options.get("at") is not None:
        options["at"] = _rows("at", options["at"], 3, "<f8").tolist()
    return Probes(_ambake.probes_file(os.fspath(source), options, progress))


class _Mesh:
    """What the native half takes: bytes."""

    def __init__(self, name, positions, triangles, normals, uvs):
        self.name = name
        self.positions, self.triangles = positions.tobytes(), triangles.tobytes()
        self.normals = None if normals is None else normals.tobytes()
        self.uvs = None if uvs is None else uvs.tobytes()


def _bake_trimesh(mesh, progress, options):
    export = getattr(mesh, "export", None)
    if export is None or not hasattr(mesh, "bounds"):
        raise TypeError(f"faces: give them, or a trimesh in place of the vertices; a {type(mesh).__name__} is none")
    baked = bake_file(export(file_type="glb"), progress=progress, **options)
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
