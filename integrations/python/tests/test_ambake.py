"""The package from outside: values known on paper, shapes, layouts, errors, threads and Ctrl-C."""

import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import threading
import time

import ambake
import numpy as np
import pytest

SCENES = pathlib.Path(__file__).resolve().parents[3] / "scenes"

# A floor of 2 x 2 m, y up.
FLOOR = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], float)
QUAD = np.array([[0, 1, 2], [0, 2, 3]])


def walled(height=1.0):
    """The floor and a wall along its edge at x = -1."""
    wall = np.array([[-1, 0, -1], [-1, height, -1], [-1, height, 1], [-1, 0, 1]])
    return np.concatenate([FLOOR, wall]), np.concatenate([QUAD, QUAD + 4])


def test_a_lone_floor_sees_the_whole_sky():
    baked = ambake.bake(FLOOR, QUAD, size=32, rays=4)
    inside = baked["coverage"] > 0
    assert baked["diffuse"].shape == (32, 32) and baked["diffuse"].dtype == np.float32
    assert baked["lambert"].shape == (32, 32, 3)
    assert (baked["diffuse"][inside] == 1.0).all()
    assert baked["diffuse"].flags.writeable
    assert baked.stats[0]["rmse"] >= 0 and baked.stats[0]["texels"] == inside.sum()


def test_a_wall_darkens_the_floor_as_on_paper():
    # The wall is a rectangle of height h over an edge from -1 to 1: its form factor at a distance d is
    # (1/2π) Σ atan(a/d) - d/r atan(a/r), with r² = d² + h² and a the two parts of the edge.
    baked = ambake.bake(*walled(), size=64, rays=1024, seams="off", layers=["position", "normal"])
    position, up = baked["position"], baked["normal"][..., 1] > 0.99
    whole = up & (baked["coverage"] == 1.0)
    d, z = position[..., 0][whole] + 1.0, position[..., 2][whole]
    r = np.hypot(d, 1.0)
    taken = sum(np.arctan(a / d) - d / r * np.arctan(a / r) for a in (1.0 - z, 1.0 + z)) / (2 * np.pi)
    error = baked["diffuse"][whole] - (1.0 - taken)
    assert whole.sum() > 500
    # 1024 rays leave a standard error of about 0.002 a texel; a texel is 1/20 m wide, over which the term bends a little.
    assert np.sqrt((error**2).mean()) < 0.005, np.abs(error).max()


def test_the_corners_of_faces_lie_on_texels_of_their_positions():
    vertices, faces = walled()
    faces = np.insert(faces, 1, [[0, 0, 1]], axis=0)  # without area
    baked = ambake.bake(vertices, faces, size=64, rays=2, layers="position")
    assert baked.uvs.shape == (5, 3, 2) and baked.pages.tolist() == [0, -1, 0, 0, 0]
    for face in (0, 2, 3, 4):
        x, y = (baked.uvs[face].mean(axis=0) * 64).astype(int)
        there = baked["position"][y, x]
        assert np.abs(there - vertices[faces[face]].mean(axis=0)).max() < 0.1, (face, there)


def test_several_pages_are_lists():
    baked = ambake.bake_file(SCENES / "instances.gltf", size=64, rays=2, density=8.0)
    assert baked.page_count > 1
    assert [page.shape for page in baked["diffuse"]] == [(64, 64)] * baked.page_count
    assert {page for item in baked.objects for page in item.pages} == set(range(baked.page_count))
    with pytest.raises(ValueError, match="objects; see objects"):
        baked.uvs


def test_same_input_gives_the_same_bytes_at_any_number_of_threads():
    vertices, faces = walled()
    one, two = (ambake.bake(vertices, faces, size=32, rays=8, threads=n) for n in (1, 2))
    for layer in one:
        np.testing.assert_array_equal(one[layer], two[layer], err_msg=layer)


