"""Helpers of the tests that need Blender: a skip where it is absent, a fresh add-on, pictures, look-ups."""

import os
import shutil
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
sys.path.insert(0, os.path.dirname(HERE))


def program():
    """The ambake to test with: AMBAKE, else the one on the PATH."""
    return shutil.which(os.environ.get("AMBAKE", "ambake"))


def skip(reason):
    """Ends the process: with success, unless AMBAKE_TEST_STRICT is 1."""
    print(f"skip: {reason}")
    sys.exit(1 if os.environ.get("AMBAKE_TEST_STRICT") == "1" else 0)


try:
    import bpy
    import numpy as np
except ImportError:
    skip("Blender's Python package bpy is absent (Python 3.11: pip install bpy==4.5.15)")
if program() is None:
    skip("the program ambake is not on the PATH, and AMBAKE does not name it")


class BlenderTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="ambake-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        os.environ["PATH"] = os.path.dirname(program()) + os.pathsep + os.environ["PATH"]
        import ambake

        ambake.register()
        self.addCleanup(ambake.unregister)

    def settings(self, **values):
        settings = bpy.context.scene.ambake
        plain = {"size": 64, "rays": 16, "folder": self.folder, "light": "SKY", "bounces": 0}
        for name, value in {**plain, **values}.items():
            setattr(settings, name, value)
        return settings

    def bake(self, **values):
        """Bakes as a user does; returns the notes."""
        from ambake import bake

        self.settings(**values)
        job = bake.Bake(bpy.context)
        job.run.wait()
        try:
            return job.finish()[1]
        finally:
            job.close()

    def image(self, layer, page=0):
        """(height, width, 3) values, row 0 at the bottom as in Blender."""
        (image,) = [i for i in bpy.data.images if i.name.endswith(f" {layer} {page}")]
        values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
        image.pixels.foreach_get(values)
        return values.reshape(image.size[1], image.size[0], 4)[..., :3]

    def positions_agree(self, item, texels):
        """The layer `position` at the middle of every face is that middle, up to so many texels of the face's own
        density."""
        mesh = item.data
        uvs = self.places(item)
        worst = 0.0
        for polygon in mesh.polygons:
            own = uvs[list(polygon.loop_indices)]
            page = self.page_of(item, polygon)
            picture = self.image("position", page)
            found = look_up(picture, own.mean(axis=0))
            count = len(polygon.vertices)
            corners = [item.matrix_world @ mesh.vertices[v].co for v in polygon.vertices]
            middle = np.mean(corners, axis=0)
            edge = max((corners[k] - corners[k - 1]).length for k in range(count))
            span = max(np.linalg.norm(own[k] - own[k - 1]) for k in range(count)) * picture.shape[0]
            # glTF's axes: x, z, -y of Blender's.
            there = np.array([found[0], -found[2], found[1]])
            worst = max(worst, np.linalg.norm(there - middle) / (edge / max(span, 1.0)))
        self.assertLess(worst, texels, f"{item.name}: a face is {worst:.2f} texels from where its lightmap says")

    def places(self, item, uv_map="ambake"):
        """Where the corners of an object lie on its page: its UV map, carried to its own place."""
        from ambake import linked

        uvs = np.array([u.vector for u in item.data.uv_layers[uv_map].uv])
        growth, offset = (np.array(item.get(name, (0.0,) * 3))[:2] for name in (linked.GROWTH, linked.OFFSET))
        return uvs * (1.0 + growth) + offset

    def baked(self, item):
        """What shows the bake of an object: it, or its copy."""
        from ambake import copies

        return copies.all_of_them().get(item, item)

    def page_of(self, item, polygon):
        material = item.material_slots[polygon.material_index].material
        return int(material.node_tree.nodes["ambake image"].image.name.rsplit(" ", 1)[1])


def look_up(picture, uv):
    """Bilinear look-up, clamped."""
    height, width = picture.shape[:2]
    x, y = uv[0] * width - 0.5, uv[1] * height - 0.5
    x0, y0 = int(np.floor(x)), int(np.floor(y))
    fx, fy = x - x0, y - y0
    at = lambda a, b: picture[min(max(b, 0), height - 1), min(max(a, 0), width - 1)]
    low = at(x0, y0) * (1 - fx) + at(x0 + 1, y0) * fx
    high = at(x0, y0 + 1) * (1 - fx) + at(x0 + 1, y0 + 1) * fx
    return low * (1 - fy) + high * fy


def render(path, samples=1, size=48, world=1.0, bounces=0):
    """What Cycles makes of the scene through its camera: (height, width, 4) linear values, row 0 at the bottom. Where
    no light bounces, a plain material under the white world is the diffuse term times its colour. With `world=None`
    the world is the scene's own."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 0.01
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = bounces
    scene.cycles.transparent_max_bounces = 8
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGBA"
    scene.render.filepath = path
    if world is not None:
        plain_world((1.0, 1.0, 1.0), world)
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(path, check_existing=False)
    values = np.empty(size * size * 4, np.float32)
    picture.pixels.foreach_get(values)
    bpy.data.images.remove(picture)
    return values.reshape(size, size, 4)


def plain_world(colour, strength):
    """Gives the scene a world of one colour."""
    scene = bpy.context.scene
    scene.world = scene.world or bpy.data.worlds.new("plain")
    scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (*colour, 1.0)
    background.inputs["Strength"].default_value = strength


def camera_above(scale, height=10.0):
    """An orthographic camera that looks straight down at a square of edge `scale`."""
    data = bpy.data.cameras.new("above")
    data.type, data.ortho_scale = "ORTHO", scale
    item = bpy.data.objects.new("above", data)
    item.location = (0.0, 0.0, height)
    bpy.context.collection.objects.link(item)
    bpy.context.scene.camera = item
    return item


def main():
    """Runs the tests of the calling module. Blender as a module hangs at times when Python ends, so the process ends
    here."""
    result = unittest.main(exit=False).result
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(0 if result.wasSuccessful() else 1)
