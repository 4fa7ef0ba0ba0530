"""Wrappers of the planners of OMPL and RoboPlan: each returns states (k, n), or None if it found no path in time."""

import itertools

import numpy as np
from ompl import geometric as og
from ompl import util as ou
from roboplan import core, rrt

from clearance import ompl as proven
from problems import GROUP, matrix

ou.setLogLevel(ou.LOG_ERROR)


class Ompl:
    """RRTConnect and simplification; motions are checked at states `step` apart (rad; default: that of OMPL), or are proven."""

    def __init__(self, name, problem, step=None, is_proven=False, is_simplified=True):
        self.name, self._problem, self._is_simplified = name, problem, is_simplified
        space = proven.state_space(problem.checker)
        self._setup = og.SimpleSetup(space)
        self._information = self._setup.getSpaceInformation()
        self._setup.setStateValidityChecker(proven.StateValidityChecker(self._information, problem.checker))
        if is_proven:
            self._information.setMotionValidator(proven.MotionValidator(self._information, problem.checker))
        elif step:
            self._information.setStateValidityCheckingResolution(step / space.getMaximumExtent())
        self._joints = proven.JointMapping(space, problem.checker)

    @property
    def step(self):
        """Distance (rad) of the states that OMPL checks on a motion."""
        return self._information.getStateValidityCheckingResolution() * self._information.getMaximumExtent()

    def plan(self, seed, seconds):
        self._setup.clear()
        self._setup.setPlanner(og.RRTConnect(self._information))
        self._setup.setStartAndGoalStates(*map(self._joints.state, (self._problem.start, self._problem.goal)))
        self._setup.solve(seconds)
        if not self._setup.haveExactSolutionPath():
            return None
        if self._is_simplified:
            self._setup.simplifySolution()
        return self._joints.path(self._setup.getSolutionPath())


class Roboplan:
    """RRT-Connect and shortcuts with default steps."""

    def __init__(self, name, problem):
        self.name, self._problem = name, problem
        description = core.loadUrdfSceneDescription(problem.urdf, [problem.packages])
        self.scene = core.Scene("panda", description)
        self.scene.importSrdf(problem.srdf.read_text())
        color = np.ones(4)
        for obstacle in problem.obstacles:
            shape, pose = obstacle["shape"], np.asfortranarray(matrix(obstacle))
            if shape["type"] == "box":
                self.scene.addBoxGeometry(obstacle["name"], "universe", core.Box(*shape["size"]), pose, color)
            else:
                cylinder = core.Cylinder(shape["radius"], shape["length"])
                self.scene.addCylinderGeometry(obstacle["name"], "universe", cylinder, pose, color)
        # it also checks obstacles against each other, some of which touch
        names = [obstacle["name"] for obstacle in problem.obstacles]
        touching = [*itertools.combinations(names, 2), *problem.allowed_pairs]
        self.scene.setCollisions(touching, False)
        positions = self.scene.getCurrentJointPositions()
        for name in self.scene.getJointNames():
            if name in problem.other_joints:
                positions[self.scene.getJointPositionIndices([name])] = problem.other_joints[name]
        self.scene.setJointPositions(positions)

    def plan(self, seed, seconds):
        names = self._problem.checker.joint_names
        options = rrt.RRTOptions(group_name=GROUP, rrt_connect=True, max_nodes=100_000, max_planning_time=seconds)
        planner = rrt.RRT(self.scene, options)
        planner.setRngSeed(seed)
        ends = [core.JointConfiguration(names, q) for q in (self._problem.start, self._problem.goal)]
        try:
            path = planner.plan(*ends)
        except RuntimeError:
            return None
        path = core.PathShortcutter(self.scene, core.PathShortcuttingOptions(group_name=GROUP, seed=seed)).shortcut(path)
        return np.array(path.positions)


def contestants(problem):
    """All planners with the meshes of the robot, on a problem."""
    return [
        Ompl("OMPL, default", problem),
        Ompl("OMPL, default, not simplified", problem, is_simplified=False),
        Ompl("OMPL, 0.005 rad", problem, step=0.005),
        Roboplan("roboplan, default", problem),
        Ompl("OMPL, proven edges", problem, is_proven=True),
    ]