def test_glb_bytes_and_files_are_written_and_read(tmp_path):
    baked = ambake.bake(*walled(), size=32, rays=4, name="a wall 50 %")
    baked.write_gltf(tmp_path / "wall.glb")
    files = {os.path.basename(path) for path in baked.write(tmp_path / "out")}
    assert {"bake.json", "scene.0.exr", "scene.glb"} <= files
    glb = (tmp_path / "wall.glb").read_bytes()
    again = ambake.bake_file(glb, size=32, rays=4, model="phong")
    assert again.objects[0].name.startswith("a wall 50 %")
    assert again.keys() == baked.keys()
    # glTF is made for GGX, so that is what it gets unless told otherwise.
    assert "ggx" in ambake.bake_file(glb, size=32, rays=4)


def test_trimesh_comes_with_its_materials():
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.creation.box((1, 1, 1))
    mesh.visual = trimesh.visual.TextureVisuals(
        material=trimesh.visual.material.PBRMaterial(baseColorFactor=[255, 0, 0, 255], metallicFactor=0.0, roughnessFactor=1.0)
    )
    baked = ambake.bake(mesh, size=32, rays=4)
    red = baked["lambert"][baked["coverage"] == 1.0].mean(axis=0)
    assert red[0] > 10 * red[1], red
    assert baked.uvs.shape == (12, 3, 2)
    scene = trimesh.Scene({"box": mesh, "ball": trimesh.creation.icosphere(1)})
    assert len(ambake.bake(scene, size=64, rays=2).objects) == 2


def test_a_sky_of_pixels_lights_the_floor_as_on_paper():
    # Radiance 1 + y / 2 above and below: a floor receives 1 + (2/3) / 2 of it, a wall that faces +x sees 1.
    y = np.cos((np.arange(64) + 0.5) / 64 * np.pi)
    sky = np.repeat((1 + y / 2)[:, None, None], 128, axis=1) * [1.0, 0.5, 0.0]
    baked = ambake.bake(FLOOR, QUAD, size=16, rays=1024, sky=sky, layers="irradiance")
    light = baked["irradiance"][baked["coverage"] == 1.0].mean(axis=0)
    assert np.abs(light - np.array([1.0, 0.5, 0.0]) * 4 / 3).max() < 2e-3, light
    # Which way is +x: light from there alone does not reach a wall that looks to -x.
    east = np.zeros((32, 64, 3), np.float32)
    east[:, 40:56] = 1.0
    wall = FLOOR[:, [1, 0, 2]]
    options = dict(size=16, rays=16, sky=east, layers="irradiance")
    toward, away = (ambake.bake(wall, faces, **options) for faces in (QUAD[:, ::-1], QUAD))
    toward, away = (baked["irradiance"][baked["coverage"] == 1.0].mean() for baked in (toward, away))
    # A quarter of the turn about +x: (1/π) ∫ sin²θ dθ ∫ cos φ dφ.
    assert abs(toward - 0.5**0.5) < 0.01 and away == 0.0, (toward, away)
    np.testing.assert_array_equal(
        ambake.bake(FLOOR, QUAD, size=16, rays=4, sky=np.array([1.0, 0.5, 0.25]))["lambert"],
        ambake.bake(FLOOR, QUAD, size=16, rays=4, sky=(1.0, 0.5, 0.25))["lambert"],
    )


def test_layers_and_engines_are_lists_or_one_text(tmp_path):
    given = "bent, position", ["bent", "position"]
    one, many = (ambake.bake(FLOOR, QUAD, size=16, rays=4, layers=layers) for layers in given)
    assert one == many and {"bent", "position"} <= one.keys()
    ambake.bake(FLOOR, QUAD, size=16, rays=4, for_="three, godot", output=tmp_path)
    lightmaps = json.loads((tmp_path / "bake.json").read_text())["lightmaps"]
    assert {row["engine"] for row in lightmaps} == {"three", "godot"}
    assert all((tmp_path / row["file"]).is_file() for row in lightmaps)


