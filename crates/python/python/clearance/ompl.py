"""Adapters between OMPL and a checker: state spaces, validators with proven motions, certificates. Needs ``pip install "ompl>=2"``.

    import clearance as cl
    from clearance import ompl as proven
    from ompl import base as ob, geometric as og

    space = proven.state_space(checker)
    setup = og.SimpleSetup(space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(proven.StateValidityChecker(information, checker))
    information.setMotionValidator(proven.MotionValidator(information, checker))
    joints = proven.JointMapping(space, checker)
    setup.setStartAndGoalStates(joints.state(start), joints.state(goal))
    if setup.solve(1.0):
        certificate = proven.certificate(setup.getSolutionPath(), information, checker)

Validators keep the checker, but not the space information, which keeps them.
"""

from __future__ import annotations

import math
from typing import Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from ._clearance import Certificate, Checker, Error

try:
    from ompl import base as ob
    from ompl import geometric as og
except ImportError as why:
    raise ImportError(f'clearance.ompl needs the Python package ompl: pip install "ompl>=2" ({why})') from why

__all__ = [
    "ClearanceObjective",
    "JointMapping",
    "MotionValidator",
    "StateValidityChecker",
    "certificate",
    "positions",
    "state_space",
]

FULL_TURN = 2 * math.pi

# Fractions of the proven part of a motion that are tried as its last valid state.
LAST_VALID = (1.0, 0.999, 0.99, 0.9, 0.5)


def state_space(checker: Checker, bounds: Optional[Mapping[str, Tuple[float, float]]] = None) -> ob.StateSpace:
    """A state space of the joints of a checker, with their limits (rad, m).

    Joints with limits are dimensions of a `RealVectorStateSpace`, by name. A continuous joint, or the angle of a planar one, is an
    `SO2StateSpace` of its name, which interpolates the short way. With both, the result is a `CompoundStateSpace`, with weights of 1. `bounds` (lower, upper) replace the
    limits of joints by name. They are required for joints without limits: prismatic ones, the position of planar ones, and continuous
    ones that others mimic, since a full turn moves those elsewhere. Floating joints are rejected.
    """
    _reject_floating(checker)
    given = dict(bounds or {})
    unknown = [name for name in given if name not in checker.joint_names]
    if unknown:
        raise Error(f"bounds: the checker has no joint position '{unknown[0]}'; it has {', '.join(checker.joint_names)}")
    turning = _turning(checker)
    vector, angles = ob.RealVectorStateSpace(0), []
    for name, lower, upper in zip(checker.joint_names, checker.lower, checker.upper):
        if name in turning and name not in given and math.isinf(lower) and math.isinf(upper):
            angles.append(ob.SO2StateSpace())
            angles[-1].setName(name)
            continue
        lower, upper = given.get(name, (lower, upper))
        if lower > upper:
            raise Error(f"joint position '{name}' has the contradictory limits {lower} to {upper}, perhaps of joints that mimic it")
        if not (math.isfinite(lower) and math.isfinite(upper) and lower <= upper):
            raise Error(f"joint position '{name}' has limits {lower} to {upper}: give finite ones, as bounds={{'{name}': (lower, upper)}}")
        vector.addDimension(name, float(lower), float(upper))
    if vector.getDimension() and all(low == high for low, high in zip(vector.getBounds().low, vector.getBounds().high)):
        names = ", ".join(vector.getDimensionName(i) for i in range(vector.getDimension()))
        raise Error(f"no room to move: the limits of {names} are single positions; make the checker for a group without them")
    if not angles:
        return vector
    compound = ob.CompoundStateSpace()
    for part in [vector, *angles] if vector.getDimension() else angles:
        compound.addSubspace(part, 1.0)
    return compound


