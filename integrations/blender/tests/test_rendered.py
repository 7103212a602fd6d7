"""What renders is in a bake, and Ray Visibility says what of it blocks light, in Blender without a window.

    AMBAKE=target/debug/ambake python integrations/blender/tests/test_rendered.py

needs what test_blender.py needs."""

import with_blender  # first: it prints a skip where Blender is absent
from with_blender import BlenderTest, bpy, look_up

import made
import numpy as np

NAME = "plate 50% [a] *?"


def into(item, collection):
    """Moves an object into a collection alone."""
    for holder in item.users_collection:
        holder.objects.unlink(item)
    collection.objects.link(item)


class Rendered(BlenderTest):
    def scene(self):
        """A floor and a plate close above its middle."""
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.floor = made.add("floor", "plane", None, size=4.0)
        self.plate = made.add(NAME, "plane", None, size=2.0, location=(0.0, 0.0, 0.3))

    def middle(self, **values):
        """What of the sky the middle of the floor sees, and the notes."""
        notes = self.bake(show="diffuse", rays=64, targets="VISIBLE", **values)
        uvs = np.array([u.vector for u in self.floor.data.uv_layers["ambake"].uv])
        return look_up(self.image("diffuse"), uvs.mean(axis=0))[0], notes

    def absent(self):
        seen, notes = self.middle()
        self.assertGreater(seen, 0.99)
        self.assertNotIn("ambake", self.plate.data.uv_layers)
        self.assertEqual(notes, [])

    def test_what_renders_blocks_light(self):
        self.scene()
        self.assertLess(self.middle()[0], 0.3)
        self.assertIn("ambake", self.plate.data.uv_layers)

    def test_an_object_that_is_disabled_in_renders_is_absent(self):
        self.scene()
        self.plate.hide_render = True
        self.absent()

    def test_a_child_of_a_disabled_object_is_baked(self):
        self.scene()
        child = made.add("child", "cube", None, size=0.2, location=(1.7, 1.7, 0.1))
        child.parent = self.plate
        self.plate.hide_render = True
        self.absent()
        self.assertIn("ambake", child.data.uv_layers)

    def test_collections_that_are_disabled_or_excluded_are_absent(self):
        for how in ("disabled", "below a disabled one", "excluded"):
            with self.subTest(how):
                self.scene()
                outer, inner = (bpy.data.collections.new(name) for name in ("outer", "inner"))
                bpy.context.scene.collection.children.link(outer)
                outer.children.link(inner)
                into(self.plate, inner)
                inner.hide_render, outer.hide_render = how == "disabled", how == "below a disabled one"
                bpy.context.view_layer.layer_collection.children["outer"].exclude = how == "excluded"
                bpy.context.view_layer.update()
                self.absent()

    def test_an_object_in_a_second_collection_that_renders_is_baked(self):
        self.scene()
        off = bpy.data.collections.new("off")
        bpy.context.scene.collection.children.link(off)
        off.objects.link(self.plate)
        off.hide_render = True
        self.assertLess(self.middle()[0], 0.3)

    def test_a_disabled_object_is_absent_from_instances_too(self):
        self.scene()
        shelf = bpy.data.collections.new("shelf")
        into(self.plate, shelf)
        stand = bpy.data.objects.new("stand", None)
        stand.instance_type, stand.instance_collection = "COLLECTION", shelf
        bpy.context.collection.objects.link(stand)
        bpy.context.view_layer.update()
        self.assertLess(self.middle()[0], 0.3)
        self.plate.hide_render = True
        self.assertGreater(self.middle()[0], 0.99)
        self.plate.hide_render, stand.hide_render = False, True
        self.assertGreater(self.middle()[0], 0.99)

    def test_ray_visibility_says_what_blocks_light_whatever_its_name(self):
        self.scene()
        self.plate.visible_shadow = self.plate.visible_diffuse = False
        seen, notes = self.middle()
        self.assertGreater(seen, 0.99)
        self.assertIn("ambake", self.plate.data.uv_layers)
        self.assertEqual(notes, [])
        # Where it takes no texels either.
        self.scene()
        self.plate.visible_shadow = self.plate.visible_diffuse = False
        bpy.ops.object.select_all(action="DESELECT")
        self.floor.select_set(True)
        self.bake(show="diffuse", rays=64, targets="SELECTED")
        self.assertGreater(self.image("diffuse").min(), 0.99)

    def test_half_a_ray_visibility_is_told(self):
        self.scene()
        self.plate.visible_diffuse = False
        seen, notes = self.middle()
        self.assertGreater(seen, 0.99)
        self.assertIn(f"{NAME} blocks neither lamps nor sky", notes[0])


if __name__ == "__main__":
    with_blender.main()