def test_an_update_keeps_what_did_not_change(tmp_path):
    vertices, faces = walled()
    options = dict(size=64, rays=16)
    first = ambake.bake(vertices, faces, output=tmp_path / "first", **options)
    assert first == ambake.bake(vertices, faces, **options)
    same = ambake.bake(vertices, faces, update=tmp_path / "first", output=tmp_path / "same", **options)
    assert json.loads((tmp_path / "same" / "bake.json").read_text())["update"]["share"] == 0.0
    for layer in first:
        np.testing.assert_array_equal(same[layer], first[layer], err_msg=layer)
    lower = ambake.bake(*walled(0.5), update=str(tmp_path / "same"), **options)
    floor = [baked["diffuse"][baked["coverage"] > 0].mean() for baked in (first, lower)]
    assert floor[1] > floor[0] + 0.02, floor


def test_a_bake_is_pickled_and_has_a_short_name():
    baked = ambake.bake(*walled(), size=32, rays=4, layers="position")
    again = pickle.loads(pickle.dumps(baked))
    assert again == baked and again is not baked
    assert again.keys() == baked.keys() and again.stats == baked.stats and again.objects == baked.objects
    np.testing.assert_array_equal(again.uvs, baked.uvs)
    again["diffuse"][0, 0] += 1
    assert again != baked
    with pytest.raises(ValueError, match="pickled bake does not have its scene"):
        again.write("out")
    assert repr(baked).startswith(f"<ambake.Baked: {len(baked)} layers on 1 page of 32 x 32 texels, 1 object, rmse 0.")
    assert repr(again) == repr(baked) and len(repr(baked)) < 100
    pages = ambake.bake_file(SCENES / "instances.gltf", size=64, rays=2, density=8.0)
    assert pickle.loads(pickle.dumps(pages)) == pages


def test_a_textured_trimesh_comes_back():
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("PIL")
    vertices, faces = walled()
    baked = ambake.bake(vertices, faces, size=64, rays=16)
    mesh = baked.to_trimesh()
    assert isinstance(mesh, trimesh.Trimesh) and isinstance(mesh.visual, trimesh.visual.TextureVisuals)
    assert abs(mesh.area - 6.0) < 1e-9 and mesh.triangles.shape == (4, 3, 3)
    np.testing.assert_allclose(mesh.triangles, vertices[faces])
    # The colour at the middle of each face is that of the page there, in sRGB.
    middles = mesh.visual.uv[mesh.faces].mean(axis=1)
    seen = mesh.visual.material.to_color(middles)[:, 0] / 255
    x, y = (baked.uvs.mean(axis=1) * 64).astype(int).T
    exact = 1.055 * baked["lambert"][y, x, 0] ** (1 / 2.4) - 0.055
    # trimesh takes the nearest of the 64 texels by a rule of its own, light differs little between neighbours.
    assert np.abs(seen - exact).max() < 0.03, (seen, exact)
    assert len(trimesh.load(trimesh.util.wrap_as_stream(mesh.export(file_type="glb")), file_type="glb").geometry) == 1
    scene = ambake.bake_file(SCENES / "instances.gltf", size=64, rays=2, density=8.0)
    parts = scene.to_trimesh("diffuse")
    assert isinstance(parts, trimesh.Scene)
    assert sum(len(part.faces) for part in parts.geometry.values()) == sum(len(item.faces) for item in scene.objects)
    np.testing.assert_allclose(parts.bounds, trimesh.load(SCENES / "instances.gltf").bounds, atol=1e-5)
    with pytest.raises(ValueError, match="layer: there is no 'bent' in this bake; there are coverage"):
        baked.to_trimesh("bent")
    with pytest.raises(ValueError, match="layer: 'sh' has 12 channels, a texture has 1 or 3"):
        ambake.bake(FLOOR, QUAD, size=16, rays=4, layers="sh").to_trimesh("sh")


