"""Tests of the robot model from a file or a topic: a new description replaces it as a whole, or not at all."""

import pytest
from clearance_msgs.msg import CollisionState
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.serialization import serialize_message
from std_msgs.msg import String

import two_link


def topic_of(name):
    return {"namespace": f"/{name}"}, f"/{name}/robot_description"


def distance(state):
    assert state.status == CollisionState.FREE, state
    return state.nearest.distance


def test_a_description_published_before_the_start(peer, start):
    options, topic = topic_of("before")
    peer.latch(String(data=two_link.description()), topic)

    cell = start(urdf=None, **options)
    cell.has_model()

    assert distance(cell.evaluate(joint1=0, joint2=0)) == pytest.approx(0.7)


def test_a_description_published_after_the_start_and_then_another(peer, start):
    options, topic = topic_of("after")
    cell = start(urdf=None, **options)
    state = cell.unknown("no_model")
    assert "robot_description" in state.reason
    assert state.model_revision == 0

    publisher = peer.latch(String(data=two_link.description()), topic)
    cell.has_model(1)
    assert distance(cell.evaluate(joint1=0, joint2=0)) == pytest.approx(0.7)

    publisher.publish(String(data=two_link.description_with_cube(0.8)))
    cell.has_model(2)
    assert distance(cell.evaluate(joint1=0, joint2=0)) == pytest.approx(0.5)
    # Every answer belongs to one model as a whole.
    for state in cell.states.all():
        if state.status == CollisionState.FREE:
            assert distance(state) == pytest.approx({1: 0.7, 2: 0.5}[state.model_revision])


@pytest.mark.parametrize(
    "broken",
    [
        "",
        "<robot",
        "<robot name='x'/>",
        two_link.description().replace('link="tip"', 'link="nowhere"'),
        serialize_message(String(data="<robot name='Tuer'/>")).replace(b"Tuer", "Tür ".encode("latin-1")),
    ],
    ids=["empty", "not XML", "no links", "a joint to an unknown link", "not UTF-8"],
)
def test_a_broken_description_keeps_the_model_and_is_reported(peer, start, broken):
    options, topic = topic_of("broken")
    diagnostics = peer.record(DiagnosticArray, "/diagnostics")
    publisher = peer.latch(String(data=two_link.description()), topic)
    cell = start(urdf=None, **options)
    cell.has_model()
    assert distance(cell.evaluate(joint1=0, joint2=0)) == pytest.approx(0.7)

    publisher.publish(broken if isinstance(broken, bytes) else String(data=broken))

    def complains(array):
        return any(
            status.level == DiagnosticStatus.WARN and "robot_description" in status.message for status in array.status
        )

    diagnostics.ever(complains, "a complaint about robot_description")
    state = cell.evaluate(joint1=0, joint2=0)
    assert distance(state) == pytest.approx(0.7)
    assert state.model_revision == 1


def test_a_file_on_the_command_line_wins_over_the_topic(peer, start):
    options, topic = topic_of("file")
    peer.latch(String(data=two_link.description_with_cube(0.8)), topic)
    cell = start(**options)

    state = cell.evaluate(joint1=0, joint2=0)
    assert distance(state) == pytest.approx(0.7)
    assert state.model_revision == 1
