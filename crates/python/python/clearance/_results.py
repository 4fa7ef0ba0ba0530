"""Results of queries: immutable records of numbers, names and arrays."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, List, Optional, Tuple, Union

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ._clearance import Certificate

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]

Pair = Tuple[str, str]


class InputWarning(UserWarning):
    """Unusual input that was accepted; the text says what is taken how."""


class Verdict(enum.IntEnum):
    """Result of the check of a motion."""

    FREE = 1
    """Proven: no pair touches anywhere on the motion."""
    CONTACT = 0
    """A pair touches."""
    UNDECIDED = -1
    """Neither a proof nor a contact was found: do not take it for free."""

    def __bool__(self) -> bool:
        """True only for FREE."""
        return self is Verdict.FREE


class Reason(enum.IntEnum):
    """Why a motion could not be decided."""

    NONE = 0
    """It was decided."""
    TOLERANCE = 1
    """A pair comes nearer than the tolerance, and no contact was found."""
    TUBE = 2
    """A pair may touch within the tracking tolerance."""
    DEADLINE = 3
    """The time was over."""
    CANCELED = 4
    """The check was stopped."""
    BUDGET = 5
    """The budget of evaluations was used up."""
    OVERFLOW = 6
    """The pair is two planes, of which nothing is proven, or numbers are too large."""
    MISMATCH = 7
    """The motion has segments that do not join."""
    UNCHECKED = 8
    """The time was over before the check of this edge of a batch began."""


@dataclass(frozen=True, eq=False)
class PairDistance:
    """Distance of two bodies."""

    pair: Pair
    """Names of the bodies; the first is a link or an attached object."""
    distance: float
    """Distance (m), padding subtracted; 0 for bodies that touch."""
    points: Floats
    """Nearest points of the bodies (m, root frame), without padding; shape (2, 3)."""


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact of two bodies, paddings included."""

    pair: Pair
    """Names of the bodies."""
    point: Floats
    """Point of the contact (m, root frame); shape (3,)."""
    normal: Optional[Floats]
    """Unit vector (root frame) along which the second body leaves the first; shape (3,). None if no such direction was found."""
    depth: Optional[float]
    """Length (m) of the translation along the normal after which the bodies are proven apart; None if none was found. For a cloud or voxels,
    it is the point or voxel that is apart then, not yet the whole obstacle."""
    depth_lower: float
    """Lower bound (m) on the penetration depth."""
    reason: Optional[str]
    """Why the depth may be much larger than its lower bound: ``open_mesh``, ``inseparable`` or ``both_are_sets``; else None."""
    is_deepest: bool
    """True for the contact of the whole bodies; others are further places where they touch, with the local depth."""


@dataclass(frozen=True, eq=False)
class CollisionReport:
    """Report on one state."""

    free: bool
    """True only if every pair is proven apart."""
    self_collision: bool
    """True if two bodies of the robot collide."""
    world_collision: bool
    """True if the robot collides with an obstacle."""
    pairs: List[Pair]
    """All colliding pairs."""
    contacts: List[Contact]
    """Contacts of the colliding pairs."""
    nearest: Optional[PairDistance]
    """The nearest pair; None beyond ``max_distance``."""
    nearest_self: Optional[PairDistance]
    """The nearest pair of two bodies of the robot."""
    nearest_world: Optional[PairDistance]
    """The nearest pair of the robot and an obstacle."""
    distances: List[PairDistance]
    """All pairs within ``max_distance``."""

    def __bool__(self) -> bool:
        """The same as ``free``."""
        return self.free


