"""Tests of invalid joint states: missing, old, malformed or non-finite ones give UNKNOWN with a reason."""

from math import inf, isnan, nan, pi

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.duration import Duration
from rclpy.time import Time
from sensor_msgs.msg import JointState

import two_link
from cell import STALE_AFTER, Companions


def test_nothing_is_free_before_the_first_joint_state(start):
    cell = start(driving=False)
    companions = Companions(cell)

    state = cell.unknown("no_joint_state")
    assert "joint_states" in state.reason
    said = companions.of(state)
    assert said["is_free"] is False
    assert isnan(said["distance"])


def test_silence_becomes_stale_and_the_heartbeat_goes_on(cell):
    companions = Companions(cell)
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.grows_old()
    cell.driver.pause()

    first = cell.unknown("stale")
    assert first.age > STALE_AFTER
    assert first.reason
    assert not first.distance_known

    heartbeats = cell.states.more(10, after=first)
    assert {state.reason_code for state in heartbeats} == {"stale"}
    assert heartbeats[-1].age > first.age
    assert not any(companions.of(state)["is_free"] for state in heartbeats)

    cell.driver.resume()
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE


def test_a_missing_joint_is_named(cell):
    cell.driver.report(joint1=0)
    state = cell.unknown("partial")
    assert "joint2" in state.reason
    assert "joint1" not in state.reason
    assert not state.distance_known


def test_a_joint_that_was_there_before_is_missed_when_its_last_word_is_old(cell):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.grows_old()
    cell.driver.report(joint1=0)
    state = cell.unknown("stale")
    assert "'joint2'" in state.reason
    assert "'joint1'" not in state.reason
    assert state.age > STALE_AFTER


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_a_position_that_is_no_number_is_named(cell, value):
    state = cell.evaluate(joint1=0, joint2=value)
    assert (state.status, state.reason_code) == (CollisionState.UNKNOWN, "non_finite")
    assert "joint2" in state.reason

    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE


def test_unknown_joints_are_ignored_with_a_warning(cell):
    state = cell.evaluate(joint1=0, joint2=pi, gripper=0.3)
    assert state.status == CollisionState.COLLIDING
    assert len(state.warnings) == 1
    assert "gripper" in state.warnings[0]

    assert cell.evaluate(joint1=0, joint2=0).warnings == []


def test_fewer_positions_than_names_are_malformed(cell):
    publisher = cell.peer.node.create_publisher(JointState, cell.node.relative("joint_states"), 10)
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE

    def rejected():
        message = JointState(name=["joint1", "joint2"], position=[0.0])
        message.header.stamp = cell.peer.now().to_msg()
        publisher.publish(message)
        return next((state for state in cell.states.all() if state.reason_code == "malformed"), None)

    state = cell.peer.wait_for(rejected, "UNKNOWN for a joint state that is cut short")
    assert state.status == CollisionState.UNKNOWN
    assert "2 names and 1 positions" in state.reason


def test_a_stamp_far_in_the_future_is_not_trusted(cell):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.grows_old()
    cell.driver.pause()

    def rejected():
        cell.driver.publish({"joint1": 0, "joint2": 0}, cell.peer.now() + Duration(seconds=10))
        return next((state for state in cell.states.all() if state.reason_code == "future_stamp"), None)

    assert cell.peer.wait_for(rejected, "UNKNOWN for a stamp in the future").status == CollisionState.UNKNOWN

    cell.driver.resume()
    cell.becomes(CollisionState.FREE, "FREE once more")


def test_a_joint_state_without_a_stamp_is_evaluated_with_a_warning(start):
    cell = start(driving=False)

    def evaluate():
        cell.driver.publish({"joint1": 0, "joint2": 0}, Time())
        return next((state for state in cell.states.all() if state.status == CollisionState.FREE), None)

    state = cell.peer.wait_for(evaluate, "a judgement")
    assert any("stamp" in warning for warning in state.warnings)


def test_a_stamp_before_the_last_one_is_out_of_order(cell):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.driver.pause()
    stamp = cell.peer.now() - Duration(seconds=0.2)

    def rejected():
        cell.driver.publish({"joint1": 0, "joint2": 0}, stamp)
        return next((state for state in cell.states.all() if state.reason_code == "out_of_order"), None)

    state = cell.peer.wait_for(rejected, "UNKNOWN for a stamp out of order")
    assert state.status == CollisionState.UNKNOWN

    cell.driver.resume()
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE


def test_a_joint_state_that_arrives_old_is_stale(cell):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.grows_old()
    last = cell.falls_silent()
    stamp = cell.peer.now()
    cell.states.wait_for(lambda state: state.age > STALE_AFTER + 0.1, "silence that began before that stamp", after=last)
    assert cell.evaluated({"joint1": 0, "joint2": 0}, stamp).status == CollisionState.UNKNOWN
    assert all(
        state.status == CollisionState.UNKNOWN for state in cell.states.all() if two_link.evaluated_of(stamp)(state)
    )


def test_velocities_without_positions_are_skipped_with_a_warning(cell):
    """The positions of before stay in force, and grow old."""
    publisher = cell.peer.node.create_publisher(JointState, cell.node.relative("joint_states"), 10)
    before = cell.evaluate(joint1=0, joint2=0)
    cell.driver.pause()

    def publish():
        message = JointState(name=["joint1", "joint2"], velocity=[1.0, 1.0])
        message.header.stamp = cell.peer.now().to_msg()
        publisher.publish(message)
        return next((s for s in cell.states.all() if any("gives no positions" in text for text in s.warnings)), None)

    state = cell.peer.wait_for(publish, "a warning")
    assert state.status == CollisionState.FREE
    assert state.header.stamp.sec >= before.header.stamp.sec
    cell.grows_old()
    start = cell.peer.now()

    def is_stale():
        publish()
        return any(state.reason_code == "stale" for state in cell.states.after(start))

    cell.peer.wait_for(is_stale, "UNKNOWN, for velocities tell no position")
