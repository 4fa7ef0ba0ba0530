"""Types of the native part of the package. `tests/python/test_stubs.py` compares them with the module."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict, Union, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Unpack

from ._results import (
    Clearance,
    CollisionReport,
    Distances,
    EdgeReports,
    FreeState,
    LinkPair,
    LinkMeshes,
    LinkShapes,
    LinkSpheres,
    MeasuredSpheres,
    MotionClearance,
    MotionReport,
    Plan,
    TrajectoryReport,
    Verification,
)

_Path = Union[str, os.PathLike[str]]
_Pose = Union[ArrayLike, tuple[ArrayLike, ArrayLike]]
_Pairs = Sequence[Union[tuple[str, str], list[str]]]
_Floats = NDArray[np.float64]

class _Settings(TypedDict, total=False):
    padding: float
    link_padding: Mapping[str, float]
    link_scale: Mapping[str, float]
    object_padding: Mapping[str, float]
    object_scale: Mapping[str, float]
    pad_self: bool
    check_self: bool
    check_world: bool
    mesh_model: Literal["surface", "solid"]
    volumes: str
    allowed_collisions: _Pairs
    checked_collisions: _Pairs

class _MatrixSettings(TypedDict, total=False):
    padding: float
    link_padding: Mapping[str, float]
    link_scale: Mapping[str, float]
    pad_self: bool
    mesh_model: Literal["surface", "solid"]

class _MotionOptions(TypedDict, total=False):
    tolerance: float
    timeout: float | None
    budget: int
    any_contact: bool
    margin: float

class _ClearanceOptions(TypedDict, total=False):
    absolute_tolerance: float
    relative_tolerance: float
    max_distance: float
    timeout: float | None
    budget: int

__all__: list[str]
__version__: str

class Error(ValueError): ...

@final
class Robot:
    @staticmethod
    def from_urdf(
        urdf: _Path,
        srdf: _Path | None = None,
        package_paths: Sequence[_Path] = ...,
        *,
        xacro_args: dict[str, str] | None = None,
    ) -> Robot: ...
    @property
    def name(self) -> str: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def lower(self) -> _Floats: ...
    @property
    def upper(self) -> _Floats: ...
    @property
    def joint_types(self) -> dict[str, str]: ...
    @property
    def mimics(self) -> dict[str, tuple[str, float, float]]: ...
    @property
    def link_names(self) -> list[str]: ...
    @property
    def root_link(self) -> str: ...
    @property
    def groups(self) -> dict[str, list[str]]: ...
    @property
    def group_states(self) -> dict[str, dict[str, float]]: ...
    @property
    def warnings(self) -> list[str]: ...
    def configuration(self, positions: Mapping[str, float] = ...) -> _Floats: ...
    def random(self, rng: np.random.Generator | int | None = None, size: int | None = None) -> _Floats: ...
    def forward_kinematics(self, q: ArrayLike, links: Sequence[str] | None = None) -> dict[str, _Floats]: ...
    def collision_matrix(
        self,
        *,
        timeout: float | None = None,
        max_boxes: int | None = None,
        num_threads: int | None = None,
        **settings: Unpack[_MatrixSettings],
    ) -> CollisionMatrix: ...
    def sphere_cover(
        self,
        *,
        count: int | None = None,
        total: int | None = None,
        excess: float | None = None,
        counts: Mapping[str, int] | None = None,
        inner: bool = False,
        timeout: float | None = None,
        num_threads: int | None = None,
    ) -> SphereCover: ...
    def shape_cover(
        self, shape: str, *, count: int, timeout: float | None = None, num_threads: int | None = None
    ) -> ShapeCover: ...
    def mesh_cover(
        self,
        *,
        count: int | None = None,
        excess: float | None = None,
        timeout: float | None = None,
        num_threads: int | None = None,
    ) -> MeshCover: ...
    def measure_spheres(
        self, spheres: Robot, *, timeout: float | None = None, num_threads: int | None = None
    ) -> tuple[MeasuredSpheres, ...]: ...

@final
class CollisionMatrix:
    @property
    def pairs(self) -> tuple[LinkPair, ...]: ...
    @property
    def joint_names(self) -> list[str]: ...
    def srdf(self, allow: _Pairs = ..., allow_adjacent: bool = False) -> str: ...
    def certificate(self) -> str: ...

@final
class SphereCover:
    @property
    def links(self) -> tuple[LinkSpheres, ...]: ...
    @property
    def spheres(self) -> dict[str, _Floats]: ...
    @property
    def inner(self) -> bool: ...
    @property
    def largest_error(self) -> float: ...
    @property
    def ended_by_time(self) -> bool: ...
    def to_urdf(self) -> str: ...
    def to_curobo(self) -> str: ...
    def to_xrdf(self) -> str: ...
    def __len__(self) -> int: ...

@final
class ShapeCover:
    @property
    def links(self) -> tuple[LinkShapes, ...]: ...
    @property
    def shape(self) -> str: ...
    @property
    def largest_excess(self) -> float: ...
    @property
    def ended_by_time(self) -> bool: ...
    def to_urdf(self) -> str: ...
    def __len__(self) -> int: ...

@final
class MeshCover:
    @property
    def links(self) -> tuple[LinkMeshes, ...]: ...
    @property
    def triangles(self) -> int: ...
    @property
    def original_triangles(self) -> int: ...
    @property
    def largest_error(self) -> float: ...
    @property
    def ended_by_time(self) -> bool: ...
    @property
    def files(self) -> dict[str, bytes]: ...
    def to_urdf(self, folder: str) -> str: ...
    def __len__(self) -> int: ...

@final
class World:
    def __new__(cls) -> World: ...
    @staticmethod
    def from_file(
        path: _Path,
        robot: Robot | None = None,
        *,
        point_radius: float | None = None,
        unknown_is_occupied: bool = False,
    ) -> World: ...
    def add_box(self, name: str, size: ArrayLike, pose: _Pose | None = None) -> None: ...
    def add_sphere(self, name: str, radius: float, pose: _Pose | None = None) -> None: ...
    def add_cylinder(self, name: str, radius: float, length: float, pose: _Pose | None = None) -> None: ...
    def add_capsule(self, name: str, radius: float, length: float, pose: _Pose | None = None) -> None: ...
    def add_cone(self, name: str, radius: float, length: float, pose: _Pose | None = None) -> None: ...
    def add_plane(self, name: str, normal: ArrayLike, offset: float = 0.0, pose: _Pose | None = None) -> None: ...
    def add_mesh(self, name: str, vertices: ArrayLike, faces: ArrayLike, pose: _Pose | None = None) -> None: ...
    def add_mesh_file(
        self, name: str, path: _Path, pose: _Pose | None = None, scale: ArrayLike | None = None
    ) -> None: ...
    def add_points(self, name: str, xyz: ArrayLike, radius: float, pose: _Pose | None = None) -> None: ...
    def add_voxels(self, name: str, centres: ArrayLike, edge: float, pose: _Pose | None = None) -> None: ...
    def remove(self, name: str) -> None: ...
    def move(self, name: str, pose: _Pose) -> None: ...
    def pose(self, name: str) -> _Floats: ...
    def copy(self) -> World: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def attached(self) -> dict[str, str]: ...
    def __len__(self) -> int: ...
    def __contains__(self, name: str, /) -> bool: ...
    def __copy__(self) -> World: ...
    def __deepcopy__(self, _memo: Any) -> World: ...

@final
class Checker:
    def __new__(
        cls,
        robot: Robot,
        world: World | None = None,
        *,
        group: str | None = None,
        fixed: Mapping[str, float] | None = None,
        **settings: Unpack[_Settings],
    ) -> Checker: ...
    @property
    def robot(self) -> Robot: ...
    @property
    def world(self) -> World: ...
    @property
    def settings(self) -> dict[str, Any]: ...
    @property
    def group(self) -> str | None: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def lower(self) -> _Floats: ...
    @property
    def upper(self) -> _Floats: ...
    @property
    def pairs(self) -> list[tuple[str, str]]: ...
    def configuration(self, positions: Mapping[str, float] = ...) -> _Floats: ...
    def expand(self, q: ArrayLike) -> _Floats: ...
    def with_world(self, world: World) -> Checker: ...
    def attach(
        self,
        name: str,
        link: str,
        *,
        q: ArrayLike | None = None,
        pose: _Pose | None = None,
        touch_links: Sequence[str] = ...,
    ) -> Checker: ...
    def detach(self, name: str, q: ArrayLike) -> Checker: ...
    def is_free(self, q: ArrayLike, *, num_threads: int | None = None) -> bool | NDArray[np.bool_]: ...
    def distance(
        self,
        q: ArrayLike,
        max_distance: float = 0.1,
        *,
        gradients: bool = False,
        num_threads: int | None = None,
    ) -> Distances: ...
    def check(
        self,
        q: ArrayLike,
        max_distance: float = 0.1,
        *,
        max_contacts: int = 1,
        num_threads: int | None = None,
    ) -> CollisionReport | list[Any]: ...
    def clearance(
        self, q: ArrayLike, influence_distance: float, *, num_threads: int | None = None
    ) -> Clearance | list[Any]: ...
    def are_edges_free(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        *,
        num_threads: int | None = None,
        **options: Unpack[_MotionOptions],
    ) -> bool | NDArray[np.bool_]: ...
    def check_edges(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        *,
        num_threads: int | None = None,
        **options: Unpack[_MotionOptions],
    ) -> EdgeReports: ...
    def check_motion(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        *,
        certificate: bool = False,
        tube: ArrayLike | None = None,
        **options: Unpack[_MotionOptions],
    ) -> MotionReport: ...
    def check_trajectory(
        self,
        times: ArrayLike | None,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        *,
        shortest: bool = False,
        certificate: bool = False,
        tube: ArrayLike | None = None,
        deviation: ArrayLike | None = None,
        **options: Unpack[_MotionOptions],
    ) -> TrajectoryReport: ...
    def clearance_along(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        *,
        tube: ArrayLike | None = None,
        **options: Unpack[_ClearanceOptions],
    ) -> MotionClearance: ...
    def clearance_along_trajectory(
        self,
        times: ArrayLike | None,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        *,
        shortest: bool = False,
        tube: ArrayLike | None = None,
        deviation: ArrayLike | None = None,
        **options: Unpack[_ClearanceOptions],
    ) -> MotionClearance: ...
    def event_distance(
        self,
        q0: ArrayLike,
        q1: ArrayLike,
        distance: float,
        *,
        tube: ArrayLike | None = None,
        **options: Unpack[_MotionOptions],
    ) -> MotionReport: ...
    def find_free_state(
        self,
        q: ArrayLike,
        *,
        max_distance: float = 0.5,
        clearance: float = 0.0001,
        max_checks: int = 30000,
        timeout: float | None = None,
        locked: Sequence[str] = ...,
    ) -> FreeState: ...
    def plan(
        self,
        start: ArrayLike,
        goal: ArrayLike,
        *,
        seed: int = 1,
        timeout: float | None = None,
        max_edges: int = 200000,
        range: float = 1.0,
        shortcuts: int = 64,
        certificate: bool = False,
    ) -> Plan: ...

    def view(self, q: ArrayLike | None = None, port: int = 0, open_browser: bool = False) -> View: ...

@final
class View:
    @property
    def url(self) -> str: ...
    @property
    def state(self) -> _Floats: ...
    def set_state(self, q: ArrayLike) -> None: ...
    def close(self) -> None: ...
    def __enter__(self) -> View: ...
    def __exit__(self, *_exception: object) -> None: ...
    def _repr_html_(self) -> str: ...

@final
class Certificate:
    def __new__(cls, json: str) -> Certificate: ...
    @staticmethod
    def load(path: _Path) -> Certificate: ...
    def save(self, path: _Path) -> None: ...
    def to_json(self) -> str: ...
    @property
    def robot(self) -> str: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def pairs(self) -> list[tuple[str, str]]: ...
    @property
    def segments(self) -> int: ...
    @property
    def margin(self) -> float: ...
    @property
    def tolerance(self) -> float | None: ...
    def __eq__(self, other: object, /) -> bool: ...

def verify(
    certificate: Certificate,
    robot: Robot,
    world: World | None = None,
    *,
    edge: tuple[ArrayLike, ArrayLike] | None = None,
    trajectory: tuple[Any, ...] | None = None,
    shortest: bool = False,
    tube: ArrayLike | None = None,
    tolerance: float | None = None,
    margin: float | None = None,
    **settings: Unpack[_Settings],
) -> Verification: ...
def _run_command(command_line: Sequence[str]) -> int: ...
def _restore_robot(*state: Any) -> Robot: ...
def _restore_world(*state: Any) -> World: ...
def _restore_checker(*state: Any) -> Checker: ...
