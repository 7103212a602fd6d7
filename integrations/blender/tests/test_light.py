"""The light of the scene, in Blender without a window: each kind of lamp, the world and materials that shine, as
Cycles has them. Cycles draws a floor and a box, then the bake of them, and the two are compared.

    AMBAKE=target/debug/ambake python integrations/blender/tests/test_light.py

needs what test_blender.py needs."""

import os

import with_blender  # first: it prints a skip where Blender is absent
from with_blender import BlenderTest, bpy, camera_above, plain_world, render

import made
import numpy as np


def stage(colour=(0.6, 0.5, 0.4)):
    """A floor and a box under a camera, without light."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    matt = made.material("matt", colour)
    floor = made.add("floor", "plane", matt, size=4.0)
    made.add("box #1 *", "cube", matt, size=0.8, location=(0.5, 0.3, 0.4))
    camera_above(3.6)
    return floor


def lamp(kind, location=(0.0, 0.0, 2.0), turn=(0.0, 0.0, 0.0), **values):
    data = bpy.data.lights.new(f"{kind} lamp", kind)
    for name, value in values.items():
        setattr(data, name, value)
    item = bpy.data.objects.new(f"{kind} lamp", data)
    item.location, item.rotation_euler = location, turn
    bpy.context.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


class Light(BlenderTest):
    def agrees(self, name, mean=0.02, rms=0.12, bounces=0, bake_bounces=None, samples=64, mask=None):
        """Bakes the scene's light and compares what Cycles shows of it with what Cycles says itself, relative to its
        mean. Returns the notes."""
        path = os.path.join(self.folder, "picture.exr")
        own = render(path, samples=samples, world=None, bounces=bounces)
        notes = self.bake(
            light="SCENE", size=192, rays=256, bounces=bounces if bake_bounces is None else bake_bounces
        )
        shown = render(path, world=None)
        inside = (own[..., 3] > 0.99) & (shown[..., 3] > 0.99)
        if mask is not None:
            inside &= mask
        scale = own[..., :3][inside].mean()
        apart = (shown - own)[..., :3][inside] / scale
        words = f"{name}: mean {apart.mean():+.4f}, root mean square {np.sqrt((apart**2).mean()):.4f} of {scale:.4f}"
        print(words)
        self.assertGreater(scale, 1e-3, words)
        self.assertLess(abs(apart.mean()), mean, words)
        # Edges of shadows lie within a texel, 1/45 m, and Cycles has its noise.
        self.assertLess(np.sqrt((apart**2).mean()), rms, words)
        return notes

    def test_a_sun_with_an_angle_and_a_grey_world(self):
        stage()
        lamp("SUN", turn=(0.5, 0.3, 0.0), energy=3.0, angle=0.2, color=(1.0, 0.9, 0.7))
        plain_world((0.4, 0.5, 0.6), 0.5)
        self.assertEqual(self.agrees("sun and world"), [])

    def test_a_hard_sun_and_light_that_bounces(self):
        stage()
        lamp("SUN", turn=(0.5, 0.3, 0.0), energy=3.0, angle=0.0)
        self.agrees("hard sun, two bounces", bounces=2)

    def test_a_room_of_four_colours_and_four_bounces(self):
        stage((0.8, 0.8, 0.8))
        # Walls whose fronts face the room: backs send no light on.
        half = np.pi / 2.0
        walls = {
            "left": ((0.7, 0.1, 0.1), (-2, 0, 1.5), (0, half, 0)),
            "right": ((0.1, 0.6, 0.1), (2, 0, 1.5), (0, -half, 0)),
            "back": ((0.8, 0.8, 0.8), (0, 2, 1.5), (half, 0, 0)),
            "front": ((0.2, 0.3, 0.7), (0, -2, 1.5), (-half, 0, 0)),
        }
        for name, (colour, place, turn) in walls.items():
            made.add(name, "plane", made.material(name, colour), size=4.0, location=place, rotation=turn)
        lamp("POINT", location=(0.3, -0.8, 2.4), energy=60.0, shadow_soft_size=0.1, use_soft_falloff=False)
        plain_world((0.5, 0.7, 1.0), 0.3)
        self.agrees("room", bounces=4, samples=128)

    def test_point_lamps_by_their_watts(self):
        stage()
        lamp("POINT", location=(-0.8, -0.6, 1.5), energy=100.0, shadow_soft_size=0.0)
        self.agrees("point")
        stage()
        ball = {"shadow_soft_size": 0.2, "use_soft_falloff": False, "exposure": 1.0}
        lamp("POINT", location=(-0.8, -0.6, 1.5), energy=100.0, **ball)
        self.agrees("point with a radius")

    def test_a_spot_by_its_cone(self):
        stage()
        cone = {"spot_size": 1.0, "spot_blend": 0.4, "shadow_soft_size": 0.0}
        lamp("SPOT", location=(-0.6, -0.5, 2.0), turn=(0.2, 0.1, 0.4), energy=200.0, **cone)
        self.assertEqual(self.agrees("spot", mean=0.03, rms=0.15), [])
        lamp("SPOT", energy=1.0, shadow_soft_size=0.1)
        notes = self.bake(light="SCENE", rays=2)
        self.assertIn("of the lamps SPOT lamp.001: baked as a point without radius", " ".join(notes))

    def test_area_lamps_of_all_shapes(self):
        for shape, sizes in [("RECTANGLE", {"size_y": 0.3}), ("ELLIPSE", {"size_y": 0.5})]:
            stage()
            sizes.update(shape=shape, size=0.8)
            area = lamp("AREA", location=(-0.6, -0.4, 1.6), turn=(0.3, -0.2, 0.7), energy=80.0, **sizes)
            area.scale = (1.5, 1.0, 1.0)
            bpy.context.view_layer.update()
            self.agrees(f"area {shape}")

    def test_a_picture_of_the_world_is_turned_and_scaled_as_cycles_has_it(self):
        stage()
        picture = bpy.data.images.new("panorama", 64, 32, float_buffer=True)
        values = np.ones((32, 64, 4), np.float32) * 0.1
        values[18:26, 5:14, 0], values[16:22, 30:40, 1], values[20:28, 50:56, 2] = 9.0, 7.0, 11.0
        picture.pixels.foreach_set(values.reshape(-1))
        picture.pack()
        plain_world((0.0, 0.0, 0.0), 0.7)
        tree = bpy.context.scene.world.node_tree
        sky, turn, place = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "Mapping", "TexCoord"))
        sky.image = picture
        turn.inputs["Rotation"].default_value = (0.0, 0.0, 0.9)
        tree.links.new(place.outputs["Generated"], turn.inputs["Vector"])
        tree.links.new(turn.outputs["Vector"], sky.inputs["Vector"])
        background = tree.nodes["Background"]
        # As worlds are often made: the camera sees something else.
        path, hide = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMix")
        hide.data_type = "RGBA"
        tree.links.new(path.outputs["Is Camera Ray"], hide.inputs["Factor"])
        tree.links.new(sky.outputs["Color"], hide.inputs[6])
        hide.inputs[7].default_value = (50.0, 50.0, 50.0, 1.0)
        tree.links.new(hide.outputs[2], background.inputs["Color"])
        counts = len(bpy.data.scenes), len(bpy.data.worlds), len(bpy.data.cameras)
        self.assertEqual(self.agrees("panorama", samples=256), [])
        self.assertEqual(counts, (len(bpy.data.scenes), len(bpy.data.worlds), len(bpy.data.cameras)))

    def test_a_procedural_sky_with_its_sun(self):
        stage()
        plain_world((0.0, 0.0, 0.0), 0.1)
        tree = bpy.context.scene.world.node_tree
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sun_elevation, sky.sun_rotation = 0.9, 0.6
        tree.links.new(sky.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        self.agrees("sky texture", mean=0.04, rms=0.15, samples=256)

    def test_materials_that_shine_light_others_by_one_bounce_and_are_seen_to(self):
        for kind in ("Principled", "Emission"):
            stage()
            shine = made.material("shine", (0.0, 0.0, 0.0))
            surface = shine.node_tree.nodes["Principled BSDF"]
            names = "Emission Color", "Emission Strength"
            if kind == "Emission":
                output = shine.node_tree.nodes["Material Output"]
                surface = shine.node_tree.nodes.new("ShaderNodeEmission")
                shine.node_tree.links.new(surface.outputs[0], output.inputs["Surface"])
                names = "Color", "Strength"
            surface.inputs[names[0]].default_value = (1.0, 0.6, 0.3, 1.0)
            surface.inputs[names[1]].default_value = 4.0
            made.add("panel", "plane", shine, size=0.6, location=(-1.0, -0.8, 0.5), rotation=(0.0, 1.2, 0.0))
            # Pixels at the edge of the bright panel are no measure.
            beside = np.tile(np.arange(48) > 13, (48, 1))
            notes = self.agrees(f"emission of {kind}", bake_bounces=1, samples=256, mean=0.03, rms=0.2, mask=beside)
            self.assertEqual(notes, [])
            panel = render(os.path.join(self.folder, "picture.exr"), world=None)[13, 10, :3]
            np.testing.assert_allclose(panel, [4.0, 2.4, 1.2], rtol=1e-3)
            self.assertIn("light nothing without a bounce", " ".join(self.bake(light="SCENE", rays=2, bounces=0)))

    def test_lamps_that_do_not_render_and_their_nodes(self):
        stage()
        plain_world((1.0, 1.0, 1.0), 0.2)
        hidden = lamp("POINT", energy=1000.0)
        hidden.hide_render = True
        shaded = lamp("POINT", location=(-0.8, -0.6, 1.5), energy=50.0, shadow_soft_size=0.0)
        shaded.data.use_nodes = True
        shaded.data.node_tree.nodes["Emission"].inputs["Strength"].default_value = 2.0
        self.assertEqual(self.agrees("a lamp with nodes beside a hidden one"), [])
        tree = shaded.data.node_tree
        tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], tree.nodes["Emission"].inputs["Color"])
        self.assertIn("baked without nodes", " ".join(self.bake(light="SCENE", rays=2)))

    def test_a_dark_scene_says_so(self):
        stage()
        self.assertIn("no lamp, no world and no material", " ".join(self.bake(light="SCENE", rays=2)))


if __name__ == "__main__":
    with_blender.main()
