"""Tests of `~/obstacle_states`: poses and velocities of obstacles that a tracker publishes."""

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.time import Time
from std_msgs.msg import Float64

from cell import Companions
from scene import attached, ball, move, pose, removal
from scene_client import SceneClient
from tracker import Tracker

STRETCHED = {"joint1": 0, "joint2": 0}  # the tip's ball of 0.1 is at (2, 0)
TOUCHES_AT = 2.2  # [m] the x at which a ball of 0.1 touches it
LOOKING_AHEAD = {
    "look_ahead_horizon": 3.0,
    "look_ahead_acceleration": 0.0,
    "influence_distance": 10.0,
    "distance_limit": 10.0,
}


def looking_ahead(start, **parameters):
    """A cell whose robot stands still, with a cart far away."""
    cell = start(parameters={**LOOKING_AHEAD, **parameters})
    cell.moving(STRETCHED, (0, 0))
    SceneClient(cell).change(ball("cart", 6.0))
    return cell


def near(cell, tracker):
    """A state in which the cart is where the tracker has it."""

    def is_near(state):
        return state.status == CollisionState.FREE and abs(state.world_distance + TOUCHES_AT - tracker.at(state.header.stamp)) < 0.2

    return cell.states.wait_for(is_near, "the cart where it is tracked", after=cell.peer.now())


def test_the_time_to_contact_counts_the_velocity_of_an_obstacle(start):
    cell = looking_ahead(start, obstacle_state_ttl=0.3)
    tracker = Tracker(cell, 3.2, -0.5)
    state = near(cell, tracker)
    # whatever the age of the last pose: by its stamp, the cart is where it is
    truth = (tracker.at(state.header.stamp) - TOUCHES_AT) / 0.5
    assert state.time_to_contact_known and state.time_to_contact_considers_obstacle_motion
    assert truth - 0.05 < state.time_to_contact <= truth + 1e-6
    assert {state.first_contact_pair.body_a, state.first_contact_pair.body_b} == {"tip", "cart"}

    tracker.goes_on(3.0, 0.25)
    away = cell.states.wait_for(lambda state: state.time_to_contact == 3.0, "a cart that moves away", after=state)
    assert away.time_to_contact_considers_obstacle_motion

    tracker.goes_on(3.0, 0.0)
    cell.states.wait_for(
        lambda state: not state.time_to_contact_considers_obstacle_motion, "a cart at rest", after=away
    )
    assert "another node" not in cell.node.output(), "anybody may publish on an input of the node"
    tracker.falls_silent()
    silent = cell.peer.now()

    def is_later(state):
        return (Time.from_msg(state.header.stamp) - silent).nanoseconds > 0.5e9

    rests = cell.states.wait_for(is_later, "a state without a tracker for longer than its states live", after=silent)
    assert rests.status == CollisionState.FREE, "what rests needs no tracker"


def test_an_acceleration_limit_shortens_the_time(start):
    cell = looking_ahead(start, obstacle_limits=["cart 9 0.5"])
    tracker = Tracker(cell, 3.0, -0.25)
    state = near(cell, tracker)
    gap = tracker.at(state.header.stamp) - TOUCHES_AT
    truth = ((0.25**2 + 2 * 0.5 * gap) ** 0.5 - 0.25) / 0.5
    assert 0.6 * truth < state.time_to_contact <= truth + 1e-6


def test_the_speed_scale_counts_the_velocity_of_an_obstacle(start):
    cell = looking_ahead(
        start, slowdown_distance_world=1.5, stop_distance_world=0.5, slowdown_reaction_time=1.0
    )
    companions = Companions(cell, {"speed_scale": Float64})
    tracker = Tracker(cell, 3.6, -0.2)
    state = near(cell, tracker)
    # 0.2 m in the reaction time
    expected = (state.world_distance - 0.2 - 0.5) / 1.0
    assert companions.of(state)["speed_scale"] == pytest.approx(expected, abs=0.02)
    tracker.goes_on(3.2, 0.01)

    def is_at_rest(state):
        # the tip has three solids: a capsule around them may be nearer by the 0.01 m that the cart moves
        expected = pytest.approx(state.world_distance - 0.5, abs=0.015)
        return state.world_distance < 1.4 and companions.of(state)["speed_scale"] == expected

    cell.states.wait_for(is_at_rest, "the speed beside a cart that moves away", after=state)