@pytest.mark.parametrize(
    ("call", "kind", "words"),
    [
        (lambda: ambake.bake(FLOOR[:, :2], QUAD), ValueError, r"vertices: expected shape \(n, 3\), got \(4, 2\)"),
        (lambda: ambake.bake(FLOOR, QUAD + 1), ValueError, "faces: vertex 4 does not exist, there are 4"),
        (lambda: ambake.bake(FLOOR, QUAD - 1), ValueError, "faces: vertex -1 does not exist"),
        (lambda: ambake.bake(FLOOR, QUAD * 1.0), ValueError, "faces: expected whole numbers, got float64"),
        (lambda: ambake.bake(FLOOR * np.nan, QUAD), ValueError, "finite"),
        (lambda: ambake.bake(FLOOR, QUAD, uvs=FLOOR[:3, :2]), ValueError, "3 uvs for 4 positions"),
        (lambda: ambake.bake(FLOOR, QUAD[:0]), ValueError, "no mesh has a triangle"),
        (lambda: ambake.bake("floor"), TypeError, "faces: give them"),
        (lambda: ambake.bake(FLOOR, QUAD, size=0), ValueError, "size: must be a whole number from 1 to 16384"),
        (lambda: ambake.bake(FLOOR, QUAD, size=-1), ValueError, "size: below 0 or too large"),
        (lambda: ambake.bake(FLOOR, QUAD, size="big"), TypeError, "size: "),
        (lambda: ambake.bake(FLOOR, QUAD, sise=64), TypeError, "there is no option sise; there are size"),
        (lambda: ambake.bake(FLOOR, QUAD, seams="all"), ValueError, 'seams: "all" is none of off, object, scene'),
        (lambda: ambake.bake(FLOOR, QUAD, layers=["ao"]), ValueError, 'layers: there is no layer "ao"'),
        (lambda: ambake.bake(FLOOR, QUAD, rays=4, target_error=0.1), ValueError, "rays and target_error exclude"),
        (lambda: ambake.bake(FLOOR, QUAD, max_rays=64), ValueError, "max_rays needs target_error"),
        (lambda: ambake.bake(FLOOR, QUAD, sky="no.hdr"), ValueError, "no.hdr"),
        (lambda: ambake.bake(FLOOR, QUAD, sky=np.ones((4, 8))), ValueError, r"sky: expected .*\(height, width, 3\), got \(4, 8\)"),
        (lambda: ambake.bake(FLOOR, QUAD, sky=np.ones((4, 4, 3))), ValueError, "sky: 4 x 4 pixels are no polar map"),
        (lambda: ambake.bake(FLOOR, QUAD, sky=-np.ones((4, 8, 3))), ValueError, r"red of pixel \(0, 0\) is -1"),
        (lambda: ambake.bake(FLOOR, QUAD, sky=np.array(["blue"])), ValueError, "sky: not an array of numbers"),
        (lambda: ambake.bake(FLOOR, QUAD, sky=7), TypeError, "sky: expected"),
        (lambda: ambake.bake(FLOOR, QUAD, layers="bent,ao"), ValueError, 'layers: there is no layer "ao"'),
        (lambda: ambake.bake(FLOOR, QUAD, for_="quake"), ValueError, 'for_: there is no engine "quake"; there are'),
        (lambda: ambake.bake_file("no such.obj"), FileNotFoundError, "there is no scene file no such.obj"),
        (lambda: ambake.bake_file(b"no glb"), ValueError, "^scene.glb: "),
    ],
)
def test_a_mistake_is_one_clear_line(call, kind, words):
    with pytest.raises(kind, match=words) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_options_of_every_kind_are_taken():
    values = dict(
        size=32, density=4.0, density_of={"m*": 4.0}, include="mesh", exclude=["other"], no_cast="mesh", seen_from=[(0, 3, 0)], pages=2,
        one_page_per_mesh=True, uv="unwrap", gutter=1, mips=1, align=2, target_error=0.3, target_relative=0.3, max_rays=16,
        footprint="centre", denoise="regression", seams="object", sky=(1, 0.5, 0.2), max_memory="8G", view=(0, 5, 0),
        up="z", buried="keep", buried_of={"m*": "drop"}, under=0.01, shading="exact", max_distance=2.0, model="ggx", bounces=1, lights="none",
        sun=[(0, 1, 0, 2), (0, 1, 0, 2, 1, 0)], point=[(0, 3, 0, 1)],
        sphere=[(1, 2, 0, 0.5, 1)], rect=[(0, 3, 0, 1, 0, 0, 0, 0, 1, 2)], only="diffuse,lambert", to="vertices", for_=["three"], compress=True, normal_maps=True, exponent=8,
        ambient_coefficient=(0.2, 0.3, 0.4), albedo=(0.5, 0.5, 0.5), specular=(0.1, 0.1, 0.1), seed=7, backend="obvhs", threads=1,
    )
    # `footprint` is for comparisons with other programs: it is taken, but not listed, as in the program's help.
    assert set(values) - {"footprint"} < set(ambake.OPTIONS)
    meshes = [v for v in values if v != "exclude"]
    baked = ambake.bake(*walled(), **{name: values[name] for name in meshes})
    # Where light is added no other layer holds what arrives, so a bake of a model has it too, and that of lights alone.
    assert set(baked) == {"coverage", "diffuse", "lambert", "irradiance", "direct"}


