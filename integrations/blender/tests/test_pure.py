"""What needs no Blender: GLB and EXR files, corners, arguments, progress, the zip. Needs numpy, else prints a skip.

    python3 integrations/blender/tests/test_pure.py"""

import importlib
import os
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest
import zipfile

try:
    import numpy as np
except ImportError:
    print("skip: numpy is absent (pip install numpy)")
    sys.exit(1 if os.environ.get("AMBAKE_TEST_STRICT") == "1" else 0)

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent

# The package without its `__init__`, which needs Blender.
package = types.ModuleType("ambake")
package.__path__ = [str(HERE.parent / "ambake")]
sys.modules["ambake"] = package
command, corners, exr, glb = (importlib.import_module(f"ambake.{name}") for name in ("command", "corners", "exr", "glb"))


def settings(**values):
    plain = dict(
        show="irradiance", layers="", size=512, density=0.0, effort="RAYS", rays=64, target_error=0.005, target_relative=0.0,
        max_rays=4096, sky=(1.0, 1.0, 1.0), sky_file="", max_distance=0.0, backend="auto", uv="auto", gutter=2, mips=0,
        seams="scene", denoise="off", seed=0, normal_maps=False, threads=0, further="",
        probe_engines=" bevy, three", bounces=0,
    )
    return types.SimpleNamespace(**{**plain, **values})


class Command(unittest.TestCase):
    def line(self, occluders=False, **values):
        asked = settings(**values)
        return " ".join(command.arguments(asked, "in.glb", "out", occluders, command.sky(asked)))

    def test_flags_are_those_of_the_command_line(self):
        self.assertEqual(
            self.line(),
            "bake in.glb -o out --json --size 512 --rays 64 --sky 1,1,1 --uv auto --gutter 2 --mips 0 --seams scene --denoise off "
            "--seed 0 --layers irradiance",
        )

    def test_probes_fill_a_box_with_the_light_of_the_bake(self):
        box = (-1.0, 0.0, -2.5), (1.0, 2.0, 2.5), (4, 2, 8)
        words = command.probe_arguments(settings(threads=2), "in.glb", "out", ["--sky", "1,1,1"], *box)
        self.assertEqual(
            " ".join(words),
            "probes in.glb -o out --json --within=-1,0,-2.5:1,2,2.5 --grid 4x2x8 --for bevy,three --sky 1,1,1 --threads 2 --seed 0",
        )
        self.assertNotIn("--for", command.probe_arguments(settings(probe_engines=""), "in.glb", "out", [], *box))

    def test_a_target_error_takes_the_place_of_rays(self):
        # 0.005 as Blender keeps it, in 32 bits.
        line = self.line(effort="TARGET", target_error=0.004999999888241291)
        self.assertIn("--target-error 0.005 --max-rays 4096", line)
        self.assertNotIn("--rays", line.replace("--max-rays", ""))

    def test_the_shown_layer_comes_first_and_standard_layers_need_no_flag(self):
        self.assertEqual(command.layers(settings(show="lambert", layers="bent, lambert error")), ["lambert", "bent", "error"])
        self.assertNotIn("--layers", self.line(show="diffuse"))

    def test_further_flags_keep_their_quotes(self):
        words = command.arguments(settings(further="--exclude 'a b'"), "in.glb", "out", True, [])
        self.assertEqual(words[-2:], ["--exclude", "a b"])
        self.assertIn("--exclude ambake-occluder: *", self.line(occluders=True))

    def test_progress_is_read_from_ambakes_own_lines(self):
        seen = command.progress("baking: 25 of 100 texels, 3.0 million rays/s, 30 seconds left\n")
        self.assertEqual((seen.share, seen.text), (0.25, "3.0 million rays/s, 30 seconds left"))
        self.assertEqual(command.progress("0 of 0 texels, ? left").share, 0.0)
        self.assertIsNone(command.progress("error: no such file"))

    def test_the_complaint_is_the_line_that_says_what_is_wrong(self):
        clap = ["error: unexpected argument '--x' found", "Usage: ambake bake", "For more information, try '--help'."]
        self.assertEqual(command.complaint(clap, 2), "unexpected argument '--x' found")
        self.assertEqual(command.complaint([], 9), "ambake ended with status 9")

    def test_what_was_left_out_of_materials_is_told_and_advice_is_not(self):
        coat = dict(kind="ignored-extensions", place="material `coat`", count=2, message="baked without its coat")
        size = dict(kind="small-page", place="pages of 32²", count=1, message="`--size 256`")
        told = command.untaken({"warnings": [coat, size]})
        self.assertEqual(told, ["material coat and others: baked without its coat"])

    def test_a_run_can_be_cancelled(self):
        run = command.Run(sys.executable, ["-c", "import time; time.sleep(60)"])
        self.assertTrue(run.running())
        run.cancel()
        self.assertFalse(run.running())
        with self.assertRaises(ValueError):
            run.result()

    def test_a_missing_program_says_how_to_get_it(self):
        before, os.environ["PATH"] = os.environ["PATH"], ""
        try:
            with self.assertRaisesRegex(ValueError, "install it"):
                command.find("")
        finally:
            os.environ["PATH"] = before
        with self.assertRaisesRegex(ValueError, "/no/such is not a program"):
            command.find("/no/such")