class JointMapping:
    """Where states of a space have the joint positions of a checker, by the names of dimensions and subspaces.

    `space` is a `RealVectorStateSpace` whose dimensions have names of joint positions, an `SO2StateSpace` with the name of a continuous
    joint, or a `CompoundStateSpace` of such spaces. A single `RealVectorStateSpace` without names has the order of
    ``checker.joint_names``. Raises `Error` for other spaces, which may interpolate in other ways, and for missing or unknown names.
    """

    def __init__(self, space: ob.StateSpace, checker: Checker) -> None:
        _reject_floating(checker)
        names = checker.joint_names
        self._space, self._count = space, len(names)
        self._vectors: List[Tuple[Tuple[int, ...], int, List[int]]] = []
        self._angles: List[Tuple[Tuple[int, ...], int]] = []
        column_of = {name: column for column, name in enumerate(names)}
        found: List[str] = []
        for path, part in _parts(space):
            if type(part) is ob.SO2StateSpace:
                found.append(part.getName())
                self._angles.append((path, column_of.get(part.getName(), -1)))
            else:
                own = [part.getDimensionName(i) for i in range(part.getDimension())]
                if not path and not any(own) and len(own) == len(names):
                    own = list(names)
                found += own
                self._vectors.append((path, len(own), [column_of.get(name, -1) for name in own]))
        _check_names(found, names)
        turning = _turning(checker)
        for _, column in self._angles:
            if names[column] not in turning:
                raise Error(
                    f"the state space has joint position '{names[column]}' as an SO2StateSpace, but only continuous joints and angles of "
                    "planar ones that no other joint mimics may turn through half a turn: use a dimension of a RealVectorStateSpace"
                )
        self._turning = np.array([column for _, column in self._angles], dtype=int)
        # the most frequent space: one vector, in order
        self._is_plain = not self._angles and [v[2] for v in self._vectors] == [list(range(len(names)))] and not self._vectors[0][0]

    def positions(self, state: ob.State) -> np.ndarray:
        """Joint positions (rad, m) of a state, shape (n,)."""
        if self._is_plain:
            return np.array(state[0 : self._count])
        q = np.empty(self._count)
        for path, count, columns in self._vectors:
            q[columns] = _part(state, path)[0:count]
        for path, column in self._angles:
            q[column] = _part(state, path).value
        return q

    def state(self, q: Sequence[float]) -> ob.State:
        """A new state of the space with joint positions of shape (n,); angles of continuous joints become those from -π to π."""
        state = self._space.allocState()
        self.set(state, q)
        return state

    def set(self, state: ob.State, q: Sequence[float]) -> None:
        """Sets the joint positions of a state."""
        q = np.asarray(q, dtype=float)
        if q.shape != (self._count,):
            raise ValueError(f"q has shape {q.shape}, but it must be ({self._count},)")
        for path, count, columns in self._vectors:
            _part(state, path)[0:count] = q[columns].tolist()
        for path, column in self._angles:
            _part(state, path).value = math.remainder(q[column], FULL_TURN)

    def motion(self, s1: ob.State, s2: ob.State) -> Tuple[np.ndarray, np.ndarray]:
        """The ends of the straight motion in joint positions that the space interpolates between two states.

        Positions of continuous joints at its end may be beyond half a turn.
        """
        q1, q2 = self.positions(s1), self.positions(s2)
        return q1, self._unrolled(q1, q2)

    def set_between(self, state: ob.State, ends: Tuple[ob.State, ob.State], fraction: float) -> None:
        """Sets a state to that at a fraction of the motion between two others: to these themselves at 0 and 1."""
        if fraction in (0.0, 1.0):
            self._space.copyState(state, ends[int(fraction)])
            return
        q1, q2 = self.motion(*ends)
        self.set(state, q1 + fraction * (q2 - q1))

    def path(self, path: og.PathGeometric) -> np.ndarray:
        """The states of a path, shape (k, n), such that straight motions between them are those that the space interpolates."""
        states = np.array([self.positions(state) for state in path.getStates()]).reshape(-1, self._count)
        # each motion is that from the state itself, moved by whole turns
        steps = np.diff(states[:, self._turning], axis=0)
        turns = np.where(np.abs(steps) > math.pi, -np.sign(steps), 0.0).cumsum(axis=0)
        states[1:, self._turning] += FULL_TURN * turns
        return states

    def _unrolled(self, q1: np.ndarray, q2: np.ndarray) -> np.ndarray:
        """As `SO2StateSpace` interpolates: the other way round if the difference is above half a turn."""
        if not len(self._turning):
            return q2
        q2 = q2.copy()
        difference = q2[self._turning] - q1[self._turning]
        q2[self._turning] -= np.where(np.abs(difference) > math.pi, np.copysign(FULL_TURN, difference), 0.0)
        return q2


class StateValidityChecker(ob.StateValidityChecker):
    """States are valid if they are free. Joint limits are left to the bounds of the space.

    ``clearance(state)`` is the least distance (m) of all pairs, padding subtracted, up to `max_distance`; 0 in collision.
    """

    def __init__(self, space_information: ob.SpaceInformation, checker: Checker, *, max_distance: float = 1.0) -> None:
        super().__init__(space_information)
        self._joints = JointMapping(space_information.getStateSpace(), checker)
        self._checker, self._max_distance = checker, max_distance
        # wrong options are an error now, not in the planner
        checker.distance(checker.configuration(), max_distance)

    def isValid(self, state: ob.State) -> bool:
        """True if every pair is proven apart."""
        return self._checker.is_free(self._joints.positions(state))

    def clearance(self, state: ob.State) -> float:
        """Least distance (m) of all pairs, at most ``max_distance``."""
        found = self._checker.distance(self._joints.positions(state), self._max_distance)
        return float(min(found.self_distance, found.world_distance, self._max_distance))


