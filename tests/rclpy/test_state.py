"""`~/state`, `~/is_free` and `~/distance` against answers worked out by hand."""

from math import pi

import pytest
from clearance_msgs.msg import BodyPair, CollisionState
from rclpy.time import Time
from std_msgs.msg import Bool, Float64

import two_link
from cell import Cell

ACCURACY = 1e-9  # [m] the answers are exact but for rounding; GJK on curved primitives comes this near


@pytest.fixture(scope="module")
def cell(module_peer):
    """One node answers for the whole module: every question here leaves it as it was."""
    with Cell(module_peer, parameters={"influence_distance": 0.5, "distance_limit": 2.0}) as cell:
        cell.is_free = module_peer.record(Bool, cell.node.private("is_free"))
        cell.distance = module_peer.record(Float64, cell.node.private("distance"))
        yield cell


def links(pair):
    assert (pair.type_a, pair.type_b) == (BodyPair.LINK, BodyPair.LINK)
    return {pair.body_a, pair.body_b}


def witness_points(pair_distance):
    """By the name of the body that each lies on."""
    on_a, on_b = ((point.x, point.y, point.z) for point in pair_distance.witness_points)
    return {pair_distance.pair.body_a: on_a, pair_distance.pair.body_b: on_b}


def stamp_of(message):
    return Time.from_msg(message.header.stamp).nanoseconds


@pytest.mark.parametrize("answer", two_link.FREE, ids=str)
def test_a_free_state_has_its_distance_pair_and_witness_points(cell, answer):
    state = cell.judged(joint1=answer.joint1, joint2=answer.joint2)

    assert state.status == CollisionState.FREE
    assert state.colliding_pairs == []
    assert state.distance_known
    assert state.nearest.distance == pytest.approx(answer.distance, abs=ACCURACY)
    assert links(state.nearest.pair) == {"base", "tip"}
    # Where the distance is flat to first order, points are known to the square root of the distance's accuracy.
    witnesses = witness_points(state.nearest)
    assert witnesses["base"] == pytest.approx((*answer.on_base, 0), abs=1e-4)
    assert witnesses["tip"] == pytest.approx((*answer.on_tip, 0), abs=1e-4)


@pytest.mark.parametrize(("joint1", "joint2"), two_link.COLLIDING)
def test_a_colliding_state_names_the_pair(cell, joint1, joint2):
    state = cell.judged(joint1=joint1, joint2=joint2)

    assert state.status == CollisionState.COLLIDING
    assert [links(pair) for pair in state.colliding_pairs] == [{"base", "tip"}]
    assert state.distance_known
    assert state.nearest.distance == 0
    assert links(state.nearest.pair) == {"base", "tip"}


def test_the_status_changes_where_the_ball_reaches_the_cube(cell):
    before = cell.judged(joint1=0, joint2=two_link.FIRST_TOUCH - 1e-6)
    after = cell.judged(joint1=0, joint2=two_link.FIRST_TOUCH + 1e-6)

    assert before.status == CollisionState.FREE
    assert 0 < before.nearest.distance < 2e-6
    assert after.status == CollisionState.COLLIDING


def test_pair_distances_are_those_within_the_influence_distance(cell):
    near = cell.judged(joint1=0, joint2=5 * pi / 6)
    far = cell.judged(joint1=0, joint2=0)

    assert [pair.distance for pair in near.pair_distances] == [pytest.approx(0.2, abs=ACCURACY)]
    assert near.pair_distances[0].pair == near.nearest.pair
    assert far.pair_distances == []
    assert far.nearest.distance == pytest.approx(0.7, abs=ACCURACY)


def test_a_state_says_what_was_judged_and_how(cell):
    state = cell.judged(joint1=0, joint2=0)

    assert state.header.frame_id == "base"
    assert state.reason == state.reason_code == ""
    assert state.warnings == []
    assert state.model_revision == 1
    assert state.pairs_checked == 1
    # base - upper and upper - tip are adjacent.
    assert state.pairs_skipped == sum(skipped.count for skipped in state.skipped) == 2
    assert all(skipped.reason for skipped in state.skipped)
    assert state.age >= 0
    assert 0 < state.compute_time < 1
    assert state.fidelity == "mesh"


def test_the_stamp_is_that_of_the_judged_joint_state(cell):
    cell.judged(joint1=0, joint2=0)
    cell.driver.pause()
    stamp = cell.peer.now()

    def judged():
        cell.driver.publish({"joint1": 0, "joint2": pi}, stamp)
        return next((state for state in cell.states.messages if stamp_of(state) == stamp.nanoseconds), None)

    judgement = cell.peer.wait_for(judged, f"a judgement of the joint state stamped {stamp}")
    cell.driver.resume()
    assert judgement.status == CollisionState.COLLIDING


def test_every_joint_state_is_judged_that_comes_when_the_last_one_is(cell):
    """Those that come faster are merged, and counted in the diagnostics."""
    cell.judged(joint1=0, joint2=0)
    cell.driver.pause()
    for number in range(50):
        stamp = cell.peer.now()
        cell.driver.publish({"joint1": 0, "joint2": 0.01 * number}, stamp)
        cell.states.wait_for(lambda state: stamp_of(state) == stamp.nanoseconds, f"a judgement of joint state {number}")
    cell.driver.resume()


def test_the_standard_types_say_the_same(cell):
    cell.judged(joint1=0, joint2=0)
    assert cell.is_free.next().data is True
    assert cell.distance.next().data == pytest.approx(0.7, abs=ACCURACY)

    cell.judged(joint1=0, joint2=pi)
    cell.is_free.wait_for(lambda message: not message.data, "false", after=len(cell.is_free.messages))
    cell.distance.wait_for(lambda message: message.data == 0, "0", after=len(cell.distance.messages))
