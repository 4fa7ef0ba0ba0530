"""FCL through python-fcl: persistent objects, a fixed list of pairs. Transforms are given to it, in its favour."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable

import fcl
import neutral
import numpy as np


# An object of a pair, where it begins and where it ends; then the other one.
Sweep = tuple[fcl.CollisionObject, fcl.Transform, fcl.Transform, fcl.CollisionObject, fcl.Transform, fcl.Transform]

# Conservative advancement between two poses, turning at even speed: FCL's only check that looks between samples.
ADVANCEMENT = fcl.ContinuousCollisionRequest(
    num_max_iterations=10,
    toc_err=1e-4,
    ccd_motion_type=fcl.CCDMotionType.CCDM_LINEAR,
    gjk_solver_type=fcl.GJKSolverType.GST_LIBCCD,
    ccd_solver_type=fcl.CCDSolverType.CCDC_CONSERVATIVE_ADVANCEMENT,
)


class PythonFcl:
    def load(self, words: list[str]) -> None:
        self.robot = neutral.read(words[0])
        of_link: dict[str, list[int]] = {}
        self.objects: list[fcl.CollisionObject] = []
        self.places: list[tuple[str, np.ndarray]] = []
        self.spheres: list[tuple[np.ndarray, float]] = []
        for link, pose, geometry, points in self._geometries():
            of_link.setdefault(link, []).append(len(self.objects))
            self.objects.append(fcl.CollisionObject(geometry))
            self.spheres.append(_sphere(points))
            self.places.append((link, pose))
        self.numbers = [(i, j) for a, b in self.robot.pairs for i in of_link[a] for j in of_link[b]]
        self.pairs = [(self.objects[i], self.objects[j]) for i, j in self.numbers]
        self.request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)
        self.transforms: dict[str, list[list[fcl.Transform]]] = {}

    def _geometries(self) -> Iterable[tuple[str, np.ndarray, object, np.ndarray]]:
        """Link, pose, shape, and points whose hull holds it."""
        for link in self.robot.links.values():
            if link.triangles:
                vertices, triangles = np.vstack(link.vertices), np.vstack(link.triangles)
                mesh = fcl.BVHModel()
                mesh.beginModel(len(vertices), len(triangles))
                mesh.addSubModel(vertices, triangles)
                mesh.endModel()
                yield link.id, np.eye(4), mesh, vertices
        kinds = {"box": fcl.Box, "sphere": fcl.Sphere, "cylinder": fcl.Cylinder, "capsule": fcl.Capsule}
        for primitive in self.robot.primitives:
            shape = kinds[primitive.shape](*primitive.sizes)
            yield primitive.link, primitive.pose, shape, _corners(primitive)

    def _placed(self, states: str) -> list[list[fcl.Transform]]:
        if states not in self.transforms:
            self.transforms[states] = []
            for q in self.robot.chosen(states):
                self.transforms[states].append([fcl.Transform(p[:3, :3], p[:3, 3]) for p in self._poses(q)])
        return self.transforms[states]

    def _poses(self, q: np.ndarray) -> list[np.ndarray]:
        links = self.robot.link_poses(q)
        return [links[link] @ pose for link, pose in self.places]

    def _touches(self, transforms: list[fcl.Transform]) -> bool:
        for solid, transform in zip(self.objects, transforms):
            solid.setTransform(transform)
        return any(fcl.collide(a, b, self.request, fcl.CollisionResult()) for a, b in self.pairs)

    def calls(self, question: str, states: str) -> tuple[Callable[[object], object], list[object]] | None:
        if question == "edge":
            return self._free_along, [self._sweep(edge) for edge in neutral.first_few(self.edges, states)]
        return (self._touches, self._placed(states)) if question == "free" else None

    def answers(self, question: str, states: str) -> Iterable[str]:
        if question == "edge":
            call, sweeps = self.calls(question, states) or (None, [])
            return ("1" if call(sweep) else "0" for sweep in sweeps)
        return ("0" if self._touches(transforms) else "1" for transforms in self._placed(states))

    def take_edges(self, sets: dict[str, np.ndarray]) -> None:
        self.edges = sets

    def _sweep(self, edge: np.ndarray) -> list[Sweep]:
        """The pairs whose bounding spheres may meet on the way, each with where it begins and ends."""
        before, after = (self._poses(q) for q in edge)
        start, end = ([fcl.Transform(p[:3, :3], p[:3, 3]) for p in poses] for poses in (before, after))
        near = [(i, j) for i, j in self.numbers if self._may_meet(i, j, before, after)]
        return [(self.objects[i], start[i], end[i], self.objects[j], start[j], end[j]) for i, j in near]

    def _may_meet(self, i: int, j: int, before: list[np.ndarray], after: list[np.ndarray]) -> bool:
        (a, reach_a), (b, reach_b) = (self._ball(k, before[k], after[k]) for k in (i, j))
        return float(np.linalg.norm(a - b)) <= reach_a + reach_b

    def _ball(self, k: int, before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, float]:
        """Of an object's sphere the centre where it begins, and how far from there anything of it may come.

        FCL moves the origin straight and turns at even speed, so the centre's way is no longer than this.
        """
        centre, radius = self.spheres[k]
        turn = before[:3, :3].T @ after[:3, :3]
        angle = math.acos(min(1.0, max(-1.0, (np.trace(turn) - 1) / 2)))
        way = np.linalg.norm(after[:3, 3] - before[:3, 3]) + angle * np.linalg.norm(centre)
        return before[:3, :3] @ centre + before[:3, 3], radius + float(way)

    def _free_along(self, sweep: list[Sweep]) -> bool:
        for a, start_a, end_a, b, start_b, end_b in sweep:
            result = fcl.ContinuousCollisionResult()
            a.setTransform(start_a)
            b.setTransform(start_b)
            fcl.continuousCollide(a, end_a, b, end_b, ADVANCEMENT, result)
            if result.is_collide:
                return False
        return True


def _sphere(points: np.ndarray) -> tuple[np.ndarray, float]:
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    return centre, float(np.linalg.norm(points - centre, axis=1).max())


def _corners(primitive: neutral.Primitive) -> np.ndarray:
    """Of a box around a primitive."""
    sizes = primitive.sizes
    if primitive.shape == "box":
        half = np.array(sizes) / 2
    else:
        ends = sizes[0] if primitive.shape in ("sphere", "capsule") else 0.0
        half = np.array([sizes[0], sizes[0], ends + (sizes[1] / 2 if len(sizes) > 1 else 0.0)])
    return half * np.array(list(itertools.product((-1, 1), repeat=3)))


if __name__ == "__main__":
    neutral.serve(PythonFcl())
