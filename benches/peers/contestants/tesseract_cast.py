"""Contestant Tesseract with Bullet's cast: the convex hull of each triangle before and after a step.

Transforms are given to it, in its favour. What turns is outside that hull on the way: no step is safe, short ones are
less unsafe.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path

import edges
import neutral
import numpy as np
import tesseract_robotics
from tesseract_robotics.tesseract_collision import ContactRequest, ContactResultMap, ContactTestType_FIRST
from tesseract_robotics.tesseract_common import (
    GeneralResourceLocator,
    Isometry3d,
    TransformMap,
    VectorIsometry3d,
    VectorVector3d,
)
from tesseract_robotics.tesseract_environment import Environment
from tesseract_robotics.tesseract_geometry import Box, Capsule, Cylinder, GeometriesConst, Mesh, Sphere

MANAGER = "BulletCastBVHManager"

# What a step of an edge is cast from and to.
Step = tuple[TransformMap, TransformMap]


class TesseractCast:
    def load(self, words: list[str]) -> None:
        self.robot = neutral.read(words[0])
        shapes = self._shapes()
        with tempfile.TemporaryDirectory() as folder:
            self.manager = _manager(list(shapes), self.robot.pairs, Path(folder))
        for link, (geometries, poses) in shapes.items():
            if not self.manager.addCollisionObject(link, 0, geometries, poses, True):
                raise ValueError(f"Tesseract refuses link {link}")
        moving = self._moving()
        self.moving = [link for link in shapes if link in moving]
        self.manager.setActiveCollisionObjects(self.moving)
        self.manager.setDefaultCollisionMarginData(0.0)
        at_rest = self.robot.link_poses(np.zeros(self.robot.states["random"].shape[1]))
        for link in shapes:
            if link not in moving:
                self.manager.setCollisionObjectsTransform(link, Isometry3d(at_rest[link]))
        self.request = ContactRequest(ContactTestType_FIRST)
        self.request.calculate_distance = False
        self.request.calculate_penetration = False
        self.result = ContactResultMap()

    def _shapes(self) -> dict[str, tuple[GeometriesConst, VectorIsometry3d]]:
        shapes: dict[str, tuple[GeometriesConst, VectorIsometry3d]] = {}

        def add(link: str, geometry: object, pose: np.ndarray) -> None:
            geometries, poses = shapes.setdefault(link, (GeometriesConst(), VectorIsometry3d()))
            geometries.append(geometry)
            poses.append(Isometry3d(pose))

        for link in self.robot.links.values():
            if link.triangles:
                points, triangles = VectorVector3d(), np.vstack(link.triangles)
                for point in np.vstack(link.vertices):
                    points.append(point)
                corners = np.hstack([np.full((len(triangles), 1), 3), triangles])  # each face says how many it has
                add(link.id, Mesh(points, corners.astype(np.int32).ravel()), np.eye(4))
        kinds = {"box": Box, "sphere": Sphere, "cylinder": Cylinder, "capsule": Capsule}
        for primitive in self.robot.primitives:
            add(primitive.link, kinds[primitive.shape](*primitive.sizes), primitive.pose)
        return shapes

    def _moving(self) -> set[str]:
        """The others are static for Tesseract: it casts them nowhere."""
        moving: set[str] = set()
        for link in self.robot.links.values():
            if link.kind in ("turns", "slides") or link.parent in moving:
                moving.add(link.id)
        return moving

    def take_edges(self, sets: dict[str, np.ndarray]) -> None:
        self.edges = sets

    def _steps(self, edge: np.ndarray, step: float) -> list[Step]:
        fractions = edges.in_turn(edges.steps(edge, step))
        placed = []
        for t in fractions:
            poses = self.robot.link_poses(edge[0] + t * (edge[1] - edge[0]))
            transforms = TransformMap()
            for link in self.moving:
                transforms[link] = Isometry3d(poses[link])
            placed.append(transforms)
        return list(zip(placed, placed[1:]))

    def _free_along(self, steps: list[Step]) -> bool:
        for before, after in steps:
            self.manager.setCollisionObjectsTransform(before, after)
            self.result.clear()
            self.manager.contactTest(self.result, self.request)
            if self.result.count() > 0:
                return False
        return True

    def calls(self, question: str, states: str) -> tuple[Callable[[object], object], list[object]] | None:
        if not question.startswith("edge-"):
            return None
        word = question.removeprefix("edge-")
        step = float("inf") if word == "whole" else float(word)
        return self._free_along, [self._steps(edge, step) for edge in neutral.first_few(self.edges, states)]

    def responses(self, question: str, states: str) -> Iterable[str]:
        call, arguments = self.calls(question, states) or (None, [])
        return ("1" if call(steps) else "0" for steps in arguments)


def _manager(links: list[str], pairs: list[tuple[str, str]], folder: Path) -> object:
    """Bullet's manager of an environment that knows the pairs, but no shapes: those come from the neutral file."""
    package = Path(tesseract_robotics.__file__).parent
    libraries = package.parent / "tesseract_robotics.libs"
    factories = next(libraries.glob("libtesseract_collision_bullet_factories*"))
    plugins = folder / "plugins.yaml"
    plugins.write_text(
        "contact_manager_plugins:\n"
        f"  search_paths: [{libraries}]\n"
        f"  search_libraries: [{factories.name.removeprefix('lib').removesuffix('.so')}]\n"
        "  continuous_plugins:\n"
        f"    default: {MANAGER}\n"
        f"    plugins: {{{MANAGER}: {{class: {MANAGER}Factory}}}}\n"
    )
    joint = '<joint name="to_{0}" type="floating"><parent link="all"/><child link="{0}"/></joint>'
    loose = "".join(f'<link name="{link}"/>' + joint.format(link) for link in links)
    asked = {frozenset(pair) for pair in pairs}
    others = [(a, b) for i, a in enumerate(links) for b in links[:i] if frozenset((a, b)) not in asked]
    allowed = "".join(f'<disable_collisions link1="{a}" link2="{b}" reason="Never"/>' for a, b in others)
    config = f'<contact_managers_plugin_config filename="file://{plugins}"/>'
    environment = Environment()
    urdf = f'<robot name="robot"><link name="all"/>{loose}</robot>'
    srdf = f'<robot name="robot" version="1.0.0">{allowed}{config}</robot>'
    if not environment.init(urdf, srdf, GeneralResourceLocator()):
        raise ValueError("Tesseract makes no environment")
    return environment.getContinuousContactManager(MANAGER)


if __name__ == "__main__":
    neutral.serve(TesseractCast())
