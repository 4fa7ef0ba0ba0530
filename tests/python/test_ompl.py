"""Tests of the planners of OMPL: motions as OMPL interpolates them, and paths that are proven free."""

import gc
import json
import math
import subprocess
import sys

import numpy as np
import pytest

import clearance as cl
from conftest import ALL_KINDS, ROOT

pytest.importorskip("ompl", exc_type=ImportError)
from ompl import base as ob  # noqa: E402
from ompl import geometric as og  # noqa: E402
from ompl import util as ou  # noqa: E402

from clearance import ompl as proven  # noqa: E402

SHARED = ROOT.parent / "shared"
SOLVED_WITHIN = 60.0  # [s], a limit for failures

# an arm that turns without limits, then slides
SPINNER = """<robot name="spinner"><link name="root"/><link name="arm"/>
  <link name="tip"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="spin" type="continuous"><parent link="root"/><child link="arm"/><axis xyz="0 0 1"/></joint>
  <joint name="lift" type="prismatic"><parent link="arm"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


ou.setLogLevel(ou.LOG_ERROR)
ou.RNG.setSeed(1)


CART = """<robot name="cart"><link name="root"/>
  <link name="cart"><collision><geometry><box size="0.4 0.2 0.2"/></geometry></collision></link>
  <joint name="p" type="planar"><parent link="root"/><child link="cart"/><axis xyz="0 0 1"/></joint></robot>"""


@pytest.fixture(scope="module")
def spinner():
    world = cl.World()
    world.add_box("behind", (0.3, 0.02, 0.5), (-1.0, 0, 0))
    return cl.Checker(cl.Robot.from_urdf(SPINNER), world)


def setup_of(checker, space=None, **options):
    setup = og.SimpleSetup(space or proven.state_space(checker))
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(proven.StateValidityChecker(information, checker))
    information.setMotionValidator(proven.MotionValidator(information, checker, **options))
    return setup, information, proven.JointMapping(setup.getStateSpace(), checker)


def solve(setup, joints, planner, start, goal):
    setup.clear()
    setup.setPlanner(planner(setup.getSpaceInformation()))
    setup.setStartAndGoalStates(joints.state(start), joints.state(goal))
    setup.solve(SOLVED_WITHIN)
    assert setup.haveExactSolutionPath()
    return setup.getSolutionPath()


def samples(space, joints, s1, s2, count):
    """States as OMPL interpolates them."""
    between, states = space.allocState(), []
    for t in np.linspace(0, 1, count):
        space.interpolate(s1, s2, t, between)
        states.append(joints.positions(between))
    return np.array(states)


def check_path(checker, setup, path, joints, count=300):
    """By its certificate, by another check of the whole, and by dense samples of what OMPL interpolates."""
    information, space = setup.getSpaceInformation(), setup.getStateSpace()
    states = proven.positions(path, information, checker)
    certificate = proven.certificate(path, information, checker)
    assert certificate.segments == len(states) - 1
    assert cl.verify(certificate, checker.robot, checker.world, trajectory=(None, checker.expand(states)), **checker.settings)
    assert checker.check_trajectory(None, states, shortest=True).free
    for s1, s2, q1, q2 in zip(path.getStates(), path.getStates()[1:], states, states[1:]):
        sampled = samples(space, joints, s1, s2, count)
        assert checker.is_free(sampled).all()
        straight = q1 + np.linspace(0, 1, count)[:, None] * (q2 - q1)
        assert np.allclose(np.cos(straight - sampled), 1.0, atol=1e-12)


def test_spaces_have_names_and_limits(arm, spinner):
    space = proven.state_space(arm)
    assert type(space) is ob.RealVectorStateSpace
    assert [space.getDimensionName(i) for i in range(7)] == arm.joint_names
    assert np.array_equal(space.getBounds().low, arm.lower) and np.array_equal(space.getBounds().high, arm.upper)
    space = proven.state_space(spinner)
    assert type(space) is ob.CompoundStateSpace
    assert space.getSubspace(0).getDimensionName(0) == "lift" and space.getSubspace(1).getName() == "spin"
    bounded = proven.state_space(spinner, {"spin": (-1.0, 2.0)})
    assert type(bounded) is ob.RealVectorStateSpace and list(bounded.getBounds().low) == [-1.0, -1.0]
    alone = proven.state_space(cl.Checker(cl.Robot.from_urdf(SPINNER.replace('name="lift" type="prismatic"', 'name="lift" type="fixed"')),
                                          spinner.world))
    assert type(alone.getSubspace(0)) is ob.SO2StateSpace and alone.getSubspaceCount() == 1


@pytest.mark.filterwarnings("ignore:the checker has no pair")
@pytest.mark.parametrize(
    "urdf, bounds, words",
    [
        (ALL_KINDS, None, "the floating joint 'f' cannot be planned with OMPL"),
        (CART, None, "joint position 'p/x' has limits -inf to inf: give finite ones, as bounds="),
        (SPINNER, {"turn": (0, 1)}, "bounds: the checker has no joint position 'turn'; it has spin, lift"),
        (SPINNER, {"lift": (0, math.inf)}, "'lift' has limits 0 to inf"),
        (SPINNER, {"lift": (1, 0)}, "'lift' has the contradictory limits 1 to 0"),
        # a follower is not where it was after a full turn of its leader
        (SPINNER.replace("<limit", '<mimic joint="spin" multiplier="0.5"/><limit').replace('lower="-1"', 'lower="-inf"').replace(
            'type="prismatic"', 'type="continuous"'), None, "joint position 'spin' has limits -inf to inf"),
    ],
)
def test_spaces_that_can_not_be_made(urdf, bounds, words):
    with pytest.raises(cl.Error, match=words):
        proven.state_space(cl.Checker(cl.Robot.from_urdf(urdf)), bounds)


def vector(*names):
    space = ob.RealVectorStateSpace(0)
    for name in names:
        space.addDimension(name, -1.0, 1.0)
    return space


def angle(name):
    space = ob.SO2StateSpace()
    space.setName(name)
    return space


def compound(*parts):
    space = ob.CompoundStateSpace()
    for part in parts:
        space.addSubspace(part, 1.0)
    return space


@pytest.mark.parametrize(
    "space",
    [
        lambda names: vector(*names),
        lambda names: vector(*reversed(names)),
        lambda names: ob.RealVectorStateSpace(7),
        lambda names: compound(vector(*names[4:]), vector(*names[:4])),
        lambda names: compound(compound(vector(names[6]), vector(*names[1:6])), vector(names[0])),
    ],
)
def test_positions_are_found_by_name(arm, states, space):
    space = space(arm.joint_names)
    joints = proven.JointMapping(space, arm)
    for q in states[:5, :7]:
        assert np.array_equal(joints.positions(joints.state(q)), q)
        if type(space) is ob.CompoundStateSpace:
            continue
        state = joints.state(q)
        names = [space.getDimensionName(i) for i in range(7)]
        assert [state[i] for i in range(7)] == [q[arm.joint_names.index(n) if n else i] for i, n in enumerate(names)]
    with pytest.raises(ValueError, match=r"q has shape \(6,\)"):
        joints.state(states[0, :6])


@pytest.mark.parametrize(
    "space, words",
    [
        (lambda: vector("lift"), "has no dimension or angle 'spin', but their names must be those of checker.joint_names"),
        (lambda: vector("lift", "turn"), "has a dimension or angle 'turn'"),
        (lambda: compound(vector("lift", "spin"), angle("spin")), "has 'spin' twice"),
        (lambda: compound(angle("lift"), angle("spin")), "'lift' as an SO2StateSpace, but only continuous joints"),
        (lambda: ob.RealVectorStateSpace(3), "has a dimension or angle ''"),
        (lambda: ob.SE2StateSpace(), "is a SE2StateSpace, but edges are proven only for"),
        (lambda: compound(vector("lift", "spin"), ob.DubinsStateSpace()), "is a DubinsStateSpace"),
    ],
)
def test_other_spaces_are_rejected(spinner, space, words):
    information = ob.SpaceInformation(space())
    for make in (proven.StateValidityChecker, proven.MotionValidator, proven.ClearanceObjective):
        with pytest.raises(cl.Error, match=words):
            make(information, spinner)


def test_motions_are_those_that_ompl_interpolates(spinner):
    """Also across half a turn, and for differences of exactly that."""
    setup, _, joints = setup_of(spinner)
    space = setup.getStateSpace()
    angles = [math.pi, -math.pi, 3.0, -3.0, 0.0, math.pi / 2, -math.pi / 2, 1.0, -2.5]
    crossed = 0
    for one in angles:
        for other in angles:
            s1, s2 = joints.state([0, 0.5]), joints.state([0, -0.5])
            s1[1].value, s2[1].value = one, other
            q1, q2 = joints.motion(s1, s2)
            sampled, t = samples(space, joints, s1, s2, 21), np.linspace(0, 1, 21)[:, None]
            straight = q1 + t * (q2 - q1)
            assert np.allclose(straight[:, 1], sampled[:, 1], atol=1e-15)
            assert np.allclose(np.exp(1j * straight[:, 0]), np.exp(1j * sampled[:, 0]), atol=1e-14)
            crossed += abs(q2[0]) > math.pi
    assert crossed > 10


def test_edges_go_the_short_way(spinner):
    """Behind the robot is an obstacle, which the long way avoids."""
    _, information, joints = setup_of(spinner)
    ahead, behind = (joints.state([0.6, 0.0]), joints.state([-0.6, 0.0])), (joints.state([2.7, 0.0]), joints.state([-2.7, 0.0]))
    assert information.checkMotion(*ahead) and not information.checkMotion(*behind)
    # the numbers alone would say otherwise
    assert spinner.are_edges_free([2.7, 0.0], [-2.7, 0.0])
    above = joints.state([2.7, 0.8]), joints.state([-2.7, 0.8])
    assert information.checkMotion(*above)


def test_paths_around_half_a_turn_are_proven(spinner):
    """Over the obstacle behind the robot, on the short way."""
    setup, information, joints = setup_of(spinner)
    for planner in (og.RRTConnect, og.RRT):
        path = solve(setup, joints, planner, [2.7, 0.0], [-2.7, 0.0])
        check_path(spinner, setup, path, joints)
    over = og.PathGeometric(information)
    for q in ([2.7, 0.0], [2.7, 0.9], [-2.7, 0.9], [-2.7, 0.0], [0.3, 0.0], [-1.5, 0.0], [-2.9, 0.9], [2.9, 0.9]):
        over.append(joints.state(q))
    check_path(spinner, setup, over, joints)
    states = proven.positions(over, information, spinner)
    assert states[2, 0] == pytest.approx(2 * math.pi - 2.7) and np.abs(np.diff(states[:, 0])).max() <= math.pi


def test_a_planar_joint_turns_the_short_way():
    world = cl.World()
    for i, y in enumerate((-0.6, 0.6)):
        world.add_box(f"wall{i}", (0.1, 0.9, 0.5), (0, y, 0))
    cart = cl.Checker(cl.Robot.from_urdf(CART), world)
    setup, _, joints = setup_of(cart, proven.state_space(cart, {"p/x": (-2, 2), "p/y": (-1, 1)}))
    assert np.allclose(joints.positions(joints.state([1.0, 0.5, 4.0])), [1.0, 0.5, 4.0 - 2 * math.pi])
    path = solve(setup, joints, og.RRTConnect, [-1.0, 0.5, 3.0], [1.0, 0.5, -3.0])
    check_path(cart, setup, path, joints)


@pytest.mark.parametrize("planner", [og.RRTConnect, og.RRT, og.KPIECE1, og.LBKPIECE1, og.BKPIECE1, og.PRM, og.FMT])
def test_paths_of_planners_are_proven(arm, planner):
    setup, information, joints = setup_of(arm)
    ends = [arm.configuration({"joint1": side, "joint2": 0.5, "joint4": -1.6, "joint6": 1.8}) for side in (-0.8, 0.8)]
    path = solve(setup, joints, planner, *ends)
    check_path(arm, setup, path, joints)
    setup.simplifySolution()
    check_path(arm, setup, setup.getSolutionPath(), joints)
    validator = information.getMotionValidator()
    assert validator.getCheckedMotionCount() >= validator.getValidMotionCount() > 0
    assert 0 < validator.getValidMotionFraction() <= 1
    validator.resetMotionCounter()
    assert validator.getCheckedMotionCount() == 0


SCENES = [
    ("panda-bookshelf_small", 0),
    ("panda-bookshelf_tall", 1),
    ("panda-box", 0),
    ("panda-cage", 0),
    ("panda-table_pick", 0),
]


def scene_checker(problem, scene):
    robots = SHARED / "robots"
    robot = cl.Robot.from_urdf(robots / scene["robot_urdf"], robots / scene["robot_srdf"], [robots])
    world = cl.World()
    for obstacle in (*scene.get("shared_obstacles", []), *problem["obstacles"]):
        shape, pose = obstacle["shape"], (obstacle["pose"]["xyz"], obstacle["pose"]["quat_xyzw"])
        if shape["type"] == "box":
            world.add_box(obstacle["name"], shape["size"], pose)
        else:
            assert shape["type"] == "cylinder"
            world.add_cylinder(obstacle["name"], shape["radius"], shape["length"], pose)
    allowed = [tuple(pair) for pair in problem.get("allowed_pairs", [])]
    return cl.Checker(robot, world, group="panda_arm", fixed=problem["other_joints"], allowed_collisions=allowed)


@pytest.mark.skipif(not (SHARED / "scenes").is_dir(), reason=f"there is no {SHARED / 'scenes'}")
@pytest.mark.filterwarnings("ignore::clearance.InputWarning")
@pytest.mark.parametrize("name, number", SCENES)
def test_paths_of_a_panda_are_proven(name, number):
    scene = json.loads((SHARED / "scenes" / f"{name}.json").read_text())
    problem = [p for p in scene["problems"] if p["start_valid"] and p["goal_valid"]][number]
    checker = scene_checker(problem, scene)
    ends = [checker.configuration({j: problem[end][j] for j in checker.joint_names}) for end in ("start", "goal")]
    assert checker.is_free(ends).all()
    setup, _, joints = setup_of(checker)
    path = solve(setup, joints, og.RRTConnect, *ends)
    check_path(checker, setup, path, joints)


def test_the_last_valid_state_is_reached_by_a_proven_motion(arm, home, states):
    _, information, joints = setup_of(arm)
    validator = information.getMotionValidator()
    last, found = joints.state(home), 0
    for q in states[:60, :7]:
        if not arm.is_free(q):
            continue
        s1, s2 = joints.state(q), joints.state(home + 0.8 * (q - home)[::-1])
        valid, fraction = validator.checkMotion(s1, s2, last)
        assert (valid, fraction) == validator.checkMotionWithLastValid(s1, s2, None) and valid == information.checkMotion(s1, s2)
        assert validator.checkMotion(s1, last) is True
        q1, q2 = joints.motion(s1, s2)
        reached = q2 if valid else q1 + fraction * (q2 - q1)
        assert np.array_equal(joints.positions(last), reached) and (fraction == 1.0) == valid
        found += 0 < fraction < 1
        if not valid:
            contact = arm.check_motion(q1, q2)
            assert fraction <= contact.t[0] and (fraction > 0.4 * contact.t[0] or contact.t[0] < 0.01)
    assert found > 5


def test_clearance_is_the_least_distance(arm, home):
    setup, information, joints = setup_of(arm)
    validity = information.getStateValidityChecker()
    state = joints.state(home)
    near = arm.distance(home, 1.0)
    assert validity.isValid(state) and validity.clearance(state) == min(near.self_distance, near.world_distance)
    objective = proven.ClearanceObjective(information, arm, max_distance=0.5, step=0.01)
    assert objective.stateCost(state).value() == validity.clearance(state)
    other = joints.state(home + 0.2)
    along = arm.distance(home + np.linspace(0, 1, 2000)[:, None] * 0.2, 0.5)
    least = min(along.self_distance.min(), along.world_distance.min())
    # at samples 0.01 apart; joints move all points of this arm by less than 2 m/rad in all
    assert least <= objective.motionCost(state, other).value() <= least + 0.01
    touching = joints.state(home + [0, 1.5, 0, 0, 0, 0, 0])
    assert validity.clearance(touching) == 0.0 and not validity.isValid(touching)
    better, worse = ob.Cost(0.2), ob.Cost(0.1)
    assert objective.isCostBetterThan(better, worse) and not objective.isCostBetterThan(worse, better)
    assert objective.combineCosts(better, worse).value() == 0.1
    assert objective.combineCosts(objective.identityCost(), worse).value() == 0.1
    assert objective.isCostBetterThan(worse, objective.infiniteCost())


def test_the_objective_prefers_clearance(arm, states):
    setup, information, joints = setup_of(arm)
    objective = proven.ClearanceObjective(information, arm)
    free = states[arm.is_free(states[:, :7]), :7]
    # near an obstacle half way
    ends = [(q1, q2) for q1, q2 in zip(free, free[0] + 0.4 * (free[1:] - free[0])) if information.checkMotion(joints.state(q1), joints.state(q2))]
    cost = {i: objective.motionCost(*map(joints.state, pair)).value() for i, pair in enumerate(ends)}
    bound = [min(objective.stateCost(joints.state(q)).value() for q in pair) for pair in ends]
    narrow = max(cost, key=lambda i: bound[i] - cost[i])
    assert bound[narrow] > cost[narrow] + 0.01
    objective.setCostThreshold(ob.Cost(cost[narrow] + 0.005))
    setup.setOptimizationObjective(objective)
    path = solve(setup, joints, og.BITstar, *ends[narrow])
    assert path.cost(objective).value() >= cost[narrow] + 0.005
    check_path(arm, setup, path, joints)


def test_paths_that_are_not_free_have_no_certificate(arm, home):
    setup, information, joints = setup_of(arm)
    path = og.PathGeometric(information)
    for q in (home, home + 0.05, home + [0, 1.5, 0, 0, 0, 0, 0], home):
        path.append(joints.state(q))
    with pytest.raises(cl.Error, match="the path is not proven free: its edge 1 is CONTACT of .* at t = "):
        proven.certificate(path, information, arm)
    with pytest.raises(cl.Error, match=r"its edge 0 is UNDECIDED \(DEADLINE\)"):
        proven.certificate(path, information, arm, timeout=0)


def test_options_and_errors_reach_the_caller(arm, home):
    setup, information, joints = setup_of(arm, tolerance=1e-3, timeout=10.0)
    with pytest.raises(cl.Error, match="tolerance is 0"):
        proven.MotionValidator(information, arm, tolerance=0.0)
    with pytest.raises(TypeError, match="no option 'tolerence'"):
        proven.MotionValidator(information, arm, tolerence=0.1)
    with pytest.raises(cl.Error, match="max_distance is -1"):
        proven.StateValidityChecker(information, arm, max_distance=-1.0)
    with pytest.raises(cl.Error, match="step is 0"):
        proven.ClearanceObjective(information, arm, step=0.0)
    state = joints.state(home)
    state[2] = math.nan
    with pytest.raises(cl.Error, match="joint 'joint3' has position NaN"):
        information.isValid(state)


def test_validators_are_kept_by_the_space_information(arm, home):
    setup, information, joints = setup_of(arm)
    gc.collect()
    assert information.isValid(joints.state(home)) and information.checkMotion(joints.state(home), joints.state(home + 0.01))


def test_the_example_runs():
    ended = subprocess.run([sys.executable, ROOT / "examples/ompl_plan.py"], capture_output=True, text=True, timeout=120)
    assert (ended.returncode, ended.stderr) == (0, "")
    *states, last = ended.stdout.splitlines()
    assert last == f"{len(states)} states, every edge proven free; certificate verified: True"
    assert all(len(state.split()) == 7 for state in states) and len(states) >= 2