@dataclass(frozen=True, eq=False)
class Distances:
    """Least distances of states of shape (..., n): within the robot, and between robot and world.

    For one state, distances are floats and pairs are tuples, or None beyond ``max_distance``. For others, distances are arrays of shape
    (...), and pairs arrays of names of shape (..., 2), with empty names beyond ``max_distance``.
    """

    self_distance: Union[float, Floats]
    """Least distance (m) of two bodies of the robot; infinite beyond ``max_distance``."""
    self_pair: Union[Pair, None, NDArray[np.str_]]
    """Names of the two bodies."""
    self_points: Floats
    """Nearest points (m, root frame), without padding; shape (..., 2, 3). NaN beyond ``max_distance``."""
    self_gradient: Optional[Floats]
    """Derivative of the distance with respect to q (m/rad, m/m), shape (..., n); zeros where it is not known. None unless asked for."""
    world_distance: Union[float, Floats]
    """Least distance (m) of the robot and an obstacle."""
    world_pair: Union[Pair, None, NDArray[np.str_]]
    """Names of link or attached object, and obstacle."""
    world_points: Floats
    """Nearest points."""
    world_gradient: Optional[Floats]
    """Derivative of the distance."""


@dataclass(frozen=True, eq=False)
class Clearance:
    """Signed distances of all m near pairs in one state, and their derivatives."""

    pairs: List[Pair]
    """Names of the bodies; m pairs."""
    distances: Floats
    """Signed distances (m), padding subtracted; shape (m,). For bodies that overlap, minus the penetration depth, or its bound ``lower``; for
    a cloud or voxels, that of the deepest point or voxel."""
    lower: Floats
    """Lower bounds (m); minus infinity if no translation is known that separates the bodies."""
    upper: Floats
    """Upper bounds (m)."""
    points: Floats
    """Nearest points (m, root frame), without padding; shape (m, 2, 3)."""
    normals: Floats
    """Unit vectors (root frame) along which the second body leaves the first; shape (m, 3). NaN if none is known."""
    gradients: Floats
    """Derivatives of the signed distances with respect to q (m/rad, m/m); shape (m, n). Zeros if no normal is known."""
    unique: NDArray[np.bool_]
    """True where the nearest points are unique, so that the distance has a derivative; shape (m,)."""


@dataclass(frozen=True, eq=False)
class EdgeReports:
    """Verdicts of motions of shape (...)."""

    verdicts: NDArray[np.int8]
    """`Verdict` of each motion; shape (...). Compare with ``Verdict.FREE``: in NumPy, UNDECIDED (-1) counts as true."""
    reasons: NDArray[np.int8]
    """`Reason` of each undecided motion, else 0; shape (...)."""
    t: Floats
    """Shape (..., 2): the motion is proven free before the first fraction. At the second, it collides, or after it, nothing is open. NaN
    for free motions."""


@dataclass(frozen=True, eq=False)
class MotionReport:
    """Report on a motion, t from 0 to 1."""

    verdict: Verdict
    """FREE is a proof; CONTACT; or UNDECIDED with its reason."""
    t: Optional[Tuple[float, float]]
    """The motion is proven free before the first. CONTACT: it collides at the second. UNDECIDED: it is free after the second."""
    pair: Optional[Pair]
    """The pair that touches or is undecided."""
    reason: Optional[Reason]
    """Why it is undecided."""
    distance: Optional[Tuple[float, float]]
    """Bounds (m) on the distance of the undecided pair."""
    point: Optional[Floats]
    """A common point (m, root frame) of the bodies that touch, if one is known; shape (3,)."""
    evaluations: int
    """Number of evaluations of a pair in an interval."""
    certificate: Optional[Certificate]
    """The proof of a free motion, if it was asked for."""

    @property
    def free(self) -> bool:
        """True only if the motion is proven free."""
        return self.verdict == Verdict.FREE

    def __bool__(self) -> bool:
        """The same as ``free``."""
        return self.free


@dataclass(frozen=True, eq=False)
class TrajectoryReport(MotionReport):
    """Report on a trajectory: on its first segment that is not free, if there is one.

    ``verdict`` FREE and ``certificate`` are about the whole trajectory; ``t`` has fractions of the segment.
    """

    segment: int
    """Index of the segment between two points that the verdict is about; the last one if all are free."""
    time: Optional[Tuple[float, float]]
    """Times (s from the start) of ``t``; None if it is free or there are no times."""


