"""Tests of `~/time_to_contact` and its fields in `~/state` against hand-computed results."""

from math import nan, pi

import pytest
from clearance_msgs.msg import CollisionState
from std_msgs.msg import Float64

import two_link
from cell import Companions
from scene import ball
from scene_client import SceneClient


def test_the_time_to_contact_of_a_robot_at_rest_is_the_horizon(start):
    cell = start(parameters={"look_ahead_horizon": 0.2, "look_ahead_acceleration": 1.0})
    spoken = cell.peer.record(Float64, cell.node.private("time_to_contact"))
    state = cell.moving({"joint1": 0, "joint2": 0}, (0, 0))

    assert state.time_to_contact_known
    assert state.time_to_contact == pytest.approx(0.2)
    assert state.first_contact_pair.body_a == ""
    # On the topic, which has no stamp, the age of the joint state is taken off.
    data = spoken.ever(lambda message: message.data > 0, "a time").data
    assert 0 < data <= 0.2


@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_the_time_to_contact_is_no_longer_than_the_truth(start, speed):
    cell = start(parameters={"look_ahead_horizon": 1.0, "look_ahead_acceleration": 0.01})
    joint2 = two_link.FIRST_TOUCH - 0.2
    state = cell.moving({"joint1": 0, "joint2": joint2}, (0, speed))

    assert state.status == CollisionState.FREE
    assert state.time_to_contact_known
    truth = 0.2 / speed
    assert 0.8 * truth < state.time_to_contact <= truth
    assert {state.first_contact_pair.body_a, state.first_contact_pair.body_b} == {"base", "tip"}

    away = cell.moving({"joint1": 0, "joint2": joint2}, (0, -speed))
    assert away.time_to_contact == pytest.approx(1.0)


def test_the_time_to_contact_of_a_collision_is_zero_and_without_velocities_it_is_not_known(start):
    cell = start(parameters={"look_ahead_horizon": 0.2})
    companions = Companions(cell, {"time_to_contact": Float64})
    state = cell.moving({"joint1": 0, "joint2": pi}, (0, 0))
    assert companions.of(state)["time_to_contact"] == 0
    assert (state.time_to_contact_known, state.time_to_contact) == (True, 0)
    assert {state.first_contact_pair.body_a, state.first_contact_pair.body_b} == {"base", "tip"}

    for velocities in ((), (0,), (0, nan)):
        state = cell.moving({"joint1": 0, "joint2": 0}, velocities)
        assert state.status == CollisionState.FREE
        assert (state.time_to_contact_known, state.time_to_contact) == (False, 0)
        assert any("time to contact" in warning for warning in state.warnings)
        assert companions.of(state)["time_to_contact"] == 0


def test_the_look_ahead_is_off_unless_it_is_asked_for(cell):
    cell.driver.velocities = (0, 0)
    state = cell.evaluate(joint1=0, joint2=0)
    cell.driver.velocities = ()

    assert not state.time_to_contact_known
    assert state.warnings == []


def test_turning_the_look_ahead_off_says_zero_once_more(start):
    cell = start(parameters={"look_ahead_horizon": 0.2, "look_ahead_acceleration": 1.0})
    spoken = cell.peer.record(Float64, cell.node.private("time_to_contact"))
    cell.moving({"joint1": 0, "joint2": 0}, (0, 0))
    last = spoken.ever(lambda message: message.data > 0, "a time")
    cell.parameters.succeed(look_ahead_horizon=0.0)
    cell.states.wait_for(lambda state: not state.time_to_contact_known, "no time", after=cell.peer.now())
    zero = spoken.wait_for(lambda message: message.data == 0, "a last zero", after=last)
    assert spoken.after(zero) == []


def test_obstacles_that_may_move_shorten_the_time_to_contact(start):
    cell = start(parameters={"look_ahead_horizon": 10.0, "look_ahead_acceleration": 0.0, "distance_limit": 5.0})
    SceneClient(cell).change(ball("cart", 2.5))

    def look():
        return cell.moving({"joint1": 0, "joint2": 0}, (0, 0))

    state = look()
    assert (state.time_to_contact, state.time_to_contact_considers_obstacle_motion) == (10.0, False)
    for parameters, speed, latency in [
        ({"obstacle_speed": 0.1}, 0.1, 0.0),
        ({"obstacle_limits": ["cart 0.2 0", "wall 9 9"]}, 0.2, 0.0),
        ({"obstacle_speed": 0.0}, 0.2, 0.0),
        ({"obstacle_latency": 0.3}, 0.2, 0.3),
    ]:
        cell.parameters.succeed(**parameters)
        state = look()
        truth = state.world_distance / speed - latency
        assert state.time_to_contact_considers_obstacle_motion
        assert 0.9 * truth < state.time_to_contact <= truth
        is_wall_unknown = "obstacle_limits: the world has no obstacle 'wall'" in state.warnings
        assert is_wall_unknown == (cell.parameters.get("obstacle_limits") != [[]])
        assert "cart" in (state.first_contact_pair.body_a, state.first_contact_pair.body_b)


@pytest.mark.parametrize(
    ("name", "value", "error"),
    [
        ("obstacle_speed", -1.0, "obstacle_speed must be from 0 to 100 m/s"),
        ("obstacle_limits", ["cart"], "'cart': it must have the form 'NAME SPEED ACCELERATION'"),
        ("obstacle_limits", ["cart 1 2", "cart 1 3"], "this obstacle has two limits"),
    ],
)
def test_invalid_limits_of_obstacles_are_rejected(cell, name, value, error):
    (result,) = cell.parameters.set(**{name: value})
    assert not result.successful
    assert error in result.reason
