"""Obstacles in Pinocchio: added to the robot's geometry, and queried without the robot's self pairs."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import coal
import neutral
import numpy as np
import pinocchio as pin

# Edge (m) of the cubes that stand for points.
CUBE = 0.02


class Surroundings:
    def __init__(self, model: pin.Model, robot: pin.GeometryModel, world: neutral.Robot) -> None:
        self.model, self.data = model, model.createData()
        self.geometry = robot.clone()
        self.geometry.removeAllCollisionPairs()
        solids = range(robot.ngeoms)
        for number, (pose, shape) in enumerate(_solids(world)):
            placed = pin.GeometryObject(f"obstacle {number}", 0, 0, pin.SE3(pose), shape)
            obstacle = self.geometry.addGeometryObject(placed)
            for solid in solids:
                self.geometry.addCollisionPair(pin.CollisionPair(solid, obstacle))
        self.geometry_data = self.geometry.createData()
        for request in self.geometry_data.collisionRequests:
            request.break_distance = 0.0
        # a tree for each joint; that of the world is not built anew
        manager = pin.TreeBroadPhaseManager_DynamicAABBTreeCollisionManager
        self.tree = None if world.clouds else manager(self.model, self.geometry, self.geometry_data)

    def call(self, question: str) -> Callable[[np.ndarray], object] | None:
        """True where it touches, and which pair is nearest."""
        model, data, geometry, geometry_data, tree = (
            self.model,
            self.data,
            self.geometry,
            self.geometry_data,
            self.tree,
        )
        questions: dict[str, Callable[[np.ndarray], object]] = {
            "free-world-list": lambda q: pin.computeCollisions(model, data, geometry, geometry_data, q, True),
            "distance-world-list": lambda q: pin.computeDistances(model, data, geometry, geometry_data, q),
        }
        if tree is not None:
            questions["free-world-tree"] = lambda q: pin.computeCollisions(model, data, tree, q, True)
        return questions.get(question)

    def least(self, pair: int) -> float:
        return max(0.0, self.geometry_data.distanceResults[pair].min_distance)


def _solids(world: neutral.Robot) -> Iterator[tuple[np.ndarray, coal.CollisionGeometry]]:
    for link in world.links.values():
        if link.triangles:
            yield np.eye(4), _mesh(np.vstack(link.vertices), np.vstack(link.triangles))
    kinds = {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder}
    for primitive in world.primitives:
        yield primitive.pose, kinds[primitive.shape](*primitive.sizes)
    for points in world.clouds:
        yield np.eye(4), coal.makeOctree(np.asfortranarray(points), CUBE)


def _mesh(vertices: np.ndarray, triangles: np.ndarray) -> coal.CollisionGeometry:
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(triangles), len(vertices))
    points, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    for vertex in vertices:
        points.append(vertex)
    for a, b, c in triangles:
        faces.append(coal.Triangle(int(a), int(b), int(c)))
    mesh.addSubModel(points, faces)
    mesh.endModel()
    return mesh
