"""Tests of robots: names, limits, forward kinematics, random states, xacro."""

import sys
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import clearance as cl
from conftest import ALL_KINDS, URDF


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = axis = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.cos(angle) * np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * np.outer(axis, axis)


def numbers(element, name, default="0 0 0"):
    return np.array([float(x) for x in (default if element is None else element.get(name, default)).split()])


def kinematics(urdf, q):
    """Poses of all links, from the URDF alone; `q` is a dict by joint."""
    joints = ET.parse(urdf).getroot().findall("joint")
    children = {joint.find("child").get("link") for joint in joints}
    root = next(j.find("parent").get("link") for j in joints if j.find("parent").get("link") not in children)
    poses, waiting = {root: np.eye(4)}, list(joints)
    while waiting:
        joint = next(j for j in waiting if j.find("parent").get("link") in poses)
        waiting.remove(joint)
        origin, moved, axis = np.eye(4), np.eye(4), numbers(joint.find("axis"), "xyz", "1 0 0")
        roll, pitch, yaw = numbers(joint.find("origin"), "rpy")
        origin[:3, :3] = rotation([0, 0, 1], yaw) @ rotation([0, 1, 0], pitch) @ rotation([1, 0, 0], roll)
        origin[:3, 3] = numbers(joint.find("origin"), "xyz")
        mimic = joint.find("mimic")
        if mimic is not None:
            value = float(mimic.get("multiplier", 1)) * q[mimic.get("joint")] + float(mimic.get("offset", 0))
        else:
            value = q.get(joint.get("name"), 0.0)
        if joint.get("type") in ("revolute", "continuous"):
            moved[:3, :3] = rotation(axis, value)
        elif joint.get("type") == "prismatic":
            moved[:3, 3] = axis / np.linalg.norm(axis) * value
        poses[joint.find("child").get("link")] = poses[joint.find("parent").get("link")] @ origin @ moved
    return poses


def test_names_and_limits(robot):
    assert robot.name == "demo_arm" and robot.root_link == "base"
    assert robot.joint_names == [f"joint{i}" for i in range(1, 8)] + ["finger_joint1"]
    assert len(robot.link_names) == 12 and robot.lower.shape == robot.upper.shape == (8,)
    assert robot.lower.dtype == np.float64 and (robot.lower < robot.upper).all()
    assert robot.groups == {"arm": robot.joint_names[:7], "hand": ["finger_joint1"]}
    assert robot.group_states["open"] == {"finger_joint1": 0.04}
    assert robot.warnings == []


def test_every_kind_of_joint():
    robot = cl.Robot.from_urdf(ALL_KINDS)
    parts = ["trans_x", "trans_y", "trans_z", "rot_x", "rot_y", "rot_z", "rot_w"]
    assert robot.joint_names == ["t", "s", *(f"f/{part}" for part in parts), "p/x", "p/y", "p/theta"]
    assert list(robot.lower) == [-np.inf, 1] + [-np.inf] * 10 and robot.upper[1] == 3
    assert robot.joint_types == {"t": "continuous", "s": "prismatic", "m": "prismatic", "f": "floating", "p": "planar"}
    assert robot.mimics == {"m": ("s", -2.0, 0.5)}
    q = robot.configuration({"t": 0.3, "s": 2.0, "f/trans_y": 4.0, "p/theta": 0.5})
    poses = robot.forward_kinematics(q)
    assert np.allclose(poses["turn"][:3, :3], rotation([0, 0, 1], 0.3))
    assert np.allclose(poses["finger"][:3, 3], [2, -2 * 2 + 0.5, 0])
    assert np.allclose(poses["fly"][:3, 3], [0, 4, 0])
    # by its mimic joint
    assert np.array_equal(robot.configuration({"m": -3.5, "t": 0.3, "f/trans_y": 4.0, "p/theta": 0.5}), q)
    with pytest.warns(cl.InputWarning, match="no pair"):
        assert cl.Checker(robot).is_free(q)


def test_forward_kinematics_is_that_of_the_urdf(robot, states):
    found = robot.forward_kinematics(states[:20].reshape(4, 5, 8))
    assert list(found) == robot.link_names
    for i, q in enumerate(states[:20]):
        for link, pose in kinematics(URDF, dict(zip(robot.joint_names, q))).items():
            assert np.allclose(found[link][i // 5, i % 5], pose, atol=1e-12), link
            assert np.array_equal(robot.forward_kinematics(q)[link], found[link][i // 5, i % 5])
    assert robot.forward_kinematics(states[0], links=["hand"]).keys() == {"hand"}
    assert robot.forward_kinematics(np.zeros((0, 8)))["hand"].shape == (0, 4, 4)


def test_random_states(robot):
    q = robot.random(3, 500)
    assert q.shape == (500, 8) and robot.random(3).shape == (8,)
    assert ((robot.lower <= q) & (q <= robot.upper)).all()
    assert np.array_equal(q, robot.random(np.random.default_rng(3), 500))
    generator = np.random.default_rng(3)
    assert not np.array_equal(robot.random(generator), robot.random(generator))
    # they fill the range
    assert (np.ptp(q, axis=0) > 0.95 * (robot.upper - robot.lower)).all()
    with pytest.raises(TypeError, match="rng must be"):
        robot.random("seed")


# warnings of the foreign package are not ours
@pytest.mark.filterwarnings("default")
def test_xacro(tmp_path, monkeypatch):
    pytest.importorskip("xacro", exc_type=ImportError)
    plain = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="tip" default="a"/>' \
        '<link name="$(arg tip)"/></robot>'
    (tmp_path / "r.urdf.xacro").write_text(plain)
    assert cl.Robot.from_urdf(tmp_path / "r.urdf.xacro").link_names == ["a"]
    assert cl.Robot.from_urdf(tmp_path / "r.urdf.xacro", xacro_args={"tip": "b"}).link_names == ["b"]
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(ImportError, match="pip install xacro"):
        cl.Robot.from_urdf(tmp_path / "r.urdf.xacro")
    monkeypatch.undo()
    (tmp_path / "bad.xacro").write_text("<robot")
    with pytest.raises(cl.Error, match="bad.xacro: xacro"):
        cl.Robot.from_urdf(tmp_path / "bad.xacro")


def test_unusual_input_warns():
    with pytest.warns(cl.InputWarning, match="group 'none'"):
        robot = cl.Robot.from_urdf(
            '<robot name="r"><link name="a"/></robot>',
            '<robot name="r"><group_state name="s" group="none"/></robot>',
        )
    assert len(robot.warnings) == 1 and robot.group_states == {}


def test_states_of_one_name_are_distinguished():
    urdf = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
      <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
      <joint name="k" type="continuous"><parent link="a"/><child link="c"/></joint></robot>"""
    state = '<group name="{0}"><joint name="{1}"/></group><group_state name="up" group="{0}"><joint name="{1}" value="1"/></group_state>'
    srdf = f'<robot name="r">{state.format("left", "j")}{state.format("right", "k")}</robot>'
    robot = cl.Robot.from_urdf(urdf, srdf)
    assert robot.group_states == {"left/up": {"j": 1.0}, "right/up": {"k": 1.0}}
