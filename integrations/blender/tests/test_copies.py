"""Baked copies, in Blender without a window: what stays of modifiers, shared meshes and polygons, and the ways back.

    AMBAKE=target/debug/ambake python integrations/blender/tests/test_copies.py

needs what test_blender.py needs."""

import with_blender  # first: it prints a skip where Blender is absent
from with_blender import BlenderTest, bpy

import made
import numpy as np
from ambake import linked


class Copies(BlenderTest):
    def test_modifiers_stay_and_one_click_goes_back_and_forth(self):
        objects = made.make()
        doubled = objects["doubled"]
        self.bake(layers="position", size=128, rays=4)
        copy = self.baked(doubled)
        self.assertIsNot(copy, doubled)
        self.assertEqual([m.type for m in doubled.modifiers], ["ARRAY"])
        self.assertTrue(doubled.modifiers[0].show_viewport)
        self.assertEqual((len(doubled.data.polygons), len(copy.data.polygons), len(copy.modifiers)), (6, 12, 0))
        self.assertNotIn("ambake", doubled.data.uv_layers)
        self.positions_agree(copy, 1.5)
        self.assertEqual([c.name for c in copy.users_collection], ["ambake baked"])
        states = lambda: (doubled.hide_render, doubled.hide_viewport, copy.hide_render, copy.hide_viewport)
        self.assertEqual(states(), (True, True, False, False))
        bpy.ops.ambake.switch()
        self.assertEqual(states(), (False, False, True, True))
        bpy.ops.ambake.switch()
        self.assertEqual(states(), (True, True, False, False))

    def test_modifiers_that_move_vertices_keep_the_object(self):
        objects = made.make()
        self.bake(rays=4)
        bent = objects["bent"]
        self.assertIs(self.baked(bent), bent)
        self.assertIn("ambake", bent.data.uv_layers)
        self.assertEqual(len(bent.modifiers), 1)

    def test_twins_stay_linked_and_share_one_layout(self):
        objects = made.make()
        first, second = objects["twins"]
        for _ in range(2):
            self.bake(layers="position", size=128, rays=4)
            self.assertIs(first.data, second.data)
            self.assertEqual([u.name for u in first.data.uv_layers], ["UVMap", "ambake"])
            for item in objects["twins"]:
                self.assertIs(self.baked(item), item)
                self.positions_agree(item, 1.5)
            # One of the two lies where the map says.
            self.assertEqual(sorted(linked.GROWTH in item for item in objects["twins"]), [False, True])
            self.assertEqual({slot.link for item in objects["twins"] for slot in item.material_slots}, {"DATA"})

    def test_a_twin_outside_of_the_bake_goes_on_looking_as_it_did(self):
        first, second = made.make()["twins"]
        red = second.material_slots[0].material
        second.hide_render = True
        self.bake(layers="position", size=128, rays=4)
        self.assertIs(self.baked(first), first)
        self.assertIs(first.data, second.data)
        self.positions_agree(first, 1.5)
        self.assertIs(second.material_slots[0].material, red)
        self.assertNotIn("ambake", red.node_tree.nodes)
        self.assertNotEqual(first.material_slots[0].material, red)

    def test_twins_on_several_pages_share_a_mesh_and_have_materials_of_their_own(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        ball = made.add("ball", "uv_sphere", made.material("stone", (0.5, 0.5, 0.5)), radius=0.4)
        balls = [ball]
        for k in range(5):
            balls.append(bpy.data.objects.new(f"ball {k}", ball.data))
            balls[-1].location = (k + 1.0, 0.2 * k, 0.0)
            bpy.context.collection.objects.link(balls[-1])
        bpy.context.view_layer.update()
        for _ in range(2):
            self.bake(layers="position", rays=2, size=64, density=20.0)
            shown = [self.baked(item) for item in balls]
            self.assertEqual(len({item.data for item in shown}), 1)
            pages = {self.page_of(item, item.data.polygons[0]) for item in shown}
            self.assertGreater(len(pages), 1)
            for item in shown:
                self.positions_agree(item, 2.0)

    def test_a_map_of_the_artist_is_the_layout_of_all_that_share_it(self):
        first, second = made.make()["twins"]
        own = first.data.uv_layers.new(name="mine")
        layout = np.array([[0.02, 0.02], [0.3, 0.02], [0.3, 0.3], [0.02, 0.3]])
        places = np.concatenate([layout + np.array([0.33 * (k % 3), 0.4 * (k // 3)]) for k in range(6)])
        own.uv.foreach_set("vector", places.astype(np.float32).reshape(-1))
        second.scale = first.scale
        for item in list(bpy.data.objects):
            if item not in (first, second):
                bpy.data.objects.remove(item)
        bpy.context.view_layer.update()
        self.assertEqual(self.bake(uv_map="mine", uv="keep", rays=2, size=128), [])
        found = [self.places(item, "mine") for item in (first, second)]
        self.assertGreater(np.abs(found[0] - found[1]).max(), 0.2)
        own = np.array([u.vector for u in first.data.uv_layers["mine"].uv])
        np.testing.assert_allclose(own, places, atol=1e-6)

    def test_linked_twins_look_as_objects_of_their_own_do(self):
        pictures = []
        for own in (False, True):
            bpy.ops.wm.read_factory_settings(use_empty=True)
            made.add("floor", "plane", made.material("grey", (0.5, 0.5, 0.5)), size=4.0)
            first = made.add("head", "monkey", made.material("red", (0.6, 0.1, 0.1)), size=1.2, location=(-0.8, 0, 0.6))
            second = bpy.data.objects.new("twin", first.data.copy() if own else first.data)
            second.location, second.rotation_euler = (0.8, 0.3, 0.6), (0.3, 0.0, 1.0)
            bpy.context.collection.objects.link(second)
            # It makes the light of the two different.
            tube = {"radius": 0.8, "depth": 4.0, "end_fill_type": "NOTHING"}
            made.add("tube", "cylinder", None, location=second.location, **tube)
            bpy.context.view_layer.update()
            self.bake(size=256, rays=64)
            shown = [self.baked(item) for item in (first, second)]
            self.assertEqual(shown[0].data == shown[1].data, not own)
            with_blender.camera_above(4.0)
            pictures.append(with_blender.render(self.folder + "/view.exr", 4, 96, 0.0)[..., :3])
        error = np.abs(pictures[0] - pictures[1])
        halves = [pictures[0][40:56, at : at + 16].mean() for at in (21, 59)]
        self.assertGreater(halves[0], 1.5 * halves[1])
        self.assertLess(error.mean(), 0.003)
        self.assertLess(np.sqrt((error**2).mean()), 0.01)

    def test_a_second_bake_is_of_the_originals_and_replaces_the_copies(self):
        made.make()
        self.bake(show="diffuse", rays=4)
        self.bake(show="diffuse", rays=4)
        counts = [len(of) for of in (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.collections)]
        first = self.image("diffuse")
        for shown in (True, False):
            from ambake import nodes

            nodes.switch(shown)
            self.bake(show="diffuse", rays=4)
            self.assertTrue((self.image("diffuse") == first).all(), f"copies shown: {shown}")
            again = [len(of) for of in (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.collections)]
            self.assertEqual(again, counts)

    def test_a_selected_copy_stands_for_its_object(self):
        doubled = made.make()["doubled"]
        bpy.ops.object.select_all(action="DESELECT")
        doubled.select_set(True)
        for _ in range(2):
            notes = self.bake(targets="SELECTED", rays=4)
            self.assertTrue(self.baked(doubled).select_get())
            self.assertIn("1 object is shown by baked copies", notes[-1])

    def test_a_failed_bake_leaves_the_copies_shown(self):
        doubled = made.make()["doubled"]
        self.bake(rays=4)
        with self.assertRaisesRegex(ValueError, "no-such-flag"):
            self.bake(further="--no-such-flag")
        self.assertTrue(doubled.hide_render)
        self.assertFalse(self.baked(doubled).hide_render)

    def test_an_object_whose_copy_was_deleted_is_shown_and_baked_again(self):
        doubled = made.make()["doubled"]
        self.bake(rays=4)
        bpy.data.objects.remove(self.baked(doubled))
        self.assertTrue(doubled.hide_render)
        self.bake(rays=4)
        self.assertIsNot(self.baked(doubled), doubled)
        bpy.data.objects.remove(self.baked(doubled))
        bpy.ops.ambake.switch()
        self.assertFalse(doubled.hide_render)

    def test_a_copy_that_a_user_hides_stays_hidden(self):
        doubled = made.make()["doubled"]
        self.bake(rays=4)
        copy = self.baked(doubled)
        copy.hide_render = True
        with self.assertRaisesRegex(ValueError, "no-such-flag"):
            self.bake(further="--no-such-flag")
        self.assertTrue(copy.hide_render)

    def test_nodes_of_an_earlier_extension_are_made_whole(self):
        from ambake import nodes

        made.make()
        old = bpy.data.node_groups.new(nodes.GROUP, "ShaderNodeTree")
        for name, kind in (("Shader", "Shader"), ("Light", "Color"), ("Base Color", "Color"), ("Alpha", "Float")):
            old.interface.new_socket(name, in_out="INPUT", socket_type=f"NodeSocket{kind}")
        old.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        self.bake(rays=4)
        names = [socket.name for socket in old.interface.items_tree if socket.in_out == "INPUT"]
        self.assertEqual(len(names), len(set(names)))
        self.assertTrue(set(nodes.INPUTS) <= set(names))

    def test_one_undo_takes_all_back(self):
        doubled = made.make()["doubled"]
        name = doubled.name
        self.settings(rays=4)
        bpy.ops.ed.undo_push(message="before")
        before = sorted((i.name, i.hide_render, i.hide_viewport) for i in bpy.data.objects)
        self.assertEqual(bpy.ops.ambake.bake(), {"FINISHED"})
        self.assertTrue(bpy.data.objects[name].hide_render)
        bpy.ops.ed.undo_push(message="after")
        bpy.ops.ed.undo()
        self.assertEqual(sorted((i.name, i.hide_render, i.hide_viewport) for i in bpy.data.objects), before)
        self.assertNotIn("ambake", bpy.data.node_groups)
        self.assertFalse([i for i in bpy.data.objects if i.type == "MESH" and "ambake" in i.data.uv_layers])

    def test_polygons_that_a_chart_cuts_become_triangles_in_the_copy_alone(self):
        made.make()
        mesh = bpy.data.meshes.new("folded")
        # A quad that is folded along its diagonal by more than a chart can be.
        mesh.from_pydata([(0, 0, 3), (1, 0, 5), (1, 1, 3), (0, 1, 5)], [], [(0, 1, 2, 3)])
        folded = bpy.data.objects.new("folded", mesh)
        bpy.context.collection.objects.link(folded)
        bpy.context.view_layer.update()
        self.bake(layers="position", rays=2, size=192, seams="off")
        copy = self.baked(folded)
        self.assertEqual(len(copy.data.polygons), 2, "the test needs a cut polygon")
        self.assertEqual(len(mesh.polygons), 1)
        self.assertNotIn("ambake", mesh.uv_layers)
        self.assertFalse(copy.data.validate())
        self.positions_agree(copy, 2.0)


if __name__ == "__main__":
    with_blender.main()
