"""Where a bake goes and what it says of materials, in Blender without a window: names of UV maps and images, folders
beside the .blend, colours that are computed.

    AMBAKE=target/debug/ambake python integrations/blender/tests/test_target.py

needs what test_blender.py needs."""

import os

import with_blender  # first: it prints a skip where Blender is absent
from with_blender import BlenderTest, bpy

import made
import numpy as np


def coordinates(item, name):
    return np.array([corner.vector for corner in item.data.uv_layers[name].uv])


class Target(BlenderTest):
    def setUp(self):
        super().setUp()
        self.item = made.add("box", "cube", made.material("plain", (0.5, 0.5, 0.5)), size=1.0)

    def shown_map(self):
        return self.item.data.materials[0].node_tree.nodes["ambake UV"].uv_map

    def test_the_uv_map_and_the_images_have_the_names_that_were_asked_for(self):
        self.bake(uv_map="Lightmap 1", image_name="hall", layers="position", rays=2)
        self.assertEqual([layer.name for layer in self.item.data.uv_layers], ["UVMap", "Lightmap 1"])
        self.assertEqual(self.shown_map(), "Lightmap 1")
        self.assertEqual({i.name for i in bpy.data.images if i.users}, {"hall irradiance 0", "hall position 0"})
        first = coordinates(self.item, "Lightmap 1")
        # Another name is another map, and what an earlier bake made is no map of the artist's.
        self.bake(uv_map="Lightmap 2", image_name="hall at night", layers="", rays=2)
        self.assertEqual(self.shown_map(), "Lightmap 2")
        np.testing.assert_array_equal(coordinates(self.item, "Lightmap 1"), first)
        np.testing.assert_array_equal(coordinates(self.item, "Lightmap 2"), first)
        self.assertIn("hall irradiance 0", bpy.data.images)

    def test_no_name_is_the_default_one(self):
        self.bake(uv_map="", rays=2)
        self.assertEqual(self.shown_map(), "ambake")

    def test_a_usable_map_of_the_artist_is_the_target_and_another_one_is_not_touched(self):
        own = self.item.data.uv_layers.new(name="mine")
        layout = np.array([[0.02, 0.02], [0.3, 0.02], [0.3, 0.3], [0.02, 0.3]])
        places = np.concatenate([layout + np.array([0.33 * (k % 3), 0.4 * (k // 3)]) for k in range(6)])
        own.uv.foreach_set("vector", places.astype(np.float32).reshape(-1))
        self.assertEqual(self.bake(uv_map="mine", uv="keep", rays=2), [])
        self.assertEqual(self.shown_map(), "mine")
        np.testing.assert_allclose(coordinates(self.item, "mine"), places, atol=1e-5)
        own = self.item.data.uv_layers["mine"]
        own.uv.foreach_set("vector", (places * 0.0 + 0.5).astype(np.float32).reshape(-1))
        notes = self.bake(uv_map="mine", uv="auto", rays=2)
        self.assertIn("its own UV map mine cannot be the layout", notes[0])
        np.testing.assert_allclose(coordinates(self.item, "mine"), 0.5)

    def test_a_folder_beside_the_blend_takes_the_pages(self):
        path = os.path.join(self.folder, "scene.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        self.bake(folder="//maps", rays=2)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "maps", "bake.json")))
        bpy.ops.wm.read_factory_settings(use_empty=True)

    def test_the_margin_is_the_gutter(self):
        spaces = []
        for gutter in (1, 8):
            self.bake(gutter=gutter, uv="unwrap", rays=2, size=128)
            uvs = coordinates(self.item, "ambake") * 128
            spaces.append(uvs.min())
        self.assertGreater(spaces[1], spaces[0] + 5)

    def test_computed_colours_are_named_and_others_are_baked(self):
        tree = made.material("computed", (0.5, 0.5, 0.5))
        tree.node_tree.links.new(
            tree.node_tree.nodes.new("ShaderNodeTexNoise").outputs["Color"],
            tree.node_tree.nodes["Principled BSDF"].inputs["Base Color"],
        )
        matt = bpy.data.materials.new("Diffuse BSDF")
        matt.use_nodes = True
        surface = matt.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
        surface.inputs["Color"].default_value = (0.2, 0.3, 0.4, 1.0)
        matt.node_tree.links.new(surface.outputs[0], matt.node_tree.nodes["Material Output"].inputs["Surface"])
        plain = bpy.data.materials.new("no nodes")
        plain.diffuse_color = (0.4, 0.1, 0.1, 1.0)
        bare = made.add("bare", "plane", None, size=0.5, location=(6, 0, 0))
        expected = {"computed": (0.5,) * 3, "Diffuse BSDF": (0.2, 0.3, 0.4), "no nodes": (0.4, 0.1, 0.1)}
        expected["bare"] = (0.8,) * 3
        items = {"bare": bare}
        for k, material in enumerate((tree, matt, plain)):
            items[material.name] = made.add(f"plane {k}", "plane", material, size=0.5, location=(3, k, 0))
        notes = self.bake(layers="albedo", rays=2, size=128)
        self.assertEqual(len(notes), 1)
        self.assertIn("the colour of computed is computed", notes[0])
        for name, item in items.items():
            u, v = coordinates(item, "ambake").mean(axis=0) * 128
            found = self.image("albedo")[int(v), int(u)]
            np.testing.assert_allclose(found, expected[name], atol=0.02, err_msg=name)


if __name__ == "__main__":
    with_blender.main()
