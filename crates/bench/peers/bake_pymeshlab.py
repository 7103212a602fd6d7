"""Bakes one mesh with MeshLab's ambient occlusion: bake_pymeshlab.py MESH.npz OUT.npy SIZE RAYS SEED THREADS DISTANCE.

MeshLab computes it for each face, from the face's middle, so that every texel adds a triangle of a thousandth of its scene's size at its
centre; the faces of the scene are computed as well, which nobody can prevent. Directions are one Fibonacci spiral over the whole sphere, the
same everywhere and under every seed, of which each face takes those in front of it with the weight of their cosine: 2 RAYS of them are asked
for. There is no distance beyond which it would not look.
"""

import importlib.metadata
import json
import os
import sys
import time

mesh_path, out, size, rays, _, threads, _ = sys.argv[1:]
os.environ["OMP_NUM_THREADS"] = threads

import numpy as np  # noqa: E402
import pymeshlab  # noqa: E402

size, rays = int(size), int(rays)
data = np.load(mesh_path)
positions, faces, at, normal = (data[name] for name in ("positions", "faces", "at", "normal"))

wall, cpu = time.perf_counter(), time.process_time()
extent = float(np.linalg.norm(np.ptp(positions, axis=0)))
tangent = np.cross(normal, np.where(np.abs(normal[:, :1]) < 0.5, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]]))
tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
bitangent = np.cross(normal, tangent)
middle, edge = at + 1e-6 * extent * normal, 1e-6 * extent
turns = [(np.cos(a), np.sin(a)) for a in 2 * np.pi * np.arange(3) / 3]
corners = np.stack([middle + edge * (c * tangent + s * bitangent) for c, s in turns], 1).reshape(-1, 3)
own = np.arange(len(corners)).reshape(-1, 3) + len(positions)
meshes = pymeshlab.MeshSet(verbose=False)
vertices, triangles = np.concatenate((positions, corners)), np.concatenate((faces, own)).astype(np.int32)
meshes.add_mesh(pymeshlab.Mesh(vertices.astype(np.float64), triangles))
meshes.compute_scalar_ambient_occlusion(rays=2 * rays)
# It gives sums of cosines, which over the whole hemisphere are half of their number.
result = meshes.current_mesh().face_scalar_array()[len(faces) :] / (rays / 2)
cpu, wall = time.process_time() - cpu, time.perf_counter() - wall

image = np.full(size * size, np.nan, np.float32)
image[data["texel"]] = result
np.save(out, image)
version = f"pymeshlab {importlib.metadata.version('pymeshlab')}"
print("PEER " + json.dumps({"cpu": cpu, "wall": wall, "version": version}), flush=True)
