"""Tests of the test helper `Recorder`: a result for an older input is never taken for a newer one."""

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.time import Time
from std_msgs.msg import Float64

from cell import Companions


@pytest.fixture
def recorder(peer):
    return peer.record(Float64, "/nothing_else_publishes_this")


def arrive(recorder, *published):
    """Messages of a publisher that counts them, published at these times [ns]: each holds its time."""
    first = len(recorder.all()) + 1
    for number, time in enumerate(published, first):
        recorder._receive(Float64(data=float(time)), {"publication_sequence_number": number, "source_timestamp": time})


def data(messages):
    return [message.data for message in messages]


def test_what_was_published_before_a_moment_does_not_follow_it_whenever_it_arrives(recorder):
    arrive(recorder, 10, 20, 30, 40, 50)
    assert data(recorder.published_since(Time(nanoseconds=25))) == [30, 40, 50]
    # the publisher may have been at work on 30 when the moment came
    assert data(recorder.after(Time(nanoseconds=25))) == [40, 50]
    assert data(recorder.after(Time(nanoseconds=60))) == []


def test_what_follows_a_message_is_found_by_the_message_and_not_by_its_value(recorder):
    arrive(recorder, 10, 10, 20)
    first, second, _ = recorder.all()
    assert first == second
    assert data(recorder.after(second)) == [20]
    assert [recorder.number(message) for message in recorder.all()] == [1, 2, 3]
    assert recorder.numbered(2) is second


def test_a_wait_after_a_moment_fails_rather_than_take_an_older_message(recorder):
    arrive(recorder, 10, 20)
    with pytest.raises(AssertionError, match="in vain for ten or more"):
        recorder.wait_for(lambda message: message.data >= 10, "ten or more", Time(nanoseconds=15), deadline=0.0)
    arrive(recorder, 30)
    assert recorder.wait_for(lambda message: message.data >= 10, "ten or more", Time(nanoseconds=15)).data == 30
    assert recorder.ever(lambda message: message.data >= 10, "ten or more").data == 10


def test_there_is_no_way_to_wait_for_the_next_message_or_to_read_the_last(recorder):
    assert not hasattr(recorder, "next")
    assert not hasattr(recorder, "messages")


def test_a_message_that_was_lost_is_known_by_the_next_one(recorder):
    arrive(recorder, 10, 20)
    lost = len(recorder.all()) + 1
    recorder._receive(Float64(data=40.0), {"publication_sequence_number": lost + 1, "source_timestamp": 40})
    assert recorder.numbered(lost) is None
    assert recorder.numbered(lost + 1).data == 40


def test_a_burst_pushes_nothing_out_while_callbacks_wait_for_their_turn(peer):
    recorder = peer.record(Float64, "/burst")
    publisher = peer.node.create_publisher(Float64, "/burst", 1000)
    peer.wait_for(lambda: publisher.get_subscription_count() == 1, "the recorder")
    peer.between_callbacks(lambda: [publisher.publish(Float64(data=float(number))) for number in range(1000)])
    peer.wait_for(lambda: len(recorder.all()) == 1000, "the whole burst")
    assert data(recorder.all()) == list(range(1000))


@pytest.mark.parametrize("lost", ["is_free", "distance", "speed_scale"])
def test_values_of_which_one_was_lost_are_those_of_the_next_state_that_says_the_same(cell, lost):
    companions = Companions(cell)
    state = cell.falls_silent()
    state = cell.states.more(1, after=state)[0]
    recorder = companions._recorders[lost]
    number = cell.states.number(state)
    recorder.numbered(number)
    recorder._received = [one for one in recorder._received if one.number != number]
    said = companions.of(state)
    assert (said["is_free"], said["distance"]) == (True, pytest.approx(0.7))
    assert 0 <= said["speed_scale"] <= 1
    assert state.status == CollisionState.FREE
