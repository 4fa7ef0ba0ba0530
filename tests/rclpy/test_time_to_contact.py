"""`~/time_to_contact` and its fields in `~/state` against answers worked out by hand."""

from math import nan, pi

import pytest
from clearance_msgs.msg import CollisionState
from std_msgs.msg import Float64

import two_link
from cell import Companions


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
