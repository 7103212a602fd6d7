"""Bakes one mesh with Mitsuba's vectorised ray test: bake_mitsuba.py MESH.npz OUT.npy SIZE RAYS SEED THREADS DISTANCE.

One lane a texel; directions are cosine-weighted from a Fibonacci lattice with a random toroidal shift per texel.
Texel centres are made by the driver and are not timed. Timed are scene, acceleration structure, kernel and result.
"""

import json
import sys
import time

import drjit as dr
import mitsuba as mi
import numpy as np

mesh_path, out, size, rays, seed, threads, distance = sys.argv[1:]
size, rays, seed, threads, distance = int(size), int(rays), int(seed), int(threads), float(distance)
mi.set_variant("llvm_ad_rgb")
dr.set_thread_count(threads)
data = np.load(mesh_path)


@dr.syntax
def trace(scene, origin, normal, shift, count, limit):
    frame = mi.Frame3f(normal)
    index, open_rays = mi.UInt32(0), mi.UInt32(0)
    step = mi.UInt32(2654435769)  # 2^32 over the golden ratio: the lattice's second coordinate wraps exactly
    while index < count:
        u = (mi.Float(index) + shift.x) / count
        v = mi.Float(index * step) * 2**-32 + shift.y
        angle = 2 * dr.pi * v
        radius = dr.sqrt(u)
        sine, cosine = dr.sincos(angle)
        local = mi.Vector3f(radius * cosine, radius * sine, dr.safe_sqrt(1 - u))
        ray = mi.Ray3f(origin, frame.to_world(local))
        ray.maxt = limit
        open_rays += dr.select(scene.ray_test(ray), mi.UInt32(0), mi.UInt32(1))
        index += 1
    return mi.Float(open_rays) / count


wall, cpu = time.perf_counter(), time.process_time()
positions, faces = data["positions"], data["faces"]
mesh = mi.Mesh("mesh", len(positions), len(faces))
parameters = mi.traverse(mesh)
parameters["vertex_positions"] = mi.Float(positions.astype(np.float32).ravel())
parameters["faces"] = mi.UInt32(faces.astype(np.uint32).ravel())
parameters.update()
scene = mi.load_dict({"type": "scene", "mesh": mesh})
# A millionth of the scene keeps a ray off its own triangle: less self-hits, more brightens contacts.
lift = 1e-6 * float(np.linalg.norm(np.ptp(positions, axis=0)))
normal = data["normal"]
origin = mi.Point3f((data["at"] + lift * normal).astype(np.float32).T)
shift = mi.Point2f(np.random.default_rng(seed).random((2, len(normal)), np.float32))
opaque = dr.opaque
values = trace(scene, origin, mi.Normal3f(normal.astype(np.float32).T), shift, opaque(mi.UInt32, rays), opaque(mi.Float, distance))
result = values.numpy()
cpu, wall = time.process_time() - cpu, time.perf_counter() - wall

image = np.full(size * size, np.nan, np.float32)
image[data["texel"]] = result
np.save(out, image)
print("PEER " + json.dumps({"cpu": cpu, "wall": wall, "version": f"mitsuba {mi.__version__}, drjit {dr.__version__}"}), flush=True)
