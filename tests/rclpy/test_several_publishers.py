"""Tests of several drivers that share the topic joint_states, as an arm and its gripper do."""

from contextlib import contextmanager
from math import pi

import pytest
from clearance_msgs.msg import CollisionState
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.duration import Duration

import two_link
from cell import STALE_AFTER


@contextmanager
def driver(cell, **positions):
    """One more driver on the topic, of these joints alone."""
    other = two_link.Driver(cell.peer, cell.node.relative("joint_states"))
    other.report(**positions)
    yield other
    other.disconnect()


@pytest.fixture
def shoulder(cell):
    """A cell whose driver knows joint1 alone."""
    cell.driver.report(joint1=0.0)
    cell.unknown("partial")
    return cell


def test_two_drivers_make_one_robot(shoulder):
    with driver(shoulder, joint2=0.0) as elbow:
        state = shoulder.becomes(CollisionState.FREE, "FREE from two drivers")
        assert state.nearest.distance == pytest.approx(0.7)
        elbow.report(joint2=pi)
        shoulder.becomes(CollisionState.COLLIDING, "a collision that the elbow's driver reports")
        shoulder.driver.report(joint1=1.0)
        elbow.report(joint2=0.0)
        shoulder.becomes(CollisionState.FREE, "FREE")


def test_a_driver_that_falls_silent_is_missed_by_the_names_of_its_joints(shoulder):
    with driver(shoulder, joint2=0.0) as elbow:
        shoulder.becomes(CollisionState.FREE, "FREE from two drivers")
        shoulder.grows_old()
        elbow.pause()
        state = shoulder.unknown("stale")
        assert "'joint2'" in state.reason
        assert "joint1" not in state.reason
        assert state.age > STALE_AFTER
        elbow.resume()
        shoulder.becomes(CollisionState.FREE, "FREE once more")


def test_a_driver_that_starts_anew_takes_its_place(shoulder):
    with driver(shoulder, joint2=0.0):
        shoulder.becomes(CollisionState.FREE, "FREE from two drivers")
    shoulder.grows_old()
    shoulder.unknown("stale")
    with driver(shoulder, joint2=pi):
        shoulder.becomes(CollisionState.COLLIDING, "the new driver's answer")


def test_the_gripper_of_another_robot_makes_nothing_partial(cell):
    diagnostics = cell.peer.record(DiagnosticArray, "/diagnostics")
    cell.evaluate(joint1=0, joint2=0)
    with driver(cell, left_finger=0.02, right_finger=0.02):
        state = cell.states.ever(lambda state: state.warnings, "a warning")
        assert "'left_finger' and 'right_finger'" in state.warnings[0]
        assert {later.status for later in cell.states.more(50, after=state)} == {CollisionState.FREE}
        diagnostics.ever(
            lambda array: any(status.level == DiagnosticStatus.WARN for status in array.status), "a warning"
        )
    cell.grows_old()
    cell.states.wait_for(lambda state: not state.warnings, "no warning", after=cell.peer.now())


def test_messages_of_one_publisher_about_other_joints_have_an_order_of_their_own(shoulder):
    """As a played bag brings them: what the elbow said is stamped a little earlier than what the shoulder said before."""
    shoulder.driver.pause()
    publish = shoulder.driver.publish

    def played():
        now = shoulder.peer.now()
        publish({"joint1": 0.0}, now)
        publish({"joint2": 0.0}, now - Duration(seconds=0.01))
        return any(state.status == CollisionState.FREE for state in shoulder.states.all())

    shoulder.peer.wait_for(played, "FREE")
    assert all(state.reason_code != "out_of_order" for state in shoulder.states.all())
