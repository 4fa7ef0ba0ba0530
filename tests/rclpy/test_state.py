"""Tests of `~/state`, `~/is_free` and `~/distance` against hand-computed results."""

from math import isnan, nan, pi

import pytest
from clearance_msgs.msg import BodyPair, CollisionState

import two_link
from cell import Cell, Companions

ACCURACY = 1e-9  # [m] the answers are exact but for rounding; GJK on curved primitives comes this near


@pytest.fixture(scope="module")
def cell(module_peer):
    """One node answers for the whole module: every question here leaves it as it was."""
    with Cell(module_peer, parameters={"influence_distance": 0.5, "distance_limit": 2.0}) as cell:
        yield cell


def links(pair):
    assert (pair.type_a, pair.type_b) == (BodyPair.LINK, BodyPair.LINK)
    return {pair.body_a, pair.body_b}


def witness_points(pair_distance):
    """By the name of the body that each lies on."""
    on_a, on_b = ((point.x, point.y, point.z) for point in pair_distance.witness_points)
    return {pair_distance.pair.body_a: on_a, pair_distance.pair.body_b: on_b}


@pytest.mark.parametrize("response", two_link.FREE, ids=str)
def test_a_free_state_has_its_distance_pair_and_witness_points(cell, response):
    state = cell.evaluate(joint1=response.joint1, joint2=response.joint2)

    assert state.status == CollisionState.FREE
    assert state.colliding_pairs == []
    assert state.distance_known
    assert state.nearest.distance == pytest.approx(response.distance, abs=ACCURACY)
    assert links(state.nearest.pair) == {"base", "tip"}
    # Where the distance is flat to first order, points are known to the square root of the distance's accuracy.
    witnesses = witness_points(state.nearest)
    assert witnesses["base"] == pytest.approx((*response.on_base, 0), abs=1e-4)
    assert witnesses["tip"] == pytest.approx((*response.on_tip, 0), abs=1e-4)


@pytest.mark.parametrize(("joint1", "joint2"), two_link.COLLIDING)
def test_a_colliding_state_names_the_pair(cell, joint1, joint2):
    state = cell.evaluate(joint1=joint1, joint2=joint2)

    assert state.status == CollisionState.COLLIDING
    assert [links(pair) for pair in state.colliding_pairs] == [{"base", "tip"}]
    assert state.distance_known
    assert state.nearest.distance == 0
    assert links(state.nearest.pair) == {"base", "tip"}


def test_the_status_changes_where_the_ball_reaches_the_cube(cell):
    before = cell.evaluate(joint1=0, joint2=two_link.FIRST_TOUCH - 1e-6)
    after = cell.evaluate(joint1=0, joint2=two_link.FIRST_TOUCH + 1e-6)

    assert before.status == CollisionState.FREE
    assert 0 < before.nearest.distance < 2e-6
    assert after.status == CollisionState.COLLIDING


def test_pair_distances_are_those_within_the_influence_distance(cell):
    near = cell.evaluate(joint1=0, joint2=5 * pi / 6)
    far = cell.evaluate(joint1=0, joint2=0)

    assert [pair.distance for pair in near.pair_distances] == [pytest.approx(0.2, abs=ACCURACY)]
    assert near.pair_distances[0].pair == near.nearest.pair
    assert far.pair_distances == []
    assert far.nearest.distance == pytest.approx(0.7, abs=ACCURACY)


def test_a_state_says_what_was_evaluated_and_how(cell):
    state = cell.evaluate(joint1=0, joint2=0)

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


def test_the_stamp_is_that_of_the_evaluated_joint_state(cell):
    cell.evaluate(joint1=0, joint2=0)
    state = cell.evaluated({"joint1": 0, "joint2": pi})
    cell.driver.resume()
    assert state.status == CollisionState.COLLIDING


def test_every_joint_state_is_evaluated_that_comes_when_the_last_one_is(cell):
    """Those that come faster are merged, and counted in the diagnostics."""
    cell.evaluate(joint1=0, joint2=0)
    cell.driver.pause()
    for number in range(50):
        stamp = cell.peer.now()
        cell.driver.publish({"joint1": 0, "joint2": 0.01 * number}, stamp)
        cell.states.ever(two_link.evaluated_of(stamp), f"a state of joint state {number}")
    cell.driver.resume()


def test_the_standard_types_say_the_same(cell):
    """With every state, whatever it is: FREE, COLLIDING or UNKNOWN."""
    companions = Companions(cell)
    first = cell.evaluate(joint1=0, joint2=0)
    for joint2 in (pi, 5 * pi / 6, nan, 0):
        cell.evaluate(joint1=0, joint2=joint2)

    states = [first, *cell.states.after(first)]
    assert {state.status for state in states} == {CollisionState.FREE, CollisionState.COLLIDING, CollisionState.UNKNOWN}
    for state in states:
        said = companions.of(state)
        assert said["is_free"] == (state.status == CollisionState.FREE)
        assert state.distance_known != isnan(said["distance"])
        assert not state.distance_known or said["distance"] == state.nearest.distance
    assert companions.of(first)["distance"] == pytest.approx(0.7, abs=ACCURACY)
