import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypedDict, Union

import numpy as np
import numpy.typing as npt
from typing_extensions import Unpack

_Path = Union[str, "os.PathLike[str]"]
_Rgb = Sequence[float]
_Plane = npt.NDArray[np.float32]

__version__: str
LAYERS: dict[str, list[str]]
OPTIONS: tuple[str, ...]

class Options(TypedDict, total=False):
    size: int
    density: Union[float, Literal["even"]]
    density_of: Mapping[str, float]
    up: Literal["y", "z"]
    include: Union[str, Sequence[str]]
    exclude: Union[str, Sequence[str]]
    no_cast: Union[str, Sequence[str]]
    seen_from: Union[Sequence[_Rgb], Literal["auto"]]
    pages: Union[int, Literal["auto"]]
    one_page_per_mesh: bool
    rays: int
    target_error: float
    target_relative: float
    max_rays: int
    footprint: Literal["texel", "centre"]
    denoise: Literal["off", "regression", "oidn"]
    seams: Literal["off", "object", "scene"]
    sky: Union[_Rgb, _Path, npt.NDArray[Any]]
    view: Union[Literal["normal"], Sequence[float]]
    shading: Literal["production", "exact"]
    buried: Literal["drop", "keep"]
    buried_of: Mapping[str, Literal["drop", "keep"]]
    under: float
    max_distance: float
    model: Literal["phong", "ggx"]
    bounces: Union[int, Literal["auto"]]
    lights: Literal["file", "none"]
    sun: Sequence[Sequence[float]]
    point: Sequence[Sequence[float]]
    sphere: Sequence[Sequence[float]]
    rect: Sequence[Sequence[float]]
    max_memory: Union[int, str]
    backend: Literal["embree", "obvhs", "obvhs-bvh2"]
    uv: Literal["auto", "keep", "unwrap"]
    gutter: int
    mips: int
    align: int
    layers: Union[str, Sequence[str]]
    only: Union[str, Sequence[str]]
    to: Literal["pages", "vertices"]
    normal_maps: bool
    exponent: float
    ambient_coefficient: Union[_Rgb, Literal["albedo", "file"]]
    albedo: _Rgb
    specular: _Rgb
    plan_off: Union[str, Sequence[str]]
    for_: Union[str, Sequence[str]]
    compress: bool
    update: _Path
    verify: bool
    threads: int
    seed: int

class PageStats(TypedDict):
    texels: int
    rays: int
    rmse: float

class Object:
    name: str
    faces: npt.NDArray[np.int64]
    pages: npt.NDArray[np.int64]
    uvs: npt.NDArray[np.float32]
    corners: npt.NDArray[np.float64]
    mirrored: bool

class Baked(dict[str, Union[_Plane, list[_Plane]]]):
    size: int
    page_count: int
    stats: list[PageStats]
    warnings: list[str]
    objects: list[Object]
    @property
    def uvs(self) -> npt.NDArray[np.float32]: ...
    @property
    def pages(self) -> npt.NDArray[np.int64]: ...
    # A trimesh.Trimesh or trimesh.Scene.
    def to_trimesh(self, layer: str = "lambert") -> Any: ...
    def write(self, folder: _Path) -> list[os.PathLike[str]]: ...
    def write_gltf(self, path: _Path) -> None: ...

_Progress = Callable[[int, int], Any]

def bake(
    vertices: Any,
    faces: npt.ArrayLike | None = None,
    *,
    uvs: npt.ArrayLike | None = None,
    normals: npt.ArrayLike | None = None,
    name: str = "mesh",
    output: _Path | None = None,
    progress: _Progress | None = None,
    **options: Unpack[Options],
) -> Baked: ...
def bake_file(
    source: Union[_Path, bytes, bytearray, memoryview],
    *,
    output: _Path | None = None,
    progress: _Progress | None = None,
    **options: Unpack[Options],
) -> Baked: ...

class Grid(TypedDict):
    low: tuple[float, float, float]
    cell: tuple[float, float, float]
    counts: tuple[int, int, int]

class Probes:
    grid: Union[Grid, None]
    positions: npt.NDArray[np.float64]
    sh: npt.NDArray[np.float32]
    std_err: npt.NDArray[np.float32]
    validity: npt.NDArray[np.float32]
    invalid: npt.NDArray[np.bool_]
    def write(self, folder: _Path, engines: Union[str, Sequence[str]] = ()) -> list[os.PathLike[str]]: ...

class ProbeOptions(TypedDict, total=False):
    spacing: float
    grid: Sequence[int]
    at: Union[Sequence[_Rgb], npt.NDArray[np.float64]]
    within: Sequence[_Rgb]
    bake: _Path
    order: int
    rays: int
    target_error: float
    max_rays: int
    refine: float
    sky: Union[_Rgb, _Path, npt.NDArray[Any]]
    bounces: Union[int, Literal["auto"]]
    lights: Literal["file", "none"]
    max_distance: float
    sun: Sequence[Sequence[float]]
    point: Sequence[Sequence[float]]
    sphere: Sequence[Sequence[float]]
    rect: Sequence[Sequence[float]]
    window: bool
    tried: int
    backend: Literal["embree", "obvhs", "obvhs-bvh2"]
    threads: int
    seed: int

def probes(source: _Path, *, progress: _Progress | None = None, **options: Unpack[ProbeOptions]) -> Probes: ...
