"""End to end, in Blender without a window: export, bake, return, and what Cycles then shows.

    AMBAKE=target/debug/ambake python integrations/blender/tests/test_blender.py

needs Python 3.11 with the packages of requirements.txt. Without them it prints a skip."""

import json
import os
import tempfile
import types

import with_blender  # first: it prints a skip where Blender is absent
from with_blender import ROOT, BlenderTest, bpy, camera_above, look_up, render

import made
import numpy as np


class MadeScene(BlenderTest):
    def test_every_object_gets_its_own_part_of_the_page(self):
        objects = made.make()
        notes = " | ".join(self.bake(layers="position", size=128, rays=4))
        received = [objects["floor"], *objects["twins"], objects["child"], objects["fan"], objects["doubled"]]
        for item in received:
            self.positions_agree(self.baked(item), 1.5)
        self.assertIn("instances of shelf here only cast shadows", notes)
        self.assertIn("1 object is shown by baked copies", notes)
        item = objects["instance"]
        self.assertNotIn("ambake", item.data.uv_layers, item.name)
        self.assertNotIn("ambake", item.data.materials[0].node_tree.nodes, item.name)
        for item in bpy.data.objects:
            if item.type == "MESH":
                self.assertNotIn("_AMBAKE_CORNER", item.data.attributes, item.name)
        for image in bpy.data.images:
            if image.users and image.type == "IMAGE":
                self.assertTrue(image.packed_file, image.name)

    def test_a_cancelled_bake_leaves_all_as_it_was(self):
        objects = made.make()
        from ambake import bake

        self.settings(rays=4096, size=2048)
        counts = len(bpy.data.meshes), len(bpy.data.objects)
        job = bake.Bake(bpy.context)
        self.assertTrue(job.run.running())
        job.cancel()
        job.close()
        self.assertEqual(len(objects["doubled"].modifiers), 1)
        self.assertTrue(objects["doubled"].modifiers[0].show_viewport)
        self.assertEqual((len(bpy.data.meshes), len(bpy.data.objects)), counts)

    def test_a_light_probe_volume_is_written_for_engines_and_the_scene_stays(self):
        made.make()
        bpy.ops.object.lightprobe_add(type="VOLUME", location=(0, 0, 2))
        volume = bpy.context.active_object
        volume.scale = (3, 2, 1)
        volume.data.resolution_x, volume.data.resolution_y, volume.data.resolution_z = 4, 3, 2
        bpy.context.view_layer.update()
        before = {item.name: item.data for item in bpy.data.objects if item.type == "MESH"}
        with tempfile.TemporaryDirectory() as folder:
            self.settings(folder=folder, seed=1)
            self.assertEqual(bpy.ops.ambake.probes(), {"FINISHED"})
            (report,) = [name for name in os.listdir(folder) if name.endswith(".probes.json")]
            with open(os.path.join(folder, report)) as file:
                found = json.load(file)
            self.assertTrue(os.path.exists(os.path.join(folder, report.replace(".json", ".bevy.ktx2"))))
        # glTF's axes: x, z, -y of Blender's.
        self.assertEqual(found["grid"]["counts"], [4, 2, 3])
        np.testing.assert_allclose(found["grid"]["low"], [-3, 1, -2], atol=1e-5)
        np.testing.assert_allclose(found["grid"]["cell"], [1.5, 1, 4 / 3], atol=1e-5)
        self.assertEqual(before, {item.name: item.data for item in bpy.data.objects if item.type == "MESH"})
        self.settings(folder="")
        with self.assertRaisesRegex(RuntimeError, "name a folder"):
            bpy.ops.ambake.probes()

    def test_several_pages_and_a_second_bake_show_each_face_on_its_page(self):
        objects = made.make()
        self.bake(layers="position", rays=2, density=12.0)
        pages = {self.page_of(objects["floor"], p) for p in objects["floor"].data.polygons}
        images = {i.name for i in bpy.data.images if " position " in i.name}
        self.assertGreater(len(images), 1)
        self.assertEqual(len(pages), 1)
        for item in [objects["floor"], *objects["twins"], objects["child"]]:
            self.positions_agree(self.baked(item), 1.5)
        self.bake(layers="position", rays=2, density=0.0, size=128)
        for item in [objects["floor"], *objects["twins"], objects["child"]]:
            self.positions_agree(self.baked(item), 1.5)
            self.assertEqual([u.name for u in self.baked(item).data.uv_layers].count("ambake"), 1)

    def test_a_later_bake_is_of_the_scene_and_not_of_an_earlier_bake(self):
        made.make()
        self.bake(show="lambert", size=64, rays=4)
        first = self.image("lambert")
        self.bake(show="lambert", size=64, rays=4)
        second = self.image("lambert")
        np.testing.assert_array_equal(first, second)

    def test_only_selected_objects_change_and_the_others_cast_shadows(self):
        objects = made.make()
        bpy.ops.object.select_all(action="DESELECT")
        objects["floor"].select_set(True)
        self.bake(targets="SELECTED", show="diffuse", rays=64)
        self.assertIn("ambake", objects["floor"].data.uv_layers)
        self.assertNotIn("ambake", objects["twins"][0].data.uv_layers)
        uvs = np.array([u.vector for u in objects["floor"].data.uv_layers["ambake"].uv])
        values = self.image("diffuse")
        # The floor spans -2..2. Its corner at (2, 2) is open; under the table it is dark.
        along, across = uvs[1] - uvs[0], uvs[3] - uvs[0]
        place = lambda x, y: look_up(values, uvs[0] + (x / 4 + 0.5) * along + (y / 4 + 0.5) * across)
        self.assertGreater(place(1.9, 1.9)[0], 0.9)
        self.assertLess(place(0.0, -0.2)[0], 0.7)

    def test_the_operator_bakes_as_a_script_calls_it(self):
        made.make()
        self.settings(rays=4)
        self.assertEqual(bpy.ops.ambake.bake(), {"FINISHED"})
        self.assertGreater(self.image("irradiance").max(), 0.5)
        self.settings(targets="SELECTED")
        bpy.ops.object.select_all(action="DESELECT")
        with self.assertRaisesRegex(RuntimeError, "no selected mesh has a face"):
            bpy.ops.ambake.bake()

    def test_the_panels_draw_what_there_is(self):
        from ambake import panel

        class Layout:
            def __getattr__(self, _name):
                return lambda *_, **__: self

            def prop(self, settings, name):
                drawn.append(name)
                assert name in settings.bl_rna.properties, name

        settings, drawn = self.settings(light="SCENE"), []
        for light in ("SCENE", "SKY"):
            settings.light = light
            for cls in (panel.AMBAKE_PT_bake, panel.AMBAKE_PT_light, panel.AMBAKE_PT_layout, panel.AMBAKE_PT_output):
                part = types.SimpleNamespace(layout=Layout(), names=getattr(cls, "names", ()))
                part.shown = lambda of, cls=cls, part=part: cls.shown(part, of)
                cls.draw(part, bpy.context)
        self.assertEqual(drawn.count("sky"), 1)
        self.assertEqual(drawn.count("bounces"), 2)
        other = {"rna_type", "name", "target_error", "target_relative", "max_rays"}
        self.assertEqual(set(settings.bl_rna.properties.keys()) - other, set(drawn), "every setting is in a panel")

    def test_mistakes_are_one_line_and_change_nothing(self):
        made.make()
        from ambake import bake

        with self.assertRaisesRegex(ValueError, "no-such-flag"):
            self.bake(further="--no-such-flag")
        with self.assertRaisesRegex(ValueError, "no selected mesh has a face"):
            bpy.ops.object.select_all(action="DESELECT")
            self.bake(targets="SELECTED")
        with self.assertRaisesRegex(ValueError, "save the file first"):
            self.bake(folder="//maps", targets="VISIBLE")
        before, os.environ["PATH"] = os.environ["PATH"], ""
        try:
            with self.assertRaisesRegex(ValueError, "was not found; install it"):
                bake.Bake(bpy.context)
        finally:
            os.environ["PATH"] = before
        self.assertFalse([i for i in bpy.data.objects if i.type == "MESH" and "ambake" in i.data.uv_layers])

    def test_cycles_shows_what_ambake_says_and_agrees_by_itself(self):
        made.make()
        camera_above(4.0)
        path = os.path.join(self.folder, "picture.exr")
        own = render(path, samples=64)
        self.bake(size=256, rays=64)
        shown = render(path)
        inside = (own[..., 3] > 0.99) & (shown[..., 3] > 0.99)
        apart = (shown - own)[..., :3][inside]
        self.assertGreater(inside.mean(), 0.9)
        # Cycles' 64 samples leave a noise of 0.03; the mean over 2000 pixels one of 0.001. Texels are 1/40 m.
        self.assertLess(abs(apart.mean()), 0.01, "mean of Cycles showing the bake less Cycles by itself")
        self.assertLess(np.sqrt((apart**2).mean()), 0.06)
        bpy.ops.ambake.switch()
        again = render(path, samples=64)
        self.assertLess(abs((again - own)[..., :3][inside].mean()), 0.01, "the materials as they were")


class ForeignScene(BlenderTest):
    def meshes(self):
        """The scene's own objects, without the copies."""
        return [i for i in bpy.data.objects if i.type == "MESH" and "ambake of" not in i]

    def test_instances_of_a_gltf_file_come_back(self):
        bpy.ops.import_scene.gltf(filepath=os.path.join(ROOT, "scenes", "instances.gltf"))
        self.bake(layers="position", rays=4, size=128)
        for item in self.meshes():
            self.positions_agree(self.baked(item), 2.0)

    def test_cut_out_leaves_stay_cut_out(self):
        bpy.ops.import_scene.gltf(filepath=os.path.join(ROOT, "scenes", "masked_card.gltf"))
        self.bake(rays=4)
        nodes = [m.node_tree.nodes.get("ambake") for m in bpy.data.materials if m.node_tree]
        linked = [n for n in nodes if n and n.inputs["Alpha"].is_linked]
        self.assertTrue(linked, "a masked material keeps its alpha")


if __name__ == "__main__":
    with_blender.main()
