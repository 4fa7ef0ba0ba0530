"""FCL's conservative advancement along an edge, pair by pair, also with bounding spheres tested first."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import fcl
import neutral
import numpy as np

# Between two poses, turning at even speed: FCL's only check that looks between samples.
ADVANCEMENT = fcl.ContinuousCollisionRequest(
    num_max_iterations=10,
    toc_err=1e-4,
    ccd_motion_type=fcl.CCDMotionType.CCDM_LINEAR,
    gjk_solver_type=fcl.GJKSolverType.GST_LIBCCD,
    ccd_solver_type=fcl.CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT,
)


@dataclass(frozen=True)
class Ball:
    """Around an object, in its frame."""

    centre: np.ndarray
    radius: float

    def swept(self, before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, float]:
        """The centre where the motion begins, and how far from there anything of the object may come.

        FCL moves the origin straight and turns at even speed, so the centre's way is no longer than this.
        """
        turn = before[:3, :3].T @ after[:3, :3]
        angle = math.acos(min(1.0, max(-1.0, (np.trace(turn) - 1) / 2)))
        way = np.linalg.norm(after[:3, 3] - before[:3, 3]) + angle * np.linalg.norm(self.centre)
        return before[:3, :3] @ self.centre + before[:3, 3], self.radius + float(way)


def around(points: np.ndarray) -> Ball:
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    return Ball(centre, float(np.linalg.norm(points - centre, axis=1).max()))


def corners(primitive: neutral.Primitive) -> np.ndarray:
    """Of a box around a primitive, in its frame."""
    sizes = primitive.sizes
    if primitive.shape == "box":
        half = np.array(sizes) / 2
    else:
        round_ends = sizes[0] if primitive.shape in ("sphere", "capsule") else 0.0
        half = np.array([sizes[0], sizes[0], round_ends + (sizes[1] / 2 if len(sizes) > 1 else 0.0)])
    return half * np.array(list(itertools.product((-1, 1), repeat=3)))


class Sweep:
    """All objects' ways along one edge."""

    def __init__(
        self,
        objects: list[fcl.CollisionObject],
        balls: list[Ball],
        pairs: np.ndarray,
        before: list[np.ndarray],
        after: list[np.ndarray],
    ) -> None:
        start, end = ([fcl.Transform(p[:3, :3], p[:3, 3]) for p in poses] for poses in (before, after))
        self._ways = [(objects[i], start[i], end[i], objects[j], start[j], end[j]) for i, j in pairs]
        self._first, self._second = pairs[:, 0], pairs[:, 1]
        swept = [ball.swept(b, a) for ball, b, a in zip(balls, before, after)]
        self._centres, self._reaches = np.array([c for c, _ in swept]), np.array([r for _, r in swept])

    def is_free(self) -> bool:
        """Every pair is asked of FCL."""
        return not any(map(_touches, self._ways))

    def is_free_with_spheres(self) -> bool:
        """Only pairs whose spheres can meet on the way are."""
        apart = self._centres[self._first] - self._centres[self._second]
        reach = self._reaches[self._first] + self._reaches[self._second]
        near = np.flatnonzero(np.einsum("ij,ij->i", apart, apart) <= reach * reach)
        return not any(_touches(self._ways[k]) for k in near)


def _touches(
    ways: tuple[
        fcl.CollisionObject, fcl.Transform, fcl.Transform, fcl.CollisionObject, fcl.Transform, fcl.Transform
    ],
) -> bool:
    a, start_a, end_a, b, start_b, end_b = ways
    result = fcl.ContinuousCollisionResult()
    a.setTransform(start_a)
    b.setTransform(start_b)
    fcl.continuousCollide(a, end_a, b, end_b, ADVANCEMENT, result)
    return bool(result.is_collide)
