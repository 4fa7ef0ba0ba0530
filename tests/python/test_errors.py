"""Tests of wrong arguments: the class of the exception, and words of its text."""

import importlib
import sys

import numpy as np
import pytest

import clearance as cl
from conftest import ALL_KINDS, URDF

ENDLESS = []  # contains itself
ENDLESS.append(ENDLESS)

EIGHT = r"must be \(\.\.\., 8\): one position for each of joint1"


@pytest.mark.parametrize("query", ["is_free", "distance", "check", "find_free_state", "expand"])
@pytest.mark.parametrize(
    "q, kind, words",
    [
        (np.zeros(7), ValueError, r"shape \(7,\).*" + EIGHT),
        (np.zeros((8, 3)), ValueError, r"shape \(8, 3\)"),
        (3.0, ValueError, "must be"),
        ([], ValueError, r"shape \(0,\)"),
        ("q", TypeError, "real numbers.*str"),
        (None, TypeError, "real numbers.*NoneType"),
        ([0] * 7 + ["x"], TypeError, "real numbers.*list"),
        (np.zeros(8, dtype=complex), TypeError, "complex128"),
        (np.zeros(8, dtype=bool), TypeError, "bool"),
        (np.array([None] * 8), TypeError, "object"),
        ({"joint1": 1.0}, TypeError, "dict"),
        ([[0] * 8, [0] * 7], TypeError, "one shape"),
        (np.ma.masked_array(np.zeros(8), np.eye(8)[0]), TypeError, r"q is or contains a masked array.*q.filled\(...\)"),
        (np.ma.masked_array(np.zeros((3, 8))), TypeError, "masked array"),
        ([np.zeros(8), np.ma.masked_array(np.zeros(8), np.eye(8)[0])], TypeError, "masked array"),
        (([0] * 7 + [np.ma.masked],), TypeError, "masked array"),
        (ENDLESS, TypeError, "q must be an array of real numbers"),
        (np.full(8, np.nan), cl.Error, "q: joint 'joint1' has position NaN, which is not finite"),
        ([0, 0, np.inf, 0, 0, 0, 0, 0], cl.Error, "joint 'joint3'"),
        ([1e9, 0, 0, 0, 0, 0, 0, 0], cl.Error, "joint 'joint1' has position 1e9, farther than"),
    ],
)
def test_states(checker, query, q, kind, words):
    with pytest.raises(kind, match=words):
        getattr(checker, query)(q)


@pytest.mark.parametrize("bad", [(0, 0), (99, 7), (57, 3)])
def test_the_first_bad_row_is_named(checker, states, bad):
    q = np.array(states)
    q[sum(bad) + 1 :, 2] = np.nan
    q[sum(bad), 4] = np.nan
    for _ in range(3):
        with pytest.raises(cl.Error, match=rf"q in row \[{sum(bad)}\]: joint 'joint5'"):
            checker.is_free(q)
    with pytest.raises(cl.Error, match=rf"row \[{sum(bad) // 4}, {sum(bad) % 4}\]"):
        checker.is_free(q.reshape(100, 4, 8))


@pytest.mark.parametrize(
    "settings, kind, words",
    [
        ({"group": "leg"}, cl.Error, "no group 'leg'; its SRDF has 'arm' and 'hand'"),
        ({"padding": -0.1}, cl.Error, "padding is -0.1"),
        ({"padding": "much"}, TypeError, "padding is 'much', but must be a number"),
        ({"pading": 0.1}, TypeError, "no setting 'pading'; there are padding"),
        ({"link_padding": {"none": 0.1}}, cl.Error, "link 'none'"),
        ({"object_padding": {"none": 0.1}}, cl.Error, "object_padding: there is no object 'none'"),
        ({"mesh_model": "hull"}, ValueError, "mesh_model is 'hull'"),
        ({"allowed_collisions": [("hand", "none")]}, cl.Error, "allowed_collisions: there is no link or object 'none'"),
        ({"allowed_collisions": [("hand", "hand")]}, cl.Error, "allowed_collisions: 'hand' is paired with itself"),
        ({"allowed_collisions": ["hand"]}, TypeError, "allowed_collisions is .*list of pairs"),
        ({"allowed_collisions": ["ab"]}, TypeError, "allowed_collisions is .*list of pairs"),
        ({"checked_collisions": "hand"}, TypeError, "checked_collisions is 'hand', but must be a list of pairs of names"),
        ({"checked_collisions": [["hand", "table", "ball"]]}, TypeError, "checked_collisions is .*list of pairs"),
        ({"link_padding": {"hand": "much"}}, TypeError, "link_padding is .*a dict from names to numbers"),
        ({"fixed": ["joint1"]}, TypeError, r"fixed is \['joint1'\], but must be a dict from names to numbers"),
        ({"fixed": {"none": 1.0}}, cl.Error, "fixed: the robot has no joint 'none'"),
        ({"group": "arm", "fixed": {"joint1": 1.0}}, cl.Error, "fixed: joint 'joint1' is one of group 'arm'"),
        ({"fixed": {"finger_joint1": 0.0}}, cl.Error, "fixed: joint 'finger_joint1' is one of the states"),
    ],
)
def test_settings(robot, world, settings, kind, words):
    with pytest.raises(kind, match=words):
        cl.Checker(robot, world, **settings)


