"""Tests of a node with an obstacle from a scene file: names, padding, complete messages."""

from pathlib import Path

import pytest
from clearance_msgs.msg import BodyPair, CollisionState

BEACON = Path(__file__).with_name("beacon.yaml")


@pytest.fixture
def cell(start):
    return start("--world", BEACON, parameters={"influence_distance": 0.5})


def test_an_obstacle_is_named_as_one(cell):
    state = cell.evaluate(joint1=0, joint2=0)

    assert state.status == CollisionState.FREE
    # base - tip, and each of the three links against the beacon.
    assert state.pairs_checked == 4
    assert state.nearest.distance == pytest.approx(0.1)
    pair = state.nearest.pair
    assert (pair.body_a, pair.type_a, pair.body_b, pair.type_b) == ("tip", BodyPair.LINK, "beacon", BodyPair.OBSTACLE)
    on_tip, on_beacon = ((point.x, point.y, point.z) for point in state.nearest.witness_points)
    assert on_tip == pytest.approx((2.1, 0, 0), abs=1e-4)
    assert on_beacon == pytest.approx((2.2, 0, 0), abs=1e-4)


def test_padding_changes_live(cell):
    assert cell.evaluate(joint1=0, joint2=0).nearest.distance == pytest.approx(0.1)

    cell.parameters.succeed(padding=0.04)
    state = cell.states.ever(lambda state: state.nearest.distance == pytest.approx(0.06), "a padded distance")
    assert state.status == CollisionState.FREE

    cell.parameters.succeed(padding=0.11)
    state = cell.becomes(CollisionState.COLLIDING, "a collision of the padded robot")
    assert state.model_revision == 1


def test_a_message_with_every_field_filled_arrives_whole(start):
    cell = start("--world", BEACON, parameters={"influence_distance": 1.0, "padding": 0.11})
    state = cell.evaluate(joint1=0, joint2=0, gripper=0.3)

    assert state.header.frame_id == "base"
    assert state.status == CollisionState.COLLIDING
    assert [(pair.body_a, pair.body_b) for pair in state.colliding_pairs] == [("tip", "beacon")]
    assert state.distance_known
    assert state.nearest.distance == 0
    found = {(near.pair.body_a, near.pair.body_b): near.distance for near in state.pair_distances}
    assert found == pytest.approx({("tip", "beacon"): 0.0, ("base", "tip"): 0.7})
    assert state.age >= 0
    assert state.model_revision == 1
    assert state.world_revision == 1
    assert (state.pairs_checked, state.pairs_skipped) == (4, 2)
    assert [(skipped.reason, skipped.count) for skipped in state.skipped] == [("adjacent rigid bodies (no SRDF)", 2)]
    assert len(state.warnings) == 1
    assert "gripper" in state.warnings[0]
    assert 0 < state.compute_time < 1
    assert state.fidelity == "mesh"
