# Draws courtyard.godot.glb, which --for godot wrote, into the file that OUT names, and ends.
extends SceneTree

func _init():
	var view = get_root()
	view.msaa = Viewport.MSAA_4X
	VisualServer.set_default_clear_color(Color8(101, 101, 101))
	view.add_child(load("res://courtyard.godot.glb").instance())
	var camera = Camera.new()
	view.add_child(camera)
	camera.fov = 40.0
	camera.look_at_from_position(Vector3(9, 6, 12), Vector3(0, 1, 0), Vector3.UP)
	camera.make_current()
	for _frame in 6:
		yield(self, "idle_frame")
	yield(VisualServer, "frame_post_draw")
	var picture = view.get_texture().get_data()
	picture.flip_y()
	picture.save_png(OS.get_environment("OUT"))
	quit()