@pytest.mark.parametrize(
    "change, kind, words",
    [
        (lambda w: w.add_box("table", (1, 1, 1)), cl.Error, "object 'table' is given twice"),
        (lambda w: w.add_box("b", (1, 1)), ValueError, r"size has shape \(2,\), but it must be \(3,\)"),
        (lambda w: w.add_box("b", (1, 1, -1)), cl.Error, "box size is -1"),
        (lambda w: w.add_sphere("b", np.nan), cl.Error, "sphere radius is NaN"),
        (lambda w: w.add_sphere("b", "big"), TypeError, "radius is 'big', but must be a number"),
        (lambda w: w.add_sphere(1, 1.0), TypeError, None),
        (lambda w: w.add_plane("b", (0, 0, 0)), cl.Error, "normal"),
        (lambda w: w.add_mesh("b", np.zeros((3, 2)), [[0, 1, 2]]), ValueError, r"vertices has shape \(3, 2\)"),
        (lambda w: w.add_mesh("b", np.eye(3), [[0, 1, 3]]), cl.Error, "names vertex 3"),
        (lambda w: w.add_mesh("b", np.eye(3), [[0, 1, -1]]), ValueError, "from 0, but one is -1"),
        (lambda w: w.add_mesh("b", np.eye(3), [[0, 1, 0.5]]), TypeError, "but one is 0.5"),
        (lambda w: w.add_points("b", [[0, 0, np.nan]], 0.1), ValueError, r"xyz\[0\].*isfinite"),
        (lambda w: w.add_points("b", np.zeros((0, 3)), 0.1), cl.Error, "no points"),
        (lambda w: w.add_points("b", np.zeros((1, 3)), -0.1), cl.Error, "radius"),
        (lambda w: w.add_voxels("b", np.zeros((1, 3)), -0.1), cl.Error, "edge"),
        (lambda w: w.add_sphere("b", 1, (0, 0)), ValueError, "position|shape"),
        (lambda w: w.add_sphere("b", 1, np.zeros((4, 4))), ValueError, "last row"),
        (lambda w: w.add_sphere("b", 1, np.diag([1, 1, -1, 1.0])), ValueError, "no rotation"),
        (lambda w: w.add_sphere("b", 1, np.diag([2, 1, 1, 1.0])), ValueError, "no rotation"),
        (lambda w: w.add_sphere("b", 1, ((0, 0, 0), (0, 0, 0, 2))), ValueError, "has length 2"),
        (lambda w: w.add_sphere("b", 1, (0, 0, np.inf)), ValueError, "must be finite"),
        (lambda w: w.add_sphere("b", 1, ((0, 0, 0), (0, 0, 0, np.nan))), ValueError, "the quaternion .* of pose must be finite"),
        (lambda w: w.move("ball", ((0, 0, 0), (np.inf, 0, 0, 0))), ValueError, "the quaternion .* of pose must be finite"),
        (lambda w: w.remove("none"), cl.Error, "no object 'none'"),
        (lambda w: w.move("none", (0, 0, 0)), cl.Error, "no object 'none'"),
        (lambda w: w.add_mesh_file("b", "/none.stl"), cl.Error, "none.stl"),
        (lambda w: cl.World.from_file("/none.yaml"), cl.Error, "none.yaml"),
    ],
)
def test_worlds(world, change, kind, words):
    changed = world.copy()
    with pytest.raises(kind, match=words):
        change(changed)
    assert changed.names == world.names


def held(checker):
    """The checker with the ball in the hand."""
    return checker.attach("ball", "hand", pose=(0, 0, 0.3), touch_links=["finger1", "finger2"])