@dataclass(frozen=True, eq=False)
class LeastClearance:
    """Proven bounds (m, padding subtracted) on the least distance of self pairs or of world pairs along a motion."""

    lower: float
    """Proven: no pair is nearer at any time; 0 if some pair touches, or if nothing is proven."""
    upper: float
    """Distance of ``pair`` at ``t``: the least distance is not larger. Infinite if nothing was measured."""
    pair: Optional[Pair]
    """The pair at which ``upper`` is attained."""
    t: Optional[float]
    """Fraction of the motion, or of the segment, at which ``upper`` is attained."""
    segment: Optional[int]
    """Index of the segment of a trajectory; 0 for a motion."""
    time: Optional[float]
    """Time (s) from the start of the trajectory, if it has times."""
    points: Optional[Floats]
    """Nearest points of the pair (m, root frame), without padding; shape (2, 3)."""


@dataclass(frozen=True, eq=False)
class MotionClearance:
    """The least distances along a motion or trajectory."""

    nearest_self: Optional[LeastClearance]
    """The least distance of two bodies of the robot; None if no such pairs are checked."""
    nearest_world: Optional[LeastClearance]
    """The least distance of the robot and an obstacle; None if no such pairs are checked."""
    reason: Optional[Reason]
    """Why the bounds differ by more than the tolerance; None if they do not, or if ``max_distance`` ended the search."""
    evaluations: int
    """Number of evaluations of a pair in an interval."""

    @property
    def lower(self) -> float:
        """Proven: no pair is nearer than this (m) at any time; infinite if no pairs are checked, 0 if nothing is proven."""
        if self.reason == Reason.MISMATCH:
            return 0.0
        return min((least.lower for least in (self.nearest_self, self.nearest_world) if least), default=float("inf"))

    @property
    def upper(self) -> float:
        """Upper bound (m) on the least distance of all pairs; infinite if nothing was measured."""
        return min((least.upper for least in (self.nearest_self, self.nearest_world) if least), default=float("inf"))

    @property
    def free(self) -> bool:
        """True only if the motion is proven free."""
        return self.lower > 0

    def __bool__(self) -> bool:
        """The same as ``free``."""
        return self.free


@dataclass(frozen=True, eq=False)
class FreeState:
    """Result of the search of a free state near a given one."""

    found: bool
    """True if there is a state."""
    state: Optional[Floats]
    """The free state, shape (n,); the given one if that is free."""
    distance: Optional[float]
    """Euclidean norm of all changes (rad, m)."""
    exit: Optional[float]
    """Fraction of the straight motion to the state at its first exit from collision; it is proven free from there on."""
    reason: str
    """``already_free``, ``found``, ``not_movable``, ``unfinished`` or ``beyond_limits``."""
    pair: Optional[Pair]
    """The pair that no joint moves apart by the clearance, for ``not_movable``."""
    checks: int
    """Number of states that were checked."""

    def __bool__(self) -> bool:
        """The same as ``found``."""
        return self.found


@dataclass(frozen=True, eq=False)
class LinkPair:
    """Decision whether two links can collide within the joint limits."""

    links: Pair
    """Names of the links."""
    decision: str
    """``never`` or ``always``, both proven; ``sometimes``; ``undecided``."""
    colliding: Optional[Floats]
    """A state in which the links collide, shape (n,), for ``sometimes``."""
    free: Optional[Floats]
    """A state in which they do not, for ``sometimes``."""
    nearest: Optional[Floats]
    """State of ``least_distance``, for ``undecided``."""
    least_distance: Optional[float]
    """Smallest distance (m, paddings subtracted) found, for ``never`` and ``undecided``, where one was measured."""
    contact_share: float
    """Share of the random states in which the links collide."""
    depth: Optional[float]
    """Penetration depth (m) in one colliding state, where it was computed."""
    adjacent: bool
    """True if the links are joined by one joint, or are fixed to each other."""


@dataclass(frozen=True, eq=False)
class LinkSpheres:
    """Spheres of a link. All bounds are proven: (lower, upper)."""

    link: str
    """Name of the link."""
    spheres: Floats
    """Centres in the link frame and radii (m); shape (N, 4)."""
    excesses: Floats
    """By sphere: bound on the distance (m) of its points from the link; shape (N,)."""
    excess: Tuple[float, float]
    """Largest distance (m) of a point of the spheres from the link; zero for spheres inside."""
    uncovered_depth: Tuple[float, float]
    """Largest depth (m) of a point inside the link that is in no sphere; zero for spheres that contain the link."""
    ended_by_time: bool
    """True if the time ended the search."""