class MotionValidator(ob.MotionValidator):
    """Motions are valid if they are proven free, all the way from state to state, as the space interpolates them.

    `options` are those of ``Checker.check_motion``: ``tolerance``, ``timeout``, ``budget``. Motions that can not be decided are invalid.

    OMPL 2.0.1 does not pass the last valid state of an invalid motion from Python to C++: planners that extend motions up to it (KPIECE1,
    LBKPIECE1) discard the whole motion, which takes longer and is as safe. `checkMotionWithLastValid` returns it to callers in Python.
    Counters are those of this class; those of ``SpaceInformation`` stay 0.
    """

    def __init__(self, space_information: ob.SpaceInformation, checker: Checker, **options) -> None:
        super().__init__(space_information)
        self._joints = JointMapping(space_information.getStateSpace(), checker)
        self._checker, self._options = checker, options
        self._valid = self._invalid = 0
        # wrong options are an error now, not in the planner
        here = checker.configuration()
        checker.check_motion(here, here, **options)
        checker.are_edges_free(here, here, **options)

    def checkMotion(self, s1: ob.State, s2: ob.State, last_valid: Optional[ob.State] = None):
        """True if the motion is proven free. With `last_valid`, as `checkMotionWithLastValid`."""
        if last_valid is not None:
            return self.checkMotionWithLastValid(s1, s2, last_valid)
        q1, q2 = self._joints.motion(s1, s2)
        return self._counted(self._checker.are_edges_free(q1, q2, **self._options))

    def checkMotionWithLastValid(self, s1: ob.State, s2: ob.State, last_valid: Optional[ob.State]) -> Tuple[bool, float]:
        """Whether the motion is proven free, and a fraction of it up to which it is.

        `last_valid`, unless it is None, becomes the state at this fraction. The motion from `s1` to that state is proven free; if there is
        none, the fraction is 0 and the state is `s1`.
        """
        q1, q2 = self._joints.motion(s1, s2)
        report = self._checker.check_motion(q1, q2, **self._options)
        fraction = 1.0 if self._counted(report.free) else self._last_valid(q1, q2, report.t[0])
        if last_valid is not None:
            self._joints.set_between(last_valid, (s1, s2), fraction)
        return report.free, fraction

    def _last_valid(self, q1: np.ndarray, q2: np.ndarray, proven: float) -> float:
        """The largest of some fractions up to which the motion is proven free, its end included."""
        for part in LAST_VALID if proven > 0 else ():
            if self._checker.are_edges_free(q1, q1 + part * proven * (q2 - q1), **self._options):
                return part * proven
        return 0.0

    def _counted(self, free: bool) -> bool:
        self._valid += free
        self._invalid += not free
        return free

    def getValidMotionCount(self) -> int:
        """Number of motions that were valid."""
        return self._valid

    def getInvalidMotionCount(self) -> int:
        """Number of motions that were not."""
        return self._invalid

    def getCheckedMotionCount(self) -> int:
        """Number of motions that were checked."""
        return self._valid + self._invalid

    def getValidMotionFraction(self) -> float:
        """Fraction of the motions that were valid; 0 before the first."""
        return self._valid / max(self.getCheckedMotionCount(), 1)

    def resetMotionCounter(self) -> None:
        """Sets the counters to 0."""
        self._valid = self._invalid = 0