@pytest.mark.parametrize(
    "call, kind, words",
    [
        (lambda c, h: c.distance(h, -1.0), cl.Error, "max_distance is -1"),
        (lambda c, h: c.clearance(h, np.nan), cl.Error, "influence_distance"),
        (lambda c, h: c.is_free(h, num_threads=0), cl.Error, "num_threads is 0, but must be None or a whole number from 1 to 1024"),
        (lambda c, h: c.is_free(h.tolist(), num_threads=-1), cl.Error, "num_threads is -1"),
        (lambda c, h: c.distance(h, num_threads=1025), cl.Error, "num_threads is 1025"),
        (lambda c, h: c.check(h, num_threads=10**30), cl.Error, "num_threads is 10"),
        (lambda c, h: c.clearance(h, 0.1, num_threads=0.5), TypeError, "num_threads is 0.5"),
        (lambda c, h: c.is_free(np.stack([h] * 20), num_threads=0), cl.Error, "num_threads is 0"),
        (lambda c, h: c.are_edges_free(h, h, num_threads=0), cl.Error, "num_threads is 0"),
        (lambda c, h: c.check_motion(h, np.stack([h])), cl.Error, "q1 must be one state"),
        (lambda c, h: c.check_motion(h, h * np.nan), cl.Error, "q1: joint"),
        (lambda c, h: c.attach("none", "hand", q=h), cl.Error, "no object 'none'"),
        (lambda c, h: c.attach("ball", "none", q=h), cl.Error, "no link 'none'"),
        (lambda c, h: c.attach("ball", "hand"), cl.Error, "either q"),
        (lambda c, h: c.detach("ball", h), cl.Error, "no object 'ball' is attached"),
        (lambda c, h: held(c).attach("ball", "link3", q=h), cl.Error, "object 'ball' is attached to link 'hand'.*detach it first"),
        (lambda c, h: c.attach("ball", "hand", q=h, touch_links="hand"), TypeError, "touch_links is 'hand', but must be a list of names"),
        (lambda c, h: c.find_free_state(h, locked="joint1"), TypeError, "locked is 'joint1', but must be a list of names"),
        (lambda c, h: c.robot.forward_kinematics(np.zeros(8), "hand"), TypeError, "links is 'hand', but must be a list of names"),
        (lambda c, h: c.robot.sphere_cover(counts=[1]), TypeError, r"counts is \[1\], but must be a dict"),
        (lambda c, h: c.robot.sphere_cover(counts={"hand": -1}), cl.Error, "counts is .*to whole numbers"),
        (lambda c, h: c.configuration([1.0]), TypeError, r"positions is \[1.0\], but must be a dict from names to numbers"),
        (lambda c, h: c.find_free_state(h, locked=["none"]), cl.Error, "no joint 'none'"),
        (lambda c, h: c.view(port=80000), cl.Error, "port is 80000, but must be a whole number from 0 to 65535"),
        (lambda c, h: c.view(port=-1), cl.Error, "port is -1, but must be a whole number from 0 to 65535"),
        (lambda c, h: c.find_free_state(h, clearance=-1.0), cl.Error, "clearance is -1, but must be"),
        (lambda c, h: c.are_edges_free(h, 1.0), ValueError, r"q1 has shape \(\), but it must be \(\.\.\., 7\)"),
        (lambda c, h: c.check_edges(h[:1], h), ValueError, r"q0 has shape \(1,\), but it must be \(\.\.\., 7\)"),
        (lambda c, h: c.check_edges(np.stack([h, h * np.nan]), h), cl.Error, r"q0 in row \[1\]: joint 'joint1'"),
        (lambda c, h: c.are_edges_free(h, [[h], [h * np.nan]]), cl.Error, r"q1 in row \[1, 0\]: joint 'joint1'"),
        (lambda c, h: c.configuration({"finger_joint1": 0.03}), cl.Error, "not in group 'arm'"),
        (lambda c, h: c.configuration({"none": 0.03}), cl.Error, "no joint 'none'"),
    ],
)
def test_calls(arm, home, call, kind, words):
    with pytest.raises(kind, match=words):
        call(arm, home)


LOST_MESH = """<robot name='r'><link name='a'><collision><geometry>
  <mesh filename='package://lost/a.stl'/></geometry></collision></link></robot>"""


@pytest.mark.parametrize(
    "arguments, kind, words",
    [
        (("/none.urdf",), cl.Error, "/none.urdf"),
        (("<robot name='r'><link name='a'/><link name='b'/></robot>",), cl.Error, "roots|parent"),
        (("<robot name='r'><link name='a'/></robot>", "<srdf/>"), cl.Error, None),
        ((3,), TypeError, "urdf must be a path or XML text"),
        ((URDF, None, "/tmp"), TypeError, "package_paths is '/tmp', but must be a list of paths"),
        ((LOST_MESH,), cl.Error, "package 'lost' was not found.*as DIR in package_paths, so that DIR/lost is the package"),
        (("",), cl.Error, "urdf is empty: give a path or XML text"),
        (("<robot name='r'><link name='a'/></robot>", " \n"), cl.Error, "srdf is empty: give a path or XML text"),
    ],
)
def test_robots(arguments, kind, words):
    with pytest.raises(kind, match=words):
        cl.Robot.from_urdf(*arguments)


