tool
extends EditorScenePostImport
# Written by ambake. Godot 3 runs it when it imports STEM.godot.glb: each material that was baked shows its page of the
# lightmap, sampled at UV2 and multiplied by its own colour. Nothing else lights it.

const MARK = ".ambake."

func post_import(scene):
	_walk(scene, get_source_file().get_basename().get_basename(), {})
	return scene

func _walk(node, stem, done):
	if node is MeshInstance and node.mesh:
		for i in node.mesh.get_surface_count():
			var material = node.mesh.surface_get_material(i)
			if material is SpatialMaterial and MARK in material.resource_name and not done.has(material):
				done[material] = true
				var page = material.resource_name.split(MARK)[-1]
				_show(material, stem + "." + page + ".lightmap.exr", done)
	for child in node.get_children():
		_walk(child, stem, done)

func _show(material, path, done):
	var light = load(path)
	if not light:
		push_error("ambake: there is no " + path)
		return
	material.flags_unshaded = true
	material.detail_enabled = true
	material.detail_blend_mode = SpatialMaterial.BLEND_MODE_MUL
	material.detail_uv_layer = SpatialMaterial.DETAIL_UV_2
	if ProjectSettings.get_setting("rendering/quality/driver/driver_name") == "GLES2":
		_encode(material, light, done)
	else:
		material.detail_albedo = light

# GLES2 multiplies colours as they are stored, and knows none above 1: there the light is stored as colours are, and the
# material takes its peak.
func _encode(material, light, done):
	if not done.has(light):
		var image = light.get_data()
		var peak = 0.001
		image.lock()
		for y in image.get_height():
			for x in image.get_width():
				var c = image.get_pixel(x, y)
				peak = max(peak, max(c.r, max(c.g, c.b)))
		peak = pow(peak, 1 / 2.2)
		for y in image.get_height():
			for x in image.get_width():
				var c = image.get_pixel(x, y)
				var stored = Color(pow(c.r, 1 / 2.2) / peak, pow(c.g, 1 / 2.2) / peak, pow(c.b, 1 / 2.2) / peak)
				image.set_pixel(x, y, stored)
		image.unlock()
		image.convert(Image.FORMAT_RGB8)
		var texture = ImageTexture.new()
		texture.create_from_image(image, Texture.FLAG_FILTER)
		done[light] = [texture, peak]
	var peak = done[light][1]
	var colour = material.albedo_color
	material.albedo_color = Color(colour.r * peak, colour.g * peak, colour.b * peak, colour.a)
	material.detail_albedo = done[light][0]