class ClearanceObjective(ob.OptimizationObjective):
    """Maximizes the least clearance (m) of a path, as OMPL's `MaximizeMinClearanceObjective` does.

    The cost of a motion is the least distance of all pairs at states of it, at most `step` apart (Euclidean norm; rad, m), and at most
    `max_distance` (m). It is sampled: only `MotionValidator` proves motions. A path whose cost is at least `threshold` (m) is good
    enough.

    OMPL 2.0.1 runs two threads in PRM and PRMstar, which wait for each other for ever if an objective is written in Python, as this one.
    """

    def __init__(
        self,
        space_information: ob.SpaceInformation,
        checker: Checker,
        *,
        max_distance: float = 0.2,
        step: float = 0.05,
        threshold: Optional[float] = None,
    ) -> None:
        super().__init__(space_information)
        if not (math.isfinite(step) and step > 0):
            raise Error(f"step is {step}, but must be a finite number above 0 (rad, m)")
        checker.distance(checker.configuration(), max_distance)
        self._joints = JointMapping(space_information.getStateSpace(), checker)
        self._checker, self._max_distance, self._step = checker, max_distance, step
        self.setCostThreshold(ob.Cost(max_distance if threshold is None else threshold))

    def _least(self, q: np.ndarray) -> ob.Cost:
        found = self._checker.distance(q, self._max_distance)
        return ob.Cost(float(min(np.min(found.self_distance), np.min(found.world_distance), self._max_distance)))

    def stateCost(self, state: ob.State) -> ob.Cost:
        """The clearance of a state."""
        return self._least(self._joints.positions(state))

    def motionCost(self, s1: ob.State, s2: ob.State) -> ob.Cost:
        """The least clearance of the states of a motion, both ends included."""
        q1, q2 = self._joints.motion(s1, s2)
        count = max(1, math.ceil(float(np.linalg.norm(q2 - q1)) / self._step))
        return self._least(q1 + np.linspace(0.0, 1.0, count + 1)[:, None] * (q2 - q1))

    def combineCosts(self, c1: ob.Cost, c2: ob.Cost) -> ob.Cost:
        """The smaller clearance."""
        return ob.Cost(min(c1.value(), c2.value()))

    def isCostBetterThan(self, c1: ob.Cost, c2: ob.Cost) -> bool:
        """True if the first clearance is larger."""
        return c1.value() > c2.value()

    def isSatisfied(self, cost: ob.Cost) -> bool:
        """True if the clearance is good enough."""
        return cost.value() >= self.getCostThreshold().value()

    def identityCost(self) -> ob.Cost:
        """The clearance of no motion."""
        return ob.Cost(math.inf)

    def infiniteCost(self) -> ob.Cost:
        """The worst clearance."""
        return ob.Cost(-math.inf)


def positions(path: og.PathGeometric, space_information: ob.SpaceInformation, checker: Checker) -> np.ndarray:
    """Joint positions (rad, m) of the states of a path, shape (k, n), as `JointMapping.path` has them."""
    return JointMapping(space_information.getStateSpace(), checker).path(path)


def certificate(path: og.PathGeometric, space_information: ob.SpaceInformation, checker: Checker, **options) -> Certificate:
    """Proves a path free, edge by edge as its space interpolates it, and returns the certificate of the whole path.

    `options` are those of ``Checker.check_trajectory``. Raises `Error` if the path is not proven free; the text names the edge.
    ``clearance.verify`` checks the certificate for ``trajectory=(None, checker.expand(positions(path, ...)))``.
    """
    report = checker.check_trajectory(None, positions(path, space_information, checker), certificate=True, **options)
    if report.certificate is None:
        pair = "" if report.pair is None else f" of {report.pair[0]} and {report.pair[1]}"
        reason = "" if report.reason is None else f" ({report.reason.name})"
        raise Error(f"the path is not proven free: its edge {report.segment} is {report.verdict.name}{reason}{pair} at t = {report.t}")
    return report.certificate


def _turning(checker: Checker) -> List[str]:
    """Names of positions that a full turn leaves where they are: continuous joints that no other joint mimics, and planar angles."""
    types: Dict[str, str] = checker.robot.joint_types
    leaders = {leader for leader, _, _ in checker.robot.mimics.values()}
    angles = [f"{name}/theta" for name, kind in types.items() if kind == "planar"]
    return [name for name, kind in types.items() if kind == "continuous" and name not in leaders] + angles


def _reject_floating(checker: Checker) -> None:
    floating = [name for name, kind in checker.robot.joint_types.items() if kind == "floating"]
    moving = [name for name in floating if f"{name}/rot_w" in checker.joint_names]
    if moving:
        raise Error(f"the floating joint '{moving[0]}' cannot be planned with OMPL: leave it out, by the group of the checker")


def _parts(space: ob.StateSpace, path: Tuple[int, ...] = ()):
    """The vectors and angles of a space, each with its path of indices in a state."""
    # no classes derived of these: they may interpolate in other ways
    if type(space) is ob.CompoundStateSpace:
        for i in range(space.getSubspaceCount()):
            yield from _parts(space.getSubspace(i), (*path, i))
    elif type(space) in (ob.RealVectorStateSpace, ob.SO2StateSpace):
        yield path, space
    else:
        raise Error(
            f"the state space '{space.getName()}' is a {type(space).__name__}, but edges are proven only for RealVectorStateSpace, "
            "SO2StateSpace, and CompoundStateSpace of these"
        )


def _part(state: ob.State, path: Tuple[int, ...]):
    for index in path:
        state = state[index]
    return state


def _check_names(found: List[str], names: List[str]) -> None:
    form = f"must be those of checker.joint_names, each once: {', '.join(names)}"
    for name in found:
        if name not in names:
            raise Error(f"the state space has a dimension or angle '{name}', but their names {form}")
        if found.count(name) > 1:
            raise Error(f"the state space has '{name}' twice, but the names of its dimensions and angles {form}")
    missing = [name for name in names if name not in found]
    if missing:
        raise Error(f"the state space has no dimension or angle '{missing[0]}', but their names {form}")