@pytest.mark.parametrize("urdf", [URDF, "<robot name='r'><link name='a'/></robot>"])
def test_arguments_of_xacro_need_a_xacro_file(urdf):
    with pytest.raises(cl.Error, match="xacro_args are given, but neither urdf nor srdf is the path of a .xacro file"):
        cl.Robot.from_urdf(urdf, xacro_args={"tip": "a"})
    assert cl.Robot.from_urdf(urdf, xacro_args={}).name


MOTION = {"tolerance": "above zero", "timeout": "zero or more seconds", "budget": "whole number", "any_contact": "True or False", "margin": "zero or more"}
SEARCH = {"max_distance": "finite", "clearance": "finite", "timeout": "seconds", "max_checks": "whole number"}
ALONG = {"absolute_tolerance": "finite", "relative_tolerance": "finite", "max_distance": "metres", "timeout": "seconds", "budget": "whole"}
PLAN = {"range": "", "timeout": "seconds", "max_edges": "whole number", "shortcuts": "whole number", "seed": "whole number"}


@pytest.mark.parametrize("value, shown", [(np.nan, "nan"), (-1, "-1"), ("x", "'x'"), (10**400, "1000")])
def test_errors_of_options_name_option_and_value(arm, home, value, shown):
    calls = {
        "distance": ({"max_distance": "zero or more metres"}, lambda **o: arm.distance(home, **o)),
        "check": ({"max_distance": "zero or more metres", "max_contacts": "whole"}, lambda **o: arm.check(home, **o)),
        "check_motion": (MOTION, lambda **o: arm.check_motion(home, home, **o)),
        "clearance_along": (ALONG, lambda **o: arm.clearance_along(home, home, **o)),
        "clearance_along_trajectory": (ALONG, lambda **o: arm.clearance_along_trajectory(None, [home, home], **o)),
        "event_distance": ({"distance": "finite"}, lambda **o: arm.event_distance(home, home, **o)),
        "check_edges": (MOTION, lambda **o: arm.check_edges(home, home, **o)),
        "are_edges_free": (MOTION, lambda **o: arm.are_edges_free(home, home, **o)),
        "find_free_state": (SEARCH, lambda **o: arm.find_free_state(home, **o)),
        "plan": (PLAN, lambda **o: arm.plan(home, home, **o)),
        "Checker": ({"padding": ""}, lambda **o: cl.Checker(arm.robot, **o)),
        "random": ({"size": "whole number"}, lambda **o: arm.robot.random(**o)),
    }
    for name, (options, call) in calls.items():
        for option, form in options.items():
            with pytest.raises((cl.Error, TypeError), match=f"(?i){option}.*{shown}") as raised:
                call(**{option: value})
            assert form in str(raised.value) or value == 10**400, name


def test_a_fixed_mimic_joint_needs_a_fixed_leader(robot):
    with pytest.raises(cl.Error, match="fixed: joint 'm' mimics joint 's', whose position each query gives"):
        cl.Checker(cl.Robot.from_urdf(ALL_KINDS), fixed={"m": 0.5})
    with pytest.raises(cl.Error, match="fixed: joint 'finger_joint2' mimics joint 'finger_joint1'"):
        cl.Checker(robot, group="hand", fixed={"finger_joint2": 0.02})
    by_mimic = cl.Checker(robot, group="arm", fixed={"finger_joint2": 0.02})
    assert by_mimic.expand(np.zeros(7))[7] == 0.02


def test_a_checker_that_checks_nothing_warns(robot, world):
    with pytest.warns(cl.InputWarning, match="no pair of bodies to check") as warned:
        cl.Checker(robot, world, check_self=False, check_world=False)
    assert warned[0].filename == __file__
    blind = cl.Checker(robot, world, check_self=False)
    with pytest.warns(cl.InputWarning, match="no pair of bodies to check"):
        assert blind.with_world(cl.World()).is_free(np.zeros(8))


def test_the_module_for_ompl_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "ompl", None)
    monkeypatch.delitem(sys.modules, "clearance.ompl", raising=False)
    with pytest.raises(ImportError, match='clearance.ompl needs the Python package ompl: pip install "ompl>=2"'):
        importlib.import_module("clearance.ompl")


def test_errors_are_value_errors():
    assert issubclass(cl.Error, ValueError) and cl.Error.__module__ == "clearance"
