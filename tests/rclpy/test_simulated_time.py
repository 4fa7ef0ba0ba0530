"""Tests of simulated time (bag, simulator): joint states and `/clock` run fast, pause, and start again."""

import threading

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

STALE_AFTER = 5.0  # [s]
BEGIN, END = 1000.0, 1040.0  # [s] of the bag
ZERO = {"joint1": 0.0, "joint2": 0.0}


class Bag:
    """Plays a hundred messages a second of wall time, each `step` seconds of simulated time after the last."""

    def __init__(self, cell):
        self._cell = cell
        self._clock = cell.peer.node.create_publisher(Clock, "/clock", 10)
        self._lock = threading.Lock()
        self._time = BEGIN
        self.step = 0.01
        self.drives = True  # whether the driver's joint states are in it, too
        self.clock_first = True
        self._timer = cell.peer.node.create_timer(0.01, self._tick, autostart=False)

    @property
    def time(self):
        return self._time

    @time.setter
    def time(self, time):
        with self._lock:
            self._time = time

    def _tick(self):
        with self._lock:
            self._time += self.step
            stamp = Time(nanoseconds=round(self._time * 1e9))
        send = [lambda: self._clock.publish(Clock(clock=stamp.to_msg()))]
        if self.drives:
            send.append(lambda: self._cell.driver.publish(ZERO, stamp))
        for publish in send if self.clock_first else reversed(send):
            publish()

    def play(self):
        self._timer.reset()

    def stop(self):
        self._timer.cancel()

    def reaches(self, time):
        self._cell.peer.wait_for(lambda: self.time >= time, f"{time} s of the bag")


@pytest.fixture
def bag(start):
    """Is played, and judged FREE."""
    cell = start(driving=False, parameters={"use_sim_time": True, "stale_after": STALE_AFTER})
    bag = Bag(cell)
    bag.cell = cell
    bag.play()
    free_after(cell, BEGIN)
    return bag


def seconds(state):
    return Time.from_msg(state.header.stamp).nanoseconds * 1e-9


def free_after(cell, time):
    """The first FREE that belongs to a joint state after this moment of the bag, of those to come."""
    return cell.states.wait_for(
        lambda state: state.status == CollisionState.FREE and seconds(state) >= time,
        f"FREE after {time} s",
        after=cell.peer.now(),
    )


def test_a_bag_that_is_played_twenty_times_as_fast_is_evaluated_all_the_time(bag):
    bag.step = 0.2
    first = bag.cell.state_now()
    bag.reaches(END)
    free_after(bag.cell, END - STALE_AFTER)
    states = bag.cell.states.after(first)
    assert {state.status for state in states} == {CollisionState.FREE}
    assert all(state.age < STALE_AFTER for state in states)


def test_silence_counts_in_the_time_of_the_bag(bag):
    bag.step = 0.2
    bag.drives = False
    last = bag.time
    state = bag.cell.unknown("stale")
    assert state.age > STALE_AFTER
    assert seconds(state) <= last + bag.step
    bag.drives = True
    free_after(bag.cell, bag.time)


@pytest.mark.parametrize("clock", ["stands still", "falls silent"])
def test_a_bag_that_is_paused_is_not_free_for_ever(bag, clock):
    if clock == "falls silent":
        bag.stop()
    bag.step, bag.drives = 0.0, False
    first = bag.cell.unknown("stale")
    assert {state.reason_code for state in bag.cell.states.more(10, after=first)} == {"stale"}

    bag.step, bag.drives = 0.01, True
    bag.play()
    free_after(bag.cell, bag.time)


@pytest.mark.parametrize("clock_first", [True, False], ids=["the clock first", "the joint states first"])
def test_a_bag_that_begins_again_is_evaluated_again(bag, clock_first):
    bag.clock_first = clock_first
    bag.step = 0.2
    for _ in range(3):
        bag.reaches(END)
        before = bag.cell.peer.now()
        bag.time = BEGIN
        again = bag.cell.states.wait_for(
            lambda state: state.status == CollisionState.FREE and seconds(state) < BEGIN + 20, "FREE from the beginning", before
        )
        # once the new round is judged, nothing of the old one is free
        bag.reaches(BEGIN + 20)
        assert all(seconds(state) < END - 1 for state in bag.cell.states.after(again) if state.status == CollisionState.FREE)


def test_what_was_free_before_the_clock_was_set_back_is_so_no_more(bag):
    bag.step = 0.2
    bag.reaches(END)
    bag.drives = False
    # by now the last joint state has come, so that none does after the jump
    bag.cell.unknown("stale")
    bag.time = BEGIN
    first = bag.cell.unknown("clock_jump")
    bag.reaches(BEGIN + 10)
    later = [first, *bag.cell.states.after(first)]
    assert {state.status for state in later} == {CollisionState.UNKNOWN}
    assert not any(state.distance_known for state in later)
    bag.drives = True
    free_after(bag.cell, BEGIN + 10)
