"""Tests of several robots, each with a node: every node evaluates its own robot only."""

from math import pi

import pytest
from clearance_msgs.msg import CollisionState
from std_msgs.msg import String
from std_srvs.srv import SetBool

import two_link

FREE, COLLIDING, UNKNOWN = CollisionState.FREE, CollisionState.COLLIDING, CollisionState.UNKNOWN


@pytest.fixture
def arms(peer, start):
    """Two nodes of the same name, each in its robot's namespace, with the robot's own description."""
    cells = []
    for side, text in (("left", two_link.description()), ("right", two_link.description_with_cube(0.8))):
        peer.latch(String(data=text), f"/{side}/robot_description")
        cells.append(start(urdf=None, name="clearance", namespace=f"/{side}"))
    for cell in cells:
        cell.has_model()
    return cells


def settles(cell, status):
    """The first state that says so, when ten have come since."""
    state = cell.becomes(status, f"status {status}")
    assert {later.status for later in cell.states.more(10, after=state)} == {status}
    return state


def test_each_evaluates_its_own_robot(arms):
    left, right = arms
    assert left.evaluate(joint1=0, joint2=0).nearest.distance == pytest.approx(0.7)
    first = right.evaluate(joint1=0, joint2=0)
    assert first.nearest.distance == pytest.approx(0.5)

    assert left.evaluate(joint1=0, joint2=pi).status == COLLIDING
    settles(right, FREE)
    assert {state.status for state in right.states.after(first)} == {FREE}


def test_what_befalls_one_leaves_the_other_alone(arms):
    left, right = arms
    assert left.evaluate(joint1=0, joint2=0).status == FREE
    first = right.evaluate(joint1=0, joint2=0)
    assert first.status == FREE

    left.grows_old()
    left.driver.pause()
    left.unknown("stale")
    left.parameters.succeed(padding=0.5, stale_after=0.5)
    left.driver.resume()
    client = left.peer.node.create_client(SetBool, left.node.private("enable"))
    left.peer.wait_for(client.service_is_ready, "~/enable")
    assert left.peer.result(client.call_async(SetBool.Request(data=False))).success
    left.unknown("disabled")
    left.node.stop()

    settles(right, FREE)
    assert {state.status for state in right.states.after(first)} == {FREE}
    assert right.parameters.get("padding") == [0.0]


@pytest.fixture
def twins(peer, start):
    """Two nodes on the same topics, told apart by the prefixes of their robots' names."""
    driver = two_link.Driver(peer, "/hall/joint_states")
    driver.report(left_joint1=0.0, left_joint2=0.0, right_joint1=0.0, right_joint2=pi)
    peer.latch(String(data=two_link.description()), "/hall/robot_description")
    cells = [
        start(
            urdf=None,
            driving=False,
            name=side,
            namespace="/hall",
            parameters={"joint_prefix": f"{side}_", "link_prefix": f"{side}/", "influence_distance": 1.0},
        )
        for side in ("left", "right")
    ]
    yield driver, *cells
    driver.disconnect()


def test_equal_robots_on_the_same_topics_are_distinguished_by_their_names(twins):
    driver, left, right = twins
    state = settles(left, FREE)
    assert state.header.frame_id == "left/base"
    assert {state.nearest.pair.body_a, state.nearest.pair.body_b} == {"left/base", "left/tip"}
    assert state.warnings == []
    (pair,) = settles(right, COLLIDING).colliding_pairs
    assert {pair.body_a, pair.body_b} == {"right/base", "right/tip"}

    right.grows_old()
    driver.report(left_joint1=0.0, left_joint2=0.0, left_gripper=0.0)
    right.unknown("stale")
    state = left.states.ever(lambda state: state.warnings, "a warning")
    assert "'left_gripper'" in state.warnings[0]


def test_a_prefix_that_changes_makes_another_robot(twins):
    _, left, right = twins
    settles(left, FREE)
    settles(right, COLLIDING)
    left.parameters.succeed(joint_prefix="right_")
    left.has_model(2)
    settles(left, COLLIDING)


def test_nodes_that_start_at_once_are_all_met(start):
    cells = [start() for _ in range(4)]
    for cell in cells:
        assert cell.evaluate(joint1=0, joint2=0).status == FREE
