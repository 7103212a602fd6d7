"""Bakes one mesh with Open3D's ray test: bake_open3d.py MESH.npz OUT.npy SIZE RAYS SEED THREADS DISTANCE.

The texel centres and directions of bake_mitsuba.py, made by numpy in batches. Timed are scene, directions, rays and result.
"""

import json
import sys
import time

import numpy as np
import open3d as o3d

mesh_path, out, size, rays, seed, threads, distance = sys.argv[1:]
size, rays, seed, threads, distance = int(size), int(rays), int(seed), int(threads), float(distance)
data = np.load(mesh_path)

wall, cpu = time.perf_counter(), time.process_time()
positions = data["positions"].astype(np.float32)
scene = o3d.t.geometry.RaycastingScene(nthreads=threads)
scene.add_triangles(o3d.core.Tensor(positions), o3d.core.Tensor(data["faces"].astype(np.uint32)))
lift = 1e-6 * float(np.linalg.norm(np.ptp(positions, axis=0)))
normal = data["normal"].astype(np.float32)
origin = (data["at"] + lift * data["normal"]).astype(np.float32)
shift = np.random.default_rng(seed).random((len(normal), 2), np.float32)
# T. Duff and others, "Building an Orthonormal Basis, Revisited", 2017.
sign = np.copysign(np.float32(1), normal[:, 2])
a = -1 / (sign + normal[:, 2])
b = normal[:, 0] * normal[:, 1] * a
tangent = np.stack((1 + sign * normal[:, 0] ** 2 * a, sign * b, -sign * normal[:, 0]), 1)
bitangent = np.stack((b, sign + normal[:, 1] ** 2 * a, -normal[:, 1]), 1)
index = np.arange(rays, dtype=np.float64)
lattice = np.modf(index * 2654435769 * 2.0**-32)[0].astype(np.float32)
result = np.empty(len(normal), np.float32)
batch = max(1, 2_000_000 // rays)
for first in range(0, len(normal), batch):
    part = slice(first, first + batch)
    u = (index.astype(np.float32) + shift[part, :1]) / rays
    angle = 2 * np.pi * (lattice + shift[part, 1:])
    local = np.stack((np.sqrt(u) * np.cos(angle), np.sqrt(u) * np.sin(angle), np.sqrt(np.maximum(0, 1 - u))), 2)
    frame = np.stack((tangent[part], bitangent[part], normal[part]), 1)
    directions = np.einsum("nrk,nkc->nrc", local, frame, dtype=np.float32)
    packed = np.concatenate((np.broadcast_to(origin[part, None], directions.shape), directions), 2)
    hits = scene.test_occlusions(o3d.core.Tensor(np.ascontiguousarray(packed, np.float32)), tnear=0.0, tfar=min(distance, 3e38))
    result[part] = 1 - hits.numpy().mean(1)
cpu, wall = time.process_time() - cpu, time.perf_counter() - wall

image = np.full(size * size, np.nan, np.float32)
image[data["texel"]] = result
np.save(out, image)
print("PEER " + json.dumps({"cpu": cpu, "wall": wall, "version": f"open3d {o3d.__version__}"}), flush=True)
