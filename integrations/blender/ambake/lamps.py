"""Blender's lamps as flags of ambake and as spots of a glTF file, in the units of both. Reads lamps by their
attributes and needs no Blender.

A lamp of P watts is one that Cycles lets shine with P / 4π W/sr (point, spot) or P / (π · area) W/(m² sr) (area),
and a sun has its irradiance as it stands. ambake takes all of these as they are."""

import math
from dataclasses import dataclass, field

import numpy as np

# A sun with an angle is a ball at least so many metres away from the scene, so many of its sizes if that is more, and
# its radius is that of the angle.
SUN_AWAY = 1e5
SUN_SIZES = 1000.0
# The largest half angle of a sun: of a ball that touches the scene nothing is known.
WIDEST_SUN = math.radians(89.0)
# glTF's axes from Blender's: x, z, -y.
AXES = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@dataclass
class Lamps:
    """What a bake takes of the lamps: flags, spots as (name, 4 x 4 matrix, light of KHR_lights_punctual), and sentences
    about what it does not take."""

    centre: tuple = (0.0, 0.0, 0.0)  # of the scene, in glTF's axes
    size: float = 0.0
    flags: list = field(default_factory=list)
    spots: list = field(default_factory=list)
    approximated: dict = field(default_factory=dict)  # what is said -> names

    def say(self, words, name):
        self.approximated.setdefault(words, [])
        if name not in self.approximated[words]:
            self.approximated[words].append(name)

    def add(self, name, light, matrix):
        """Takes a lamp that stands at `matrix` (4 x 4, in Blender's axes)."""
        matrix = np.array(matrix, float)
        colour = self._colour(name, light, matrix)
        if not colour.any():
            return
        place, toward = AXES @ matrix[:3, 3], AXES @ _unit(matrix[:3, 2])
        if not getattr(light, "use_shadow", True):
            self.say("baked with shadows, which Cycles leaves out", name)
        if light.type == "SUN":
            self._sun(light, toward, colour)
        elif light.type == "AREA":
            self._area(name, light, matrix, place, colour)
        elif light.type == "SPOT":
            self._spot(name, light, matrix, place, colour / (4.0 * math.pi))
        else:
            self._point(light, place, colour / (4.0 * math.pi))

    def _colour(self, name, light, matrix):
        """Power, or irradiance of a sun, by colour."""
        colour = np.array(light.color[:3], float) * light.energy * 2.0 ** getattr(light, "exposure", 0.0)
        if getattr(light, "use_temperature", False):
            colour *= np.array(light.temperature_color[:3])
        if not getattr(light, "normalize", True):
            colour *= light.area(matrix_world=matrix.tolist())
        if getattr(light, "use_nodes", False) and light.node_tree:
            found = _emission(light.node_tree)
            if found is None:
                self.say("baked without nodes", name)
            else:
                colour *= found
        return colour.clip(min=0.0)

    def _sun(self, light, toward, colour):
        half = min(light.angle / 2.0, WIDEST_SUN)
        if half < 1e-6:
            self._flag("--sun", toward, colour)
            return
        away = max(SUN_AWAY, SUN_SIZES * self.size)
        radius = away * math.sin(half)
        place = np.array(self.centre) + toward * away
        self._flag("--sphere", place, [radius], colour / (math.pi * math.sin(half) ** 2))

    def _point(self, light, place, intensity):
        radius = light.shadow_soft_size
        if radius > 0.0:
            self._flag("--sphere", place, [radius], intensity / (math.pi * radius**2))
        else:
            self._flag("--point", place, intensity)

    def _area(self, name, light, matrix, place, power):
        x, y = matrix[:3, 0] * light.size, matrix[:3, 1] * light.size
        if light.shape in {"RECTANGLE", "ELLIPSE"}:
            y = matrix[:3, 1] * light.size_y
        if light.shape in {"DISK", "ELLIPSE"}:
            x, y = x * math.sqrt(math.pi) / 2.0, y * math.sqrt(math.pi) / 2.0
            self.say("baked as a rectangle of the same area", name)
        if light.spread < math.pi - 1e-3:
            self.say("baked without spread", name)
        # The side to which the first and then the second point is the one that shines: a lamp's -z.
        u, v = (y, x) if np.dot(np.cross(y, x), matrix[:3, 2]) < 0.0 else (x, y)
        area = np.linalg.norm(np.cross(u, v))
        if area > 0.0:
            u, v = AXES @ u, AXES @ v
            self._flag("--rect", place - (u + v) / 2.0, u, v, power / (math.pi * area))

    def _spot(self, name, light, matrix, place, intensity):
        if light.shadow_soft_size > 0.0:
            self.say("baked as a point without radius, with hard shadows", name)
        outer = math.cos(min(light.spot_size / 2.0, math.pi / 2.0))
        # Cycles' border is a smooth step, glTF's a square; with three quarters of its width as much light passes.
        inner = outer + 0.75 * light.spot_blend * (1.0 - outer)
        placed = np.eye(4)
        placed[:3, :3] = AXES @ np.stack([_unit(matrix[:3, k]) for k in range(3)], axis=1)
        placed[:3, 3] = place
        strongest = intensity.max()
        cone = {"innerConeAngle": math.acos(min(inner, 1.0)), "outerConeAngle": math.acos(outer)}
        # glTF wants the inner angle below the outer one, and a hard border is one of no width that shows.
        cone["innerConeAngle"] = min(cone["innerConeAngle"], cone["outerConeAngle"] - 1e-4)
        lamp = {"type": "spot", "name": name, "color": (intensity / strongest).tolist(), "intensity": strongest}
        self.spots.append((name, placed, {**lamp, "spot": cone}))

    def _flag(self, name, *numbers):
        self.flags.append(f"{name}=" + ",".join(f"{v:.7g}" for part in numbers for v in part))


def add_spots(glb, spots):
    """Adds the spots to a GLB file."""
    if not spots:
        return
    document = glb.json
    lights = document.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    used = document.setdefault("extensionsUsed", [])
    if "KHR_lights_punctual" not in used:
        used.append("KHR_lights_punctual")
    nodes = document.setdefault("nodes", [])
    scene = document["scenes"][document.get("scene", 0)].setdefault("nodes", [])
    for name, matrix, light in spots:
        scene.append(len(nodes))
        nodes.append(
            {
                "name": f"ambake-lamp: {name}",
                "matrix": matrix.T.reshape(-1).tolist(),
                "extensions": {"KHR_lights_punctual": {"light": len(lights)}},
            }
        )
        lights.append(light)


def _emission(tree):
    """By what a lamp's nodes multiply its power; None where they are more than an emission of one colour."""
    output = tree.get_output_node("CYCLES")
    if output is None or not output.inputs["Surface"].is_linked:
        return np.zeros(3)
    node = output.inputs["Surface"].links[0].from_node
    if node.type != "EMISSION" or node.inputs["Color"].is_linked or node.inputs["Strength"].is_linked:
        return None
    return np.array(node.inputs["Color"].default_value[:3]) * node.inputs["Strength"].default_value


def _unit(vector):
    length = np.linalg.norm(vector)
    return vector / length if length > 0.0 else vector
