"""FCL through python-fcl: persistent objects, a fixed list of pairs. Transforms are given to it, in its favour."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import fcl
import neutral
import numpy as np


class PythonFcl:
    def load(self, words: list[str]) -> None:
        self.robot = neutral.read(words[0])
        of_link: dict[str, list[int]] = {}
        self.objects: list[fcl.CollisionObject] = []
        self.places: list[tuple[str, np.ndarray]] = []
        for link, pose, geometry in self._geometries():
            of_link.setdefault(link, []).append(len(self.objects))
            self.objects.append(fcl.CollisionObject(geometry))
            self.places.append((link, pose))
        numbers = [(i, j) for a, b in self.robot.pairs for i in of_link[a] for j in of_link[b]]
        self.pairs = [(self.objects[i], self.objects[j]) for i, j in numbers]
        self.request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)
        self.transforms: dict[str, list[list[fcl.Transform]]] = {}

    def _geometries(self) -> Iterable[tuple[str, np.ndarray, object]]:
        for link in self.robot.links.values():
            if link.triangles:
                vertices, triangles = np.vstack(link.vertices), np.vstack(link.triangles)
                mesh = fcl.BVHModel()
                mesh.beginModel(len(vertices), len(triangles))
                mesh.addSubModel(vertices, triangles)
                mesh.endModel()
                yield link.id, np.eye(4), mesh
        kinds = {"box": fcl.Box, "sphere": fcl.Sphere, "cylinder": fcl.Cylinder, "capsule": fcl.Capsule}
        for primitive in self.robot.primitives:
            yield primitive.link, primitive.pose, kinds[primitive.shape](*primitive.sizes)

    def _placed(self, states: str) -> list[list[fcl.Transform]]:
        if states not in self.transforms:
            self.transforms[states] = []
            for q in self.robot.chosen(states):
                links = self.robot.link_poses(q)
                poses = [links[link] @ pose for link, pose in self.places]
                self.transforms[states].append([fcl.Transform(p[:3, :3], p[:3, 3]) for p in poses])
        return self.transforms[states]

    def _touches(self, transforms: list[fcl.Transform]) -> bool:
        for solid, transform in zip(self.objects, transforms):
            solid.setTransform(transform)
        return any(fcl.collide(a, b, self.request, fcl.CollisionResult()) for a, b in self.pairs)

    def calls(self, question: str, states: str) -> tuple[Callable[[object], object], list[object]] | None:
        return (self._touches, self._placed(states)) if question == "free" else None

    def answers(self, question: str, states: str) -> Iterable[str]:
        return ("0" if self._touches(transforms) else "1" for transforms in self._placed(states))


if __name__ == "__main__":
    neutral.serve(PythonFcl())
