"""Independent check of states: Pinocchio's kinematics and Coal's collision tests on the same meshes and pairs."""

import coal
import numpy as np
import pinocchio as pin

from problems import matrix


class Oracle:
    def __init__(self, problem):
        self._names = problem.checker.joint_names
        self._model = pin.buildModelFromUrdf(str(problem.urdf))
        self._geometry = pin.buildGeomFromUrdf(self._model, str(problem.urdf), pin.COLLISION, package_dirs=[str(problem.packages)])
        for obstacle in problem.obstacles:
            shape = obstacle["shape"]
            made = coal.Box(*shape["size"]) if shape["type"] == "box" else coal.Cylinder(shape["radius"], shape["length"])
            self._geometry.addGeometryObject(pin.GeometryObject(obstacle["name"], 0, 0, pin.SE3(matrix(obstacle)), made))
        self._add_pairs(problem)
        self._data, self._collisions = self._model.createData(), self._geometry.createData()
        self._q = pin.neutral(self._model)
        for name, value in problem.other_joints.items():
            self._q[self._index(name)] = value

    def _add_pairs(self, problem):
        """Those that clearance checks, by names of bodies."""
        bodies = {}
        for i, thing in enumerate(self._geometry.geometryObjects):
            frame = self._model.frames[thing.parentFrame].name if thing.parentFrame else thing.name
            bodies.setdefault(frame, []).append(i)
        for a, b in problem.checker.pairs:
            for i in bodies[a]:
                for j in bodies[b]:
                    self._geometry.addCollisionPair(pin.CollisionPair(i, j))

    def _index(self, name):
        return self._model.joints[self._model.getJointId(name)].idx_q

    def collide(self, states):
        """For each state (rad), whether a pair collides."""
        columns = [self._index(name) for name in self._names]
        found = np.zeros(len(states), dtype=bool)
        for i, state in enumerate(states):
            self._q[columns] = state
            found[i] = pin.computeCollisions(self._model, self._data, self._geometry, self._collisions, self._q, True)
        return found
