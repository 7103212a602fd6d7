"""The ambake program: where it is, its arguments, its progress and its end. Knows nothing of Blender."""

import json
import os
import re
import shlex
import shutil
import subprocess
import tempfile
import threading
from dataclasses import dataclass

from .corners import OCCLUDER

# What can be shown in the viewport. Those that every bake writes need no flag; the model of highlights is that of the
# layer that is named.
STANDARD = ("visibility", "diffuse", "specular", "traditional", "lambert")

# The program that the zip carried, where it did.
INSIDE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", "ambake")

# Kinds of warnings that say what a bake left out of materials.
UNTAKEN = {"ignored-extensions", "ignored-normal-maps", "unread-textures"}

HOW_TO_GET = (
    "the program ambake was not found; install it (`cargo install --locked --path .` in ambake's folder) and put it on "
    "the PATH, or name it in Preferences, Add-ons, ambake"
)


def find(preferred):
    """The program's path: the preferred one, else the one inside of the extension, else the one on the PATH. A
    ValueError says how to get it."""
    preferred = os.path.expanduser(preferred.strip())
    if not preferred and os.path.exists(INSIDE):
        if not os.access(INSIDE, os.X_OK):
            # What unpacks a zip may forget that a file is a program.
            os.chmod(INSIDE, 0o755)
        return INSIDE
    found = shutil.which(preferred or "ambake")
    if found is None and preferred:
        raise ValueError(f"{preferred} is not a program; correct its path in Preferences, Add-ons, ambake")
    if found is None:
        raise ValueError(HOW_TO_GET)
    return found


def layers(settings):
    """The layers that come back as images, the shown one first."""
    names = [settings.show] + re.split(r"[\s,;]+", settings.layers)
    return list(dict.fromkeys(name for name in names if name))


def arguments(settings, scene, output, occluders, lit):
    """The arguments of `ambake bake`. `settings` has the attributes of the panel, named as the flags; `occluders` tells
    whether the scene has objects that take no texels, `lit` are the flags of the light, such as `sky` gives."""
    result = ["bake", scene, "-o", output, "--json"]
    if occluders:
        result += ["--exclude", OCCLUDER + "*"]

    def flag(name, value):
        result.extend([name, str(value)])

    flag("--size", settings.size)
    if settings.density > 0.0:
        flag("--density", _number(settings.density))
    if settings.effort == "TARGET":
        flag("--target-error", _number(settings.target_error))
        if settings.target_relative > 0.0:
            flag("--target-relative", _number(settings.target_relative))
        flag("--max-rays", settings.max_rays)
    else:
        flag("--rays", settings.rays)
    result += lit + shared(settings)
    flag("--uv", settings.uv)
    flag("--gutter", settings.gutter)
    flag("--mips", settings.mips)
    flag("--seams", settings.seams)
    flag("--denoise", settings.denoise)
    flag("--seed", settings.seed)
    if settings.normal_maps:
        result.append("--normal-maps")
    further = [name for name in layers(settings) if name not in STANDARD]
    if further:
        flag("--layers", ",".join(further))
    return result + shlex.split(settings.further)


def probe_arguments(settings, scene, output, lit, low, high, counts):
    """The arguments of `ambake probes` for a volume of so many probes between two corners in glTF's axes."""
    corners = ":".join(",".join(_number(v) for v in corner) for corner in (low, high))
    result = ["probes", scene, "-o", output, "--json", f"--within={corners}", "--grid", "x".join(map(str, counts))]
    engines = re.split(r"[\s,;]+", settings.probe_engines.strip(" ,;"))
    if any(engines):
        result += ["--for", ",".join(engines)]
    return result + lit + shared(settings) + ["--seed", str(settings.seed)]


def sky(settings):
    """The flags of the sky that the panel has in place of the light of the scene."""
    return ["--sky", settings.sky_file or ",".join(_number(v) for v in settings.sky)]


def shared(settings):
    """The flags that baking and gathering share: how far light goes, and how rays are cast."""
    result = ["--bounces", str(settings.bounces)] if settings.bounces else []
    if settings.max_distance > 0.0:
        result += ["--max-distance", _number(settings.max_distance)]
    if settings.backend != "auto":
        result += ["--backend", settings.backend]
    if settings.threads > 0:
        result += ["--threads", str(settings.threads)]
    return result


def _number(value):
    """Shortest decimal of a value that Blender keeps in 32 bits: 0.005, not 0.004999999888."""
    return f"{value:.7g}"


@dataclass
class Progress:
    """How far a bake is: `share` in 0..=1, and ambake's own words."""

    share: float = 0.0
    text: str = "loading and laying out"


def progress(line):
    """What a line of ambake's standard error says of its progress; None where it says something else."""
    found = re.match(r"(?:[^:]*: )?(\d+) of (\d+) \w+, (.*left)$", line.strip())
    if not found:
        return None
    done, total = int(found[1]), int(found[2])
    return Progress(done / total if total else 0.0, found[3])


class Run:
    """A running ambake. `poll` often; `progress` says how far it is."""

    def __init__(self, program, arguments):
        self.progress = Progress()
        self.cancelled = False
        self._words = []
        self._output = tempfile.TemporaryFile("w+", encoding="utf-8")
        hidden = getattr(subprocess, "CREATE_NO_WINDOW", 0)
        self._process = subprocess.Popen(
            [program, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=self._output,
            stderr=subprocess.PIPE,
            text=True,
            encoding="utf-8",
            errors="replace",
            creationflags=hidden,
        )
        self._reader = threading.Thread(target=self._listen, daemon=True)
        self._reader.start()

    def _listen(self):
        for line in self._process.stderr:
            seen = progress(line)
            if seen is None and line.strip():
                self._words.append(line.strip())
            elif seen is not None:
                self.progress = seen

    def running(self):
        """True until it has ended."""
        return self._process.poll() is None

    def wait(self):
        """Blocks until it has ended."""
        self._process.wait()

    def cancel(self):
        """Asks it to stop, and makes it stop where it does not within ten seconds."""
        self.cancelled = True
        if self.running():
            self._process.terminate()
            try:
                self._process.wait(10)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()

    def result(self):
        """`bake.json` of the ended bake. A ValueError holds ambake's own line where it failed."""
        self._reader.join()
        self._process.stderr.close()
        self._output.seek(0)
        text = self._output.read()
        self._output.close()
        status = self._process.returncode
        if status != 0:
            raise ValueError(complaint(self._words, status))
        return json.loads(text)


def untaken(report):
    """What of the materials ambake left out, from the warnings of `bake.json`."""
    found = [warning for warning in report["warnings"] if warning["kind"] in UNTAKEN]
    return [f"{w['place']}{' and others' * (w['count'] > 1)}: {w['message']}".replace("`", "") for w in found]


def complaint(lines, status):
    """Why ambake failed, from what it wrote to standard error: its line that begins with `error`, else the last."""
    errors = [line for line in lines if line.startswith(("error: ", "ambake: error: "))]
    words = errors[0] if errors else lines[-1] if lines else f"ambake ended with status {status}"
    return re.sub(r"^(ambake: )?(error: )?", "", words)
