"""Tests of `~/heartbeat_state` and of the contact counters in `~/state`, for subscribers that miss messages."""

from math import inf, isnan, pi

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.time import Time

from peer import Peer
from scene import box, obstacle, pose
from scene_client import SceneClient
from two_link import FREE

STRETCHED = {"joint1": 0.0, "joint2": 0.0}
NEAR = {"joint1": FREE[3].joint1, "joint2": FREE[3].joint2}
FOLDED = {"joint1": 0.0, "joint2": pi}
PERIOD = 1_000_000  # [ns] from one joint state to the next, by their stamps


@pytest.fixture
def slow(start):
    """A cell with few heartbeats, whose robot is free."""
    cell = start(parameters={"heartbeat_rate": 4.0, "distance_limit": 2.0})
    cell.evaluate(**STRETCHED)
    return cell


def heartbeats(cell):
    recorder = cell.peer.record(CollisionState, cell.node.private("heartbeat_state"))
    recorder.ever(lambda _: True, "a heartbeat")
    return recorder


def motion(cell, *parts):
    """The states evaluated of joint states 1 ms apart: each part is positions and how many there are of them."""
    cell.driver.pause()
    now = cell.peer.now()
    positions = [positions for positions, count in parts for _ in range(count)]
    stamps = (Time(nanoseconds=now.nanoseconds + i * PERIOD, clock_type=now.clock_type) for i in range(len(positions)))
    return [cell.evaluated(at, stamp) for at, stamp in zip(positions, stamps)]


def same(cell, heartbeat):
    """The same message on `~/state`."""
    # by its text: NaN is unequal to itself
    return cell.states.ever(lambda state: repr(state) == repr(heartbeat), "the same message")


def pairs(state):
    return [{pair.body_a, pair.body_b} for pair in state.since_heartbeat.touched_pairs]


def contacts(state):
    return state.contacts_begun, state.contacts_ended


def test_a_contact_of_20_ms_is_in_a_heartbeat_message(slow):
    recorder = heartbeats(slow)
    states = motion(slow, (STRETCHED, 1), (FOLDED, 20), (NEAR, 1))
    first, last = states[0], states[-1]
    assert (contacts(first), contacts(last)) == ((0, 0), (1, 1))
    assert {state.status for state in states[1:-1]} == {CollisionState.COLLIDING}

    final = recorder.ever(lambda state: contacts(state) == (1, 1), "a heartbeat after the contact")
    touching = [state for state in recorder.all() if pairs(state)]
    assert touching and all(pairs(state) == [{"base", "tip"}] for state in touching)
    assert min(state.since_heartbeat.least_distance for state in touching) == 0
    assert final.status == CollisionState.FREE
    assert not any(state.since_heartbeat.all_free for state in touching)


def test_the_least_distance_comes_with_its_pair_and_stamp(slow):
    recorder = heartbeats(slow)
    states = motion(slow, (STRETCHED, 1), (NEAR, 1), (STRETCHED, 1))
    stamp = states[1].header.stamp
    least = recorder.ever(lambda state: state.since_heartbeat.least_distance_stamp == stamp, "the least distance")
    since = least.since_heartbeat
    assert since.least_distance == pytest.approx(0.2, abs=1e-6)
    assert {since.least_distance_pair.body_a, since.least_distance_pair.body_b} == {"base", "tip"}
    assert since.touched_pairs == [] and since.messages >= 1
    # The robot rests: the distance is that of the last state.
    rest = recorder.wait_for(lambda state: state.since_heartbeat.all_free, "a heartbeat at rest", least)
    assert rest.since_heartbeat.least_distance == pytest.approx(0.7, abs=1e-6)


def test_heartbeat_messages_come_at_their_rate_and_count_all_messages(slow):
    recorder = heartbeats(slow)
    first = recorder.all()[-1]
    later = recorder.more(4, after=first)
    times = [Time.from_msg(state.header.stamp).nanoseconds * 1e-9 for state in later]
    assert times == sorted(times)
    # The driver publishes 50 joint states a second: a heartbeat message is about many of them.
    begin, end = (slow.states.number(same(slow, heartbeat)) for heartbeat in (first, later[-1]))
    assert sum(state.since_heartbeat.messages for state in later) == end - begin
    assert all(state.since_heartbeat.all_free for state in later)


def test_a_slow_subscriber_of_every_state_counts_contacts(slow):
    """A queue of one message, and nobody looks while the robot touches: the counters of the last message suffice."""
    with Peer(slow.peer.domain_id) as idle:
        seen = []
        idle.node.create_subscription(CollisionState, slow.node.private("state"), seen.append, 1)
        idle.wait_for(lambda: seen, "a first state")
        slow.driver.pause()
        with idle.paused():
            before = contacts(seen[-1])
            states = motion(slow, (STRETCHED, 1), (FOLDED, 3), (STRETCHED, 1), (FOLDED, 2), (STRETCHED, 1))
        # How many of the states it has missed depends on when they reach it.
        idle.wait_for(lambda: contacts(seen[-1]) == contacts(states[-1]), "the last state")
    assert before == (0, 0) and contacts(seen[-1]) == (2, 2)
    assert seen[-1].status == CollisionState.FREE


def test_a_contact_between_two_states_counts(slow):
    recorder = heartbeats(slow)
    slow.evaluate(joint1=-0.5, joint2=0.0)
    SceneClient(slow).change(obstacle("wall", box(0.4, 0.001, 0.4), at=pose(1.0, 0, 0)))
    start, across = motion(slow, ({"joint1": -0.5, "joint2": 0.0}, 1), ({"joint1": 0.5, "joint2": 0.0}, 1))
    assert across.motion_since_previous == CollisionState.PASSED_THROUGH
    begun, ended = contacts(start)
    assert contacts(across) == (begun + 1, ended + 1)
    through = recorder.ever(lambda state: contacts(state) == contacts(across), "a heartbeat after it")
    # the first heartbeat with these counters is about the contact
    assert {"tip", "wall"} in pairs(through) and through.since_heartbeat.touched_pair_count == 1
    assert through.since_heartbeat.heartbeat == recorder.number(through)


def test_without_joint_states_nothing_is_known(start):
    cell = start(driving=False)
    state = heartbeats(cell).all()[0]
    since = state.since_heartbeat
    assert state.status == CollisionState.UNKNOWN
    assert isnan(since.least_distance) and not since.all_free and since.messages >= 1
    assert contacts(state) == (0, 0)


def test_nothing_near_is_an_infinite_least_distance(start):
    cell = start(parameters={"distance_limit": 0.1})
    recorder = heartbeats(cell)
    state = recorder.ever(lambda state: state.since_heartbeat.all_free, "a free robot")
    assert state.since_heartbeat.least_distance == inf
    assert state.since_heartbeat.least_distance_pair.body_a == ""