@dataclass(frozen=True, eq=False)
class LinkShapes:
    """Capsules or boxes of a link. All bounds are proven: (lower, upper)."""

    link: str
    """Name of the link."""
    poses: Floats
    """Pose of each shape in the link frame; shape (N, 4, 4)."""
    sizes: Floats
    """By capsule: radius and length of its segment along z (m), shape (N, 2); by box: its edges (m), shape (N, 3)."""
    excesses: Floats
    """By shape: bound on the distance (m) of its points from the link; shape (N,)."""
    excess: Tuple[float, float]
    """Largest distance (m) of a point of the shapes from the link."""
    ended_by_time: bool
    """True if the time ended the search."""


@dataclass(frozen=True, eq=False)
class SimplifiedMesh:
    """A simplified collision mesh."""

    collision: int
    """Number of the collision element in its link, from 0."""
    pose: Floats
    """Pose of the mesh in the link frame; shape (4, 4)."""
    vertices: Floats
    """Vertices (m) in the frame of the mesh, the scale of the URDF applied; shape (V, 3)."""
    faces: Ints
    """Numbers of the vertices of each triangle, from 0; shape (T, 3)."""
    original_triangles: int
    """Number of triangles of the original mesh."""
    error: Tuple[float, float]
    """Proven bounds (lower, upper) on the Hausdorff distance (m) of the simplified and the original surface."""
    file_name: str
    """Name of its STL file."""


@dataclass(frozen=True, eq=False)
class LinkMeshes:
    """The simplified collision meshes of a link."""

    link: str
    """Name of the link."""
    meshes: Tuple[SimplifiedMesh, ...]
    """One for each mesh of its collision geometry."""
    error: Tuple[float, float]
    """Proven bounds (lower, upper) on the largest error (m) of the meshes."""
    point: Floats
    """A point (m, link frame) with the largest error that was found; shape (3,)."""
    ended_by_time: bool
    """True if the time ended the search."""


@dataclass(frozen=True, eq=False)
class MeasuredSpheres:
    """Measurement of the spheres of a link. All bounds are proven: (lower, upper)."""

    link: str
    """Name of the link."""
    count: int
    """Number of spheres."""
    excess: Tuple[float, float]
    """Largest distance (m) of a point of the spheres from the link."""
    uncovered_area: Tuple[float, float]
    """Area (m²) of the link's surface that is in no sphere."""
    surface_area: float
    """Area (m²) of the link's surface; that of a mesh for curved primitives."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Result of the search of a path."""

    found: bool
    """True if there is a path."""
    path: Optional[Floats]
    """States from the start to the goal, shape (k, n); every straight edge between two in succession is proven free."""
    length: Optional[float]
    """Sum of the Euclidean norms of the changes along all edges (rad, m)."""
    reason: str
    """``found``, ``start_not_free``, ``goal_not_free``, ``most_edges`` or ``deadline``. ``found_without_certificate``: the time was over
    before the requested certificate was made."""
    edges: int
    """Number of edges that were checked."""
    nodes: Optional[int]
    """Number of nodes of both trees."""
    certificate: Optional[Certificate]
    """Certificate of the whole path, if it was requested."""

    def __bool__(self) -> bool:
        """The same as ``found``."""
        return self.found


@dataclass(frozen=True)
class Verification:
    """Result of the verification of a certificate; true only if the proof holds."""

    valid: bool
    """True only if the certificate proves its motion free, and this is the expected motion."""
    reason: Optional[str]
    """Why not."""
    segments: int
    """Segments of the motion."""
    pairs: int
    """Pairs of bodies, each proven apart throughout every segment."""
    proofs: int
    """Proofs of a pair in an interval."""

    def __bool__(self) -> bool:
        return self.valid