class Corners(unittest.TestCase):
    def scene(self, *paths):
        """A document of nodes with one mesh: a path is the names of the parents and of the node."""
        nodes, at = [], {}
        for path in paths:
            names = path.split("/")
            parent = None
            for name in names[:-1]:
                if at.get(name) is None:
                    at[name] = len(nodes)
                    nodes.append({"name": name, "children": []})
                parent = at[name]
            nodes.append({"name": names[-1], "mesh": 0})
            if parent is not None:
                nodes[parent]["children"].append(len(nodes) - 1)
        return glb.Glb({"nodes": nodes}, b"")

    def test_instances_that_repeat_a_name_only_cast_shadows(self):
        scene = self.scene("shelf/box", "box", "lamp 50%*")
        found = corners.set_apart(scene, {"box": ["box"]})
        self.assertEqual(found, ({"box"}, True))
        names = [node["name"] for node, _ in scene.mesh_nodes()]
        self.assertEqual(names, ["ambake-occluder: box", "box", "ambake-occluder: lamp 50%*"])
        self.assertEqual(corners.set_apart(self.scene("a"), {"a": ["bone", "a"]}), ({"a"}, False))

    def test_a_quad_in_one_chart_stays_a_quad(self):
        part = corners.Baked(
            np.array([[0, 1, 2], [0, 2, 3]]),
            np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], float),
            np.zeros(2, int),
        )
        got = corners.unfold(part, np.array([0]), np.array([4]))
        np.testing.assert_array_equal(got.uvs, [[0, 0], [1, 0], [1, 1], [0, 1]])
        self.assertEqual((got.pages.tolist(), got.cut), ([0], {}))

    def test_a_quad_over_two_charts_or_pages_is_cut(self):
        triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6]])
        uvs = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0.5], [1, 1], [0, 1]], [[0, 0], [1, 0], [1, 1]]])
        got = corners.unfold(corners.Baked(triangles, uvs, np.zeros(3, int)), np.array([0, 4]), np.array([4, 3]))
        self.assertEqual(list(got.cut), [0])
        self.assertEqual([page for _, _, page in got.cut[0]], [0, 0])
        uvs[1, 0] = 0.0
        got = corners.unfold(corners.Baked(triangles, uvs, np.array([0, 1, 1])), np.array([0, 4]), np.array([4, 3]))
        self.assertEqual([page for _, _, page in got.cut[0]], [0, 1])

    def test_a_corner_without_area_lies_somewhere_in_its_polygon(self):
        part = corners.Baked(np.array([[0, 1, 2]]), np.array([[[0.2, 0], [1, 0], [1, 1]]]), np.zeros(1, int))
        got = corners.unfold(part, np.array([0, 4]), np.array([4, 3]))
        self.assertEqual(got.uvs[3].tolist(), [0.2, 0.0])
        self.assertEqual(got.pages.tolist(), [0, -1])


