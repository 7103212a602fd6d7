"""Lamps as flags and as spots, against what is known on paper. Needs numpy alone, as test_pure.py does.

    python3 integrations/blender/tests/test_lamps.py"""

import importlib
import math
import types
import unittest

import test_pure  # first: it prints a skip where numpy is absent, and names the package
from test_pure import glb

import numpy as np

lamps = importlib.import_module("ambake.lamps")


def lamp(kind, **values):
    plain = dict(
        type=kind, energy=4.0 * math.pi, color=(1.0, 0.5, 0.0), angle=0.0, shadow_soft_size=0.0, size=2.0, size_y=1.0,
        shape="RECTANGLE", spread=math.pi, spot_size=math.pi / 2.0, spot_blend=0.0,
    )
    return types.SimpleNamespace(**{**plain, **values})


def taken(light, matrix=np.eye(4)):
    found = lamps.Lamps()
    found.add("a lamp", light, matrix)
    return found


def numbers(found):
    (flag,) = found.flags
    name, values = flag.split("=")
    return name, np.array([float(value) for value in values.split(",")])


class Lamps(unittest.TestCase):
    def test_a_point_of_4_pi_watts_has_an_intensity_of_one(self):
        place = np.eye(4)
        place[:3, 3] = 1.0, 2.0, 3.0
        name, values = numbers(taken(lamp("POINT"), place))
        self.assertEqual(name, "--point")
        np.testing.assert_allclose(values, [1, 3, -2, 1, 0.5, 0], atol=1e-6)

    def test_a_ball_sends_as_much_as_its_point(self):
        name, values = numbers(taken(lamp("POINT", shadow_soft_size=0.5)))
        self.assertEqual(name, "--sphere")
        self.assertAlmostEqual(values[4] * math.pi * 0.5**2, 1.0, places=5)

    def test_a_sun_brings_its_irradiance_however_wide_it_is(self):
        name, values = numbers(taken(lamp("SUN", energy=3.0)))
        self.assertEqual(name, "--sun")
        np.testing.assert_allclose(values, [0, 1, 0, 3, 1.5, 0], atol=1e-6)
        name, values = numbers(taken(lamp("SUN", energy=3.0, angle=0.4)))
        self.assertEqual(name, "--sphere")
        sine = values[3] / np.linalg.norm(values[:3])
        self.assertAlmostEqual(math.asin(sine), 0.2, places=5)
        # E = pi L sin^2 of half the angle.
        self.assertAlmostEqual(math.pi * values[4] * sine**2, 3.0, places=4)

    def test_an_area_lamp_shines_down_with_all_of_its_power(self):
        for mirrored in (1.0, -1.0):
            name, values = numbers(taken(lamp("AREA"), np.diag([mirrored * 3.0, 1.0, 1.0, 1.0])))
            corner, u, v, radiance = values[:3], values[3:6], values[6:9], values[9:]
            self.assertEqual(name, "--rect")
            np.testing.assert_allclose(corner + (u + v) / 2.0, 0.0, atol=1e-6)
            np.testing.assert_allclose(np.cross(u, v), [0, -6.0, 0], atol=1e-5)
            self.assertAlmostEqual(radiance[0] * math.pi * 6.0, 4.0 * math.pi, places=4)

    def test_a_disc_and_a_spread_are_told(self):
        found = taken(lamp("AREA", shape="DISK", spread=1.0))
        _, values = numbers(found)
        self.assertAlmostEqual(np.linalg.norm(np.cross(values[3:6], values[6:9])), math.pi, places=5)
        self.assertEqual(list(found.approximated), ["baked as a rectangle of the same area", "baked without spread"])

    def test_as_much_light_passes_the_border_of_a_spot(self):
        found = taken(lamp("SPOT", spot_size=1.2, spot_blend=0.5))
        ((_, matrix, light),) = found.spots
        self.assertEqual(found.flags, [])
        np.testing.assert_allclose(matrix @ [0, 0, -1, 0], [0, -1, 0, 0], atol=1e-12)
        self.assertAlmostEqual(light["intensity"], 1.0)
        inner, outer = (math.cos(light["spot"][f"{which}ConeAngle"]) for which in ("inner", "outer"))
        cosines = np.linspace(outer, 1.0, 100001)
        gltf = np.clip((cosines - outer) / (inner - outer), 0, 1) ** 2
        step = np.clip((cosines - outer) / (0.5 * (1 - outer)), 0, 1)
        cycles = step**2 * (3 - 2 * step)
        self.assertAlmostEqual(gltf.mean(), cycles.mean(), places=4)

    def test_temperature_exposure_and_black(self):
        _, values = numbers(taken(lamp("POINT", use_temperature=True, temperature_color=(1.5, 1.0, 0.2), exposure=1.0)))
        np.testing.assert_allclose(values[3:], [3.0, 1.0, 0.0], atol=1e-6)
        self.assertEqual(taken(lamp("POINT", energy=0.0)).flags, [])

    def test_spots_stand_in_the_scene_of_the_file(self):
        scene = glb.Glb({"scenes": [{"nodes": [0]}], "nodes": [{"name": "floor"}]}, b"")
        lamps.add_spots(scene, taken(lamp("SPOT")).spots)
        document = scene.json
        self.assertEqual(document["scenes"][0]["nodes"], [0, 1])
        self.assertEqual(document["extensionsUsed"], ["KHR_lights_punctual"])
        self.assertEqual(document["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"], 0)
        cone = document["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]
        self.assertLess(cone["innerConeAngle"], cone["outerConeAngle"])


if __name__ == "__main__":
    unittest.main()