def test_other_threads_run_and_progress_is_told():
    ticks, told = [], []
    done = threading.Event()

    def tick():
        while not done.wait(0.01):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    ambake.bake(*walled(), size=128, rays=256, progress=lambda done, total: told.append((done, total)))
    done.set()
    thread.join()
    assert len(ticks) > 3
    assert told and all(0 < done <= total for done, total in told)


def test_what_progress_raises_stops_the_bake():
    def stop(_done, _total):
        raise RuntimeError("enough")

    started = time.monotonic()
    with pytest.raises(RuntimeError, match="enough"):
        ambake.bake(*walled(), size=2048, rays=4096, progress=stop)
    assert time.monotonic() - started < 20


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_is_a_keyboard_interrupt():
    code = (
        "import signal, ambake, numpy as np\n"
        # A shell that starts the tests in the background has them ignore it.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "v = np.array([[-1,0,-1],[-1,0,1],[1,0,1],[-1,1,0]], float)\n"
        "print('go', flush=True)\n"
        "try: ambake.bake(v, np.array([[0,1,2],[0,1,3]]), size=2048, rays=4096)\n"
        "except KeyboardInterrupt: print('interrupted')\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "go\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=30)[0] == "interrupted\n"


def test_probes_are_arrays_of_harmonics(tmp_path):
    found = ambake.probes(SCENES / "courtyard.obj", grid=(3, 2, 4), rays=64, tried=0, sky=(1, 1, 1), sun=[(0, 1, 0, 2)])
    assert found.grid["counts"] == (3, 2, 4) and found.positions.shape == (24, 3)
    assert found.sh.shape == found.std_err.shape == (24, 9, 3) and found.sh.dtype == np.float32
    assert found.validity.shape == found.invalid.shape == (24,) and found.invalid.dtype == bool
    # x runs first; far above all the light is that of the sky, the sun and what the ground sends back.
    step = found.positions[1] - found.positions[0]
    assert step[0] > 0 and abs(step[1:]).max() == 0
    high = ambake.probes(SCENES / "courtyard.obj", at=[(0, 1e5, 0)], bounces=0)
    # Nothing but the sky is there: 1 in all directions, less the speck that the courtyard is.
    assert abs(high.sh[0, 0, 0] - 2 * np.sqrt(np.pi)) < 0.01 and high.grid is None
    names = [pathlib.Path(path).name for path in found.write(tmp_path, ["bevy"])]
    assert "courtyard.probes.json" in names and "courtyard.probes.bevy.ktx2" in names
    for options in [{}, {"at": [(0, 0, 0)], "spacing": 1.0}, {"at": [(0, 0, 0)], "rays": 1}]:
        with pytest.raises(ValueError):
            ambake.probes(SCENES / "courtyard.obj", **options)
    with pytest.raises(TypeError):
        ambake.probes(SCENES / "courtyard.obj", at=[(0, 0, 0)], size=3)
