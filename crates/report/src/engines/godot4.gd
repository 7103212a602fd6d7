@tool
extends EditorScenePostImport
# Written by ambake. Godot 4 runs it when it imports STEM.godot.glb: each material that was baked shows its page of the
# lightmap, sampled at UV2 and multiplied by its own colour. Nothing else lights it.

const MARK := ".ambake."


func _post_import(scene: Node) -> Object:
	_walk(scene, get_source_file().get_basename().get_basename(), {})
	return scene


func _walk(node: Node, stem: String, done: Dictionary) -> void:
	if node is MeshInstance3D and node.mesh != null:
		for i in node.mesh.get_surface_count():
			var material: Material = node.mesh.surface_get_material(i)
			if material is BaseMaterial3D and MARK in material.resource_name and not done.has(material):
				done[material] = true
				var page: String = material.resource_name.split(MARK)[-1]
				_show(material, stem + "." + page + ".lightmap.exr")
	for child in node.get_children():
		_walk(child, stem, done)


func _show(material: BaseMaterial3D, path: String) -> void:
	var light := load(path) as Texture2D
	if light == null:
		push_error("ambake: there is no " + path)
		return
	material.shading_mode = BaseMaterial3D.SHADING_MODE_UNSHADED
	material.detail_enabled = true
	material.detail_blend_mode = BaseMaterial3D.BLEND_MODE_MUL
	material.detail_uv_layer = BaseMaterial3D.DETAIL_UV_2
	material.detail_albedo = light
