"""Baked copies, in Blender without a window: what stays of modifiers, shared meshes and polygons, and the ways back.

    AMBAKE=target/debug/ambake python integrations/blender/tests/test_copies.py

needs what test_blender.py needs."""

import with_blender  # first: it prints a skip where Blender is absent
from with_blender import BlenderTest, bpy

import made


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

    def test_twins_stay_linked(self):
        first, second = made.make()["twins"]
        self.bake(rays=4)
        self.assertIs(first.data, second.data)
        self.assertNotIn("ambake", first.data.uv_layers)
        self.assertIsNot(self.baked(first).data, self.baked(second).data)

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
