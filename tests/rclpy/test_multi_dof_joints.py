"""Tests of planar joints in the `multi_dof_joint_state` of `check_state_validity`."""

from math import cos, pi, sin

import pytest
from geometry_msgs.msg import Transform
from moveit_msgs.srv import GetStateValidity

from cell import Cell
from scene import ball
from scene_client import SceneClient

URDF = "tests/rclpy/rover.urdf"  # the joint frame of `drive` is at (1, 0, 0); the ball of 0.1 is `lift` before the base


@pytest.fixture(scope="module")
def cell(module_peer):
    with Cell(module_peer, urdf=URDF) as cell:
        cell.scene = SceneClient(cell)
        cell.evaluate(**{"drive/x": 0, "drive/y": 0, "drive/theta": 0, "lift": 0})
        cell.scene.change(ball("pillar", 3.0, frame="odom"))
        yield cell


def request(name="drive", x=0.0, y=0.0, z=0.0, turn=0.0, frame="", joints=None):
    transform = Transform()
    transform.translation.x, transform.translation.y, transform.translation.z = float(x), float(y), float(z)
    transform.rotation.z, transform.rotation.w = sin(turn / 2), cos(turn / 2)
    message = GetStateValidity.Request()
    message.robot_state.is_diff = True
    message.robot_state.joint_state.name = list(joints or {})
    message.robot_state.joint_state.position = [float(position) for position in (joints or {}).values()]
    message.robot_state.multi_dof_joint_state.header.frame_id = frame
    message.robot_state.multi_dof_joint_state.joint_names = [name]
    message.robot_state.multi_dof_joint_state.transforms = [transform]
    return message


def valid(cell, **of):
    return cell.scene.call(GetStateValidity, "check_state_validity", request(**of)).valid


def test_a_planar_joint_is_where_its_transform_has_it(cell):
    assert valid(cell) and valid(cell, frame="odom")
    assert not valid(cell, x=2), "in the pillar"
    assert valid(cell, x=2, y=1)
    assert not valid(cell, x=2, y=1, turn=-pi / 2, joints={"lift": 1}), "the ball before it is in the pillar"
    assert valid(cell, x=2, y=1, turn=pi / 2, joints={"lift": 1})
    assert not valid(cell, x=-2), "in the wall"


@pytest.mark.parametrize(
    "of, named",
    [
        ({"x": 1, "z": 0.1}, ("'drive'", "plane")),
        ({"name": "lift"}, ("'lift'", "neither planar nor floating")),
        ({"name": "wheel"}, ("'wheel'", "drive")),
        ({"frame": "map"}, ("frame_id", "'map'")),
        ({"joints": {"drive/x": 0}}, ("'drive/x' is given twice",)),
    ],
)
def test_what_the_joint_can_not_make_is_not_valid(cell, of, named):
    cell.scene.complaints.forget()
    assert not valid(cell, **of)
    cell.scene.complaints.wait_for("check_state_validity", *named)