def test_a_moving_obstacle_that_nobody_tracks_any_more_makes_the_status_unknown(start):
    cell = looking_ahead(start, obstacle_state_ttl=0.3)
    tracker = Tracker(cell, 4.0, -0.01)
    near(cell, tracker)
    tracker.falls_silent()
    state = cell.unknown("stale_world")
    assert "'~/obstacle_states of cart'" in state.reason and "0.3" in state.reason
    assert not state.time_to_contact_known or state.time_to_contact == 0
    # any other message with its pose says that it rests there
    SceneClient(cell).publish(move("cart", pose(4.0, 0, 0)))
    state = cell.becomes(CollisionState.FREE, "a cart that was put somewhere")
    assert not state.time_to_contact_considers_obstacle_motion


def test_parameters_of_obstacles_that_change_while_the_node_runs_have_an_effect(start):
    cell = looking_ahead(start, obstacle_state_ttl=9.0)
    tracker = Tracker(cell, 4.0, 0.0)
    near(cell, tracker)
    tracker.falls_silent()
    parameters = cell.parameters
    parameters.succeed(obstacle_state_ttl=0.1)
    cell.becomes(CollisionState.FREE, "what rests needs no tracker")
    for name, values in [("obstacle_acceleration", (1.0, 0.0)), ("obstacle_limits", (["cart 0 1"], ["cart 0 0"]))]:
        parameters.succeed(**{name: values[0]})
        cell.unknown("stale_world")
        parameters.succeed(**{name: values[1]})
        cell.becomes(CollisionState.FREE, "a cart that cannot begin to move")
    parameters.succeed(obstacle_state_ttl=9.0)
    tracker = Tracker(cell, 4.0, -0.01)
    cell.states.wait_for(
        lambda state: state.time_to_contact_considers_obstacle_motion, "a cart that moves", after=cell.peer.now()
    )
    tracker.falls_silent()
    parameters.succeed(obstacle_state_ttl=0.1)
    cell.unknown("stale_world")


def test_motion_between_states_is_not_proven_beside_a_moving_obstacle(start):
    cell = looking_ahead(start, check_between_states=True)
    sideways = [0.0]
    tracker = Tracker(
        cell, TOUCHES_AT + 0.005, 0.0, damage=lambda state: setattr(state.twist.linear, "y", sideways[0])
    )
    at_rest = near(cell, tracker)

    def is_proven(state):
        return state.motion_since_previous == CollisionState.PROVEN_FREE

    proven = cell.states.wait_for(is_proven, "a motion beside a cart at rest", after=at_rest)
    sideways[0] = 2.0

    def is_unproven(state):
        return state.motion_since_previous == CollisionState.NOT_PROVEN

    unproven = cell.states.wait_for(is_unproven, "a motion beside a cart that moves", after=proven)
    assert "obstacle 'cart' is near and may have moved" in unproven.motion_since_previous_reason


def test_states_of_unknown_obstacles_are_rejected_until_they_are_added(start):
    cell = looking_ahead(start)
    scene = SceneClient(cell)
    scene.complaints.forget()
    tracker = Tracker(cell, 4.0, -0.1, name="person")
    scene.complaints.wait_for("~/obstacle_states", "object 'person'", "the world has no such obstacle")
    cell.unknown("rejected_obstacle")
    scene.publish(ball("person", 4.0))
    near(cell, tracker)
    # what a link holds moves with it
    scene.publish(attached("tip", ball("person", 1.0, frame="tip")))
    scene.complaints.wait_for("object 'person'", "it is attached to link 'tip'")
    cell.becomes(CollisionState.FREE, "a robot that holds it")


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda state: setattr(state.twist.linear, "x", float("nan")), "twist.linear"),
        (lambda state: setattr(state.pose.position, "z", float("inf")), "pose"),
    ],
)
def test_invalid_states_are_rejected(start, damage, words):
    cell = looking_ahead(start)
    scene = SceneClient(cell)
    scene.complaints.forget()
    tracker = Tracker(cell, 4.0, 0.0, damage=damage)
    scene.complaints.wait_for("object 'cart'", words)
    cell.unknown("rejected_obstacle")
    tracker.falls_silent()
    scene.publish(removal("cart"))
    cell.becomes(CollisionState.FREE, "a world without it")
