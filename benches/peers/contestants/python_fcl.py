"""Contestant FCL through python-fcl: persistent objects, a fixed list of pairs. Kinematics are not timed."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import fcl
import fcl_edges
import neutral
import numpy as np


class PythonFcl:
    def load(self, words: list[str]) -> None:
        self.robot = neutral.read(words[0])
        of_link: dict[str, list[int]] = {}
        self.objects: list[fcl.CollisionObject] = []
        self.places: list[tuple[str, np.ndarray]] = []
        self.balls: list[fcl_edges.Ball] = []
        for link, pose, geometry, points in self._geometries():
            of_link.setdefault(link, []).append(len(self.objects))
            self.objects.append(fcl.CollisionObject(geometry))
            self.balls.append(fcl_edges.around(points))
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
            yield primitive.link, primitive.pose, shape, fcl_edges.corners(primitive)

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
        ways = {"edge-pairs": fcl_edges.Sweep.is_free, "edge-spheres": fcl_edges.Sweep.is_free_with_spheres}
        if question in ways:
            return ways[question], [self._sweep(edge) for edge in neutral.first_few(self.edges, states)]
        return (self._touches, self._placed(states)) if question == "free" else None

    def responses(self, question: str, states: str) -> Iterable[str]:
        call, arguments = self.calls(question, states) or (None, [])
        hit = question == "free"  # of a state it is told whether it touches, of an edge whether it is free
        return ("0" if call(argument) == hit else "1" for argument in arguments)

    def take_edges(self, sets: dict[str, np.ndarray]) -> None:
        self.edges = sets

    def _sweep(self, edge: np.ndarray) -> fcl_edges.Sweep:
        before, after = (self._poses(q) for q in edge)
        return fcl_edges.Sweep(self.objects, self.balls, np.array(self.numbers), before, after)


if __name__ == "__main__":
    neutral.serve(PythonFcl())