class Files(unittest.TestCase):
    def test_a_baked_page_reads_as_openexr_reads_it(self):
        program = os.environ.get("AMBAKE")
        if not program:
            self.skipTest("AMBAKE does not name the program")
        try:
            import OpenEXR
        except ImportError:
            OpenEXR = None
        with tempfile.TemporaryDirectory() as folder:
            scene = ROOT / "scenes" / "courtyard.obj"
            subprocess.run([program, "bake", scene, "-o", folder, "--size", "72", "--rays", "1", "--quiet"], check=True)
            page = exr.Page(f"{folder}/courtyard.0.exr")
            self.assertEqual((page.width, page.height), (72, 72))
            self.assertEqual(page.layer("lambert").shape, (72, 72, 3))
            coverage = page.channel("coverage")
            self.assertTrue(0.0 <= coverage.min() and coverage.max() == 1.0)
            if OpenEXR:
                with OpenEXR.File(f"{folder}/courtyard.0.exr", separate_channels=True) as file:
                    for name, channel in file.channels().items():
                        np.testing.assert_array_equal(page.channel(name), channel.pixels)
            part = corners.baked(glb.Glb.read(f"{folder}/courtyard.glb"))
            self.assertEqual(part, {}, "a file that the add-on did not send")

    def test_other_files_are_refused_by_name(self):
        with tempfile.NamedTemporaryFile() as file:
            file.write(b"something else altogether")
            file.flush()
            for read in (exr.Page, glb.Glb.read):
                with self.assertRaisesRegex(ValueError, os.path.basename(file.name)):
                    read(file.name)

    def test_a_glb_is_written_as_it_was_read(self):
        with tempfile.TemporaryDirectory() as folder:
            path = f"{folder}/a.glb"
            glb.Glb({"asset": {"version": "2.0"}, "nodes": [{"name": "ä b"}]}, b"12345").write(path)
            again = glb.Glb.read(path)
            self.assertEqual(again.json["nodes"][0]["name"], "ä b")
            self.assertEqual(again.binary[:5], b"12345")

    def test_the_zip_has_the_manifest_on_top_and_the_same_bytes_twice(self):
        sys.path.insert(0, str(HERE.parent))
        import build

        with tempfile.TemporaryDirectory() as folder:
            path = build.build(pathlib.Path(folder))
            names = zipfile.ZipFile(path).namelist()
            self.assertIn("blender_manifest.toml", names)
            self.assertIn("__init__.py", names)
            first = path.read_bytes()
            self.assertEqual(build.build(pathlib.Path(folder)).read_bytes(), first)

    def test_a_zip_that_carries_the_program_needs_no_other(self):
        sys.path.insert(0, str(HERE.parent))
        import build

        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            program = folder / "program"
            program.write_bytes(b"MZ")
            with self.assertRaisesRegex(ValueError, "no program for Linux"):
                build.build(folder, program)
            program.write_bytes(b"\x7fELF\x02" + bytes(13) + b"\x3e\x00")
            path = build.build(folder, program)
            self.assertEqual(path.name, "ambake-0.1.0-linux-x64.zip")
            with zipfile.ZipFile(path) as archive:
                archive.extractall(folder / "extension")
            manifest = (folder / "extension" / "blender_manifest.toml").read_text()
            self.assertRegex(manifest, r'(?m)^platforms = \["linux-x64"\]\n\n\[permissions\]')
            before, command.INSIDE = command.INSIDE, str(folder / "extension" / "bin" / "ambake")
            try:
                self.assertFalse(os.access(command.INSIDE, os.X_OK), "a plain unpacking forgets the bit")
                self.assertEqual(command.find(""), command.INSIDE)
                self.assertTrue(os.access(command.INSIDE, os.X_OK))
                self.assertEqual(command.find(sys.executable), sys.executable)
            finally:
                command.INSIDE = before


if __name__ == "__main__":
    unittest.main()
