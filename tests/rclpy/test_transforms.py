"""Tests of a mobile base whose pose comes from `tf` instead of joint states."""

from math import cos, pi, sin

import pytest
from clearance_msgs.msg import CollisionState
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

ROVER = "tests/rclpy/rover.urdf"
TTL = 1.0  # [s]


class Localization:
    """Publishes where the base is, 50 times a second."""

    def __init__(self, cell):
        self._peer = cell.peer
        self._publisher = cell.peer.node.create_publisher(TFMessage, cell.node.relative("tf"), 10)
        self._place = None
        self._timer = cell.peer.node.create_timer(0.02, self._tick)

    def _tick(self):
        if self._place is None:
            return
        x, y, z, theta = self._place
        message = TransformStamped(child_frame_id="base")
        message.header.frame_id = "odom"
        message.header.stamp = self._peer.now().to_msg()
        shift, turn = message.transform.translation, message.transform.rotation
        shift.x, shift.y, shift.z = x, y, z
        turn.z, turn.w = sin(theta / 2), cos(theta / 2)
        self._publisher.publish(TFMessage(transforms=[message]))

    def send(self, x, y=0.0, z=0.0, theta=0.0):
        self._place = x, y, z, theta

    def fall_silent(self):
        self._place = None


@pytest.fixture
def rover(start):
    parameters = {"transform_joints": ["drive"], "transform_ttl": TTL, "distance_limit": 20.0}
    cell = start(urdf=ROVER, parameters=parameters)
    cell.driver.report(lift=0.5)
    return cell


def free_at(cell, distance):
    return cell.states.wait_for(
        lambda state: state.status == CollisionState.FREE and state.nearest.distance == pytest.approx(distance, abs=1e-9),
        f"FREE with a distance of {distance}",
        after=cell.peer.now(),
    )


def test_the_base_stands_where_tf_places_it(rover):
    localization = Localization(rover)
    reason = rover.unknown("no_transform").reason
    assert "'drive'" in reason
    assert "from 'odom' to 'base'" in reason

    # the wall's face is at x = -1, and the ball 0.5 before the base
    localization.send(2.0, 3.0)
    free_at(rover, 2.0 + 0.5 - 0.1 + 1.0)
    localization.send(2.0, theta=pi)
    free_at(rover, 2.0 - 0.5 - 0.1 + 1.0)
    localization.send(-0.45, theta=pi)
    rover.becomes(CollisionState.COLLIDING, "a collision with the wall")


def test_a_localization_that_falls_silent_or_leaves_the_plane_is_named(rover):
    localization = Localization(rover)
    localization.send(2.0)
    free_at(rover, 3.4)
    localization.fall_silent()
    reason = rover.unknown("no_transform").reason
    assert "s old, and transform_ttl is 1 s" in reason

    localization.send(2.0)
    free_at(rover, 3.4)
    localization.send(2.0, z=0.1)
    reason = rover.unknown("no_transform").reason
    assert "leaves the joint's plane by 0.1000" in reason


def test_by_default_joint_states_decide(start):
    cell = start(urdf=ROVER, parameters={"distance_limit": 20.0})
    Localization(cell).send(9.0)
    cell.driver.report(lift=0.0)
    assert "'drive/x', 'drive/y' and 'drive/theta'" in cell.unknown("partial").reason
    # in the joint's frame, which is at x = 1
    cell.driver.report(**{"lift": 0.0, "drive/x": 1.0, "drive/y": 0.0, "drive/theta": 0.0})
    free_at(cell, 1.0 + 1.0 - 0.1 + 1.0)
    cell.parameters.succeed(transform_joints=["drive"])
    free_at(cell, 9.0 - 0.1 + 1.0)
    cell.parameters.succeed(transform_joints=["nothing"])
    state = free_at(cell, 2.9)
    assert any("transform_joints names 'nothing'" in warning for warning in state.warnings)
