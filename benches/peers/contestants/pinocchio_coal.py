"""Contestant Pinocchio with Coal, as Python users run it: the URDF's collision geometry, one call per state."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import edges
import neutral
import numpy as np
import pinocchio as pin
from pinocchio_joints import Joints
from pinocchio_worlds import Surroundings


class PinocchioCoal:
    def load(self, words: list[str]) -> None:
        """`words`: the neutral file, and the URDF with mesh names that are absolute paths."""
        file, urdf = words[0], words[1]
        self.robot = neutral.read(file)
        self.model = pin.buildModelFromUrdf(urdf)
        self.geometry = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION)
        self._check_triangles()
        self._add_pairs()
        self.data = self.model.createData()
        self.geometry_data = self.geometry.createData()
        for request in self.geometry_data.collisionRequests:
            request.break_distance = 0.0
        self.joints = Joints(self.model, self.robot)
        self.states = {name: list(self.joints.states(states)) for name, states in self.robot.states.items()}

    def _check_triangles(self) -> None:
        """The comparison is worth nothing unless both read the same meshes."""
        shapes = [o.geometry for o in self.geometry.geometryObjects]
        read = sum(s.num_tris for s in shapes if hasattr(s, "num_tris"))
        given = sum(len(t) for link in self.robot.links.values() for t in link.triangles)
        if read != given:
            raise ValueError(f"Pinocchio reads {read} triangles, clearance {given}")

    def _add_pairs(self) -> None:
        of_link: dict[str, list[int]] = {}
        for index, solid in enumerate(self.geometry.geometryObjects):
            of_link.setdefault(self.model.frames[solid.parentFrame].name, []).append(index)
        self.geometry.removeAllCollisionPairs()
        self.pair_names: list[str] = []
        for a, b in self.robot.pairs:
            for i in of_link[self.robot.links[a].name]:
                for j in of_link[self.robot.links[b].name]:
                    self.geometry.addCollisionPair(pin.CollisionPair(i, j))
                    self.pair_names.append(f"{a}-{b}")

    def take_world(self, world: neutral.Robot) -> None:
        self.surroundings = Surroundings(self.model, self.geometry, world)

    def take_edges(self, sets: dict[str, np.ndarray]) -> None:
        self.edges = sets

    def _free_along(self, edge: tuple[np.ndarray, np.ndarray]) -> bool:
        """Interpolates all samples of an edge at once, as NumPy is quick, and stops at the first hit."""
        (start, end), fractions = edge
        samples = self.joints.states(start + fractions[:, None] * (end - start))
        model, data, geometry, geometry_data = self.model, self.data, self.geometry, self.geometry_data
        for q in samples:
            if pin.computeCollisions(model, data, geometry, geometry_data, q, True):
                return False
        return True

    def calls(self, question: str, states: str) -> tuple[Callable[[object], object], list[object]] | None:
        model, data, geometry, geometry_data = self.model, self.data, self.geometry, self.geometry_data
        questions: dict[str, Callable[[object], object]] = {
            "free": lambda q: pin.computeCollisions(model, data, geometry, geometry_data, q, True),
            "pairs": lambda q: pin.computeCollisions(model, data, geometry, geometry_data, q, False),
            "distance": lambda q: pin.computeDistances(model, data, geometry, geometry_data, q),
        }
        if question.startswith("edge-"):
            order = edges.van_der_corput if question.startswith("edge-any-") else edges.in_turn
            step = float(question.rpartition("-")[2])
            some = neutral.first_few(self.edges, states)
            return self._free_along, [(e, order(edges.steps(e, step))) for e in some]
        call = self.surroundings.call(question) if "-world-" in question else questions.get(question)
        if call is None:
            return None
        return call, neutral.first_few(self.states, states)

    def responses(self, question: str, states: str) -> Iterable[str]:
        call, arguments = self.calls(question, states) or (None, [])
        for q in arguments:
            found = call(q)
            if question.startswith("edge-"):
                yield "1" if found else "0"
            elif question.startswith("free"):
                yield "0" if found else "1"
            elif question == "pairs":
                results = zip(self.pair_names, self.geometry_data.collisionResults)
                yield ",".join(sorted({name for name, result in results if result.isCollision()}))
            elif question.startswith("distance-world"):
                yield repr(self.surroundings.least(found))
            else:
                yield repr(max(0.0, self.geometry_data.distanceResults[found].min_distance))


if __name__ == "__main__":
    neutral.serve(PinocchioCoal())
