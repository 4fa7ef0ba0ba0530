"""Wrapper of VAMP's planner, and conversion of a problem to VAMP's Panda model and obstacles."""

import numpy as np
import vamp

from problems import matrix

FINGER = 0.065  # m, position of both fingers in VAMP's Panda, as in MotionBenchMaker; beyond the limits of the joints
BOXES = "box"  # the scene whose cylinders VAMP's own benchmark replaces by boxes


def problem_of_vamp(problem):
    """The problem with the fingers of VAMP's Panda, or None: its model has no allowed pairs."""
    return None if problem.allowed_pairs else problem.with_fingers_at(FINGER)


def environment(problem):
    """The obstacles of a problem, as `vamp.problem_dict_to_vamp` makes them: capsules around cylinders, boxes in the scene `box`."""
    made = vamp.Environment()
    for obstacle in problem.obstacles:
        pose = matrix(obstacle)
        position, angles, shape = pose[:3, 3].tolist(), _euler_angles(pose), obstacle["shape"]
        if shape["type"] == "box":
            made.add_cuboid(vamp.Cuboid(position, angles, [edge / 2 for edge in shape["size"]]))
        elif problem.scene == BOXES:
            made.add_cuboid(vamp.Cuboid(position, angles, [shape["radius"], shape["radius"], shape["length"] / 2]))
        else:
            made.add_capsule(vamp.Cylinder(position, angles, shape["radius"], shape["length"]))
    return made


def _euler_angles(pose):
    """Angles (rad) about the fixed axes x, y and z, in this order."""
    r = pose[:3, :3]
    return [float(np.arctan2(r[2, 1], r[2, 2])), float(-np.arcsin(np.clip(r[2, 0], -1, 1))), float(np.arctan2(r[1, 0], r[0, 0]))]


class Vamp:
    """RRT-Connect and simplification with VAMP's own settings for the Panda."""

    def __init__(self, name, problem, is_simplified=True):
        self.name, self._problem, self._is_simplified = name, problem, is_simplified
        self.environment = environment(problem)
        self.robot, self._search, self._settings, self._simplification = vamp.configure_robot_and_planner_with_kwargs("panda", "rrtc")
        if list(self.robot.joint_names()) != list(problem.checker.joint_names):
            raise ValueError(f"VAMP's Panda has other joints: {self.robot.joint_names()}")

    def is_valid(self, state):
        """Whether a state (rad) is valid for VAMP's spheres."""
        return self.robot.validate(state.tolist(), self.environment)

    def random(self, seed):
        """A source of random states: VAMP has no seeds, but may leave out the first states."""
        random = self.robot.xorshift()
        random.skip(10_000 * (seed - 1))
        return random

    def plan(self, seed, seconds=None):
        """States (k, 7), or None. The search ends by VAMP's number of iterations: it has no limit of time."""
        return self.search(self.random(seed))

    def search(self, random):
        """As `plan`."""
        ends = self._problem.start.tolist(), self._problem.goal.tolist()
        found = self._search(*ends, self.environment, self._settings, random)
        if not found.solved:
            return None
        if self._is_simplified:
            found = self.robot.simplify(found.path, self.environment, self._simplification, random)
        path = np.asarray(found.path.numpy(), dtype=float)
        # VAMP rounds to single precision
        path[0], path[-1] = self._problem.start, self._problem.goal
        return path
