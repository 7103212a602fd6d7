"""Bakes one mesh with Blender Cycles: bake_cycles.py MESH.npz OUT.npy SIZE RAYS SEED THREADS combined|ao DISTANCE.

No bounces, no denoiser, no adaptive sampling, no margin. The world is white and the surface has albedo 1, so that
COMBINED is the diffuse term. The background is not sampled as a light: its rays follow the cosine.
"""

import json
import sys
import time

import bpy
import numpy as np

mesh_path, out, size, rays, seed, threads, kind, distance = sys.argv[1:]
size, rays, seed, threads, distance = int(size), int(rays), int(seed), int(threads), float(distance)
data = np.load(mesh_path)
positions, uv, faces = data["positions"], data["uv"], data["faces"]

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
scene.render.threads_mode, scene.render.threads = "FIXED", threads
cycles = scene.cycles
cycles.device, cycles.samples, cycles.seed = "CPU", rays, seed
cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_auto_tile = False
cycles.max_bounces = cycles.diffuse_bounces = 0
cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0

world = bpy.data.worlds.new("white")
scene.world = world
world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
world.cycles.sampling_method = "NONE"
world.light_settings.distance = distance

mesh = bpy.data.meshes.new("mesh")
mesh.from_pydata(positions, [], faces)
mesh.shade_flat()
mesh.uv_layers.new(name="bake").data.foreach_set("uv", uv[faces].reshape(-1).astype(np.float32))
body = bpy.data.objects.new("mesh", mesh)
scene.collection.objects.link(body)
bpy.context.view_layer.objects.active = body
body.select_set(True)

image = bpy.data.images.new("bake", size, size, alpha=True, float_buffer=True, is_data=True)
image.pixels.foreach_set(np.full(size * size * 4, -1, np.float32))
material = bpy.data.materials.new("white")
material.use_nodes = True
nodes = material.node_tree.nodes
nodes.clear()
diffuse, output, texture = (nodes.new(f"ShaderNode{n}") for n in ("BsdfDiffuse", "OutputMaterial", "TexImage"))
diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
material.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
texture.image, nodes.active = image, texture
mesh.materials.append(material)

wall, cpu = time.perf_counter(), time.process_time()
bpy.ops.object.bake(type=kind.upper(), margin=0, use_clear=False)
cpu, wall = time.process_time() - cpu, time.perf_counter() - wall

pixels = np.empty(size * size * 4, np.float32)
image.pixels.foreach_get(pixels)
# Blender's row 0 is its v = 0; v was handed over unchanged, so rows agree with ambake's.
values = pixels.reshape(-1, 4)[:, 0].copy()
values[values < 0] = np.nan
np.save(out, values)
print("PEER " + json.dumps({"cpu": cpu, "wall": wall, "version": f"bpy {bpy.app.version_string}"}), flush=True)
