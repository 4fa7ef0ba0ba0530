"""Tests of `/diagnostics`: level, message and values, and counters of joint states."""

from math import pi

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.duration import Duration
from rclpy.time import Time

import two_link

ZERO = {"joint1": 0.0, "joint2": 0.0}
JOINT_STATES = 20
FLOOD = 5000
TOTALS = ("joint states received", "joint states evaluated", "joint states passed over", "joint states lost", "messages dropped")


class Diagnostics:
    """What a cell's node says about its collision monitor."""

    def __init__(self, cell):
        self.name = f"{cell.node.path[1:]}: collision monitor"
        self._now = cell.peer.now
        self._arrays = cell.peer.record(DiagnosticArray, "/diagnostics", only=self._of_node)

    def _of_node(self, array):
        return [status for status in array.status if status.name == self.name]

    def wait_for(self, level):
        """The first status of this level that is published from now on."""

        def of_level(array):
            return [status for status in self._of_node(array) if status.level == level]

        # one is published as soon as the status changes
        array = self._arrays.event(of_level, f"level {level} of {self.name}", since=self._now())
        return of_level(array)[0]

    def after(self, moment, *keys):
        """The first status that was told after this moment, and has something to say about these keys."""

        def later(array):
            if Time.from_msg(array.header.stamp) < moment:
                return None
            return next((s for s in self._of_node(array) if all(values(s)[key] != "0" for key in keys)), None)

        return later(self._arrays.ever(later, f"a status of {self.name} after {moment}"))


@pytest.fixture
def diagnostics(cell):
    return Diagnostics(cell)


def values(status):
    return {item.key: item.value for item in status.values}


def totals(status):
    """What was counted since the start of the node."""
    return {name: int(values(status)[name]) for name in TOTALS}


def test_diagnostics_follow_the_state(cell, diagnostics):
    cell.evaluate(joint1=0, joint2=0)
    free = diagnostics.wait_for(DiagnosticStatus.OK)
    assert "free" in free.message
    assert free.hardware_id == "two_link"
    assert values(free)["status"] == "FREE"
    assert float(values(free)["least distance (m)"]) == pytest.approx(0.7)

    cell.evaluate(joint1=0, joint2=pi)
    colliding = diagnostics.wait_for(DiagnosticStatus.ERROR)
    assert "base" in colliding.message
    assert "tip" in colliding.message
    assert values(colliding)["status"] == "COLLIDING"

    cell.grows_old()
    cell.driver.pause()
    stale = diagnostics.wait_for(DiagnosticStatus.STALE)
    assert stale.message
    assert values(stale)["reason"] == "stale"


def test_a_warning_is_no_error(cell, diagnostics):
    cell.evaluate(joint1=0, joint2=0, gripper=0.3)
    status = diagnostics.wait_for(DiagnosticStatus.WARN)
    assert "gripper" in values(status)["warning"]


def test_the_numbers_of_the_last_report_are_reported(cell, diagnostics):
    cell.evaluate(joint1=0, joint2=0)
    reported = values(diagnostics.after(cell.peer.now(), "joint states evaluated in this report"))
    assert float(reported["joint states per second"]) > 0
    assert float(reported["seconds of this report"]) > 0
    assert 0 < float(reported["mean compute time (ms)"]) <= float(reported["longest compute time (ms)"])
    for name in ("latency", "latency since start"):
        median, p99, longest = (float(reported[f"{name}: {part} (ms)"]) for part in ("median", "p99", "max"))
        assert 0 < median <= p99 <= longest
    assert (reported["pairs checked"], reported["pairs skipped"]) == ("1", "2")
    assert reported["model"] == "two_link"


def test_every_joint_state_is_counted_once(start):
    cell = start(driving=False, parameters={"stale_after": 3600.0})
    diagnostics = Diagnostics(cell)
    publish_until_received(cell)
    before = totals(diagnostics.after(cell.peer.now()))
    for _ in range(JOINT_STATES):
        stamp = cell.peer.now()
        cell.driver.publish(ZERO, stamp)
        cell.states.ever(two_link.evaluated_of(stamp), "an answer")
    after = totals(diagnostics.after(cell.peer.now()))

    grown = {name: after[name] - before[name] for name in after}
    assert grown["joint states received"] == JOINT_STATES
    assert grown["joint states evaluated"] == JOINT_STATES
    assert grown["joint states passed over"] == grown["joint states lost"] == grown["messages dropped"] == 0


def test_joint_states_that_never_came_are_counted_as_lost(start):
    """More comes at once than is kept for the node: what it heard and what it missed is all that was sent."""
    cell = start(driving=False, parameters={"stale_after": 3600.0})
    diagnostics = Diagnostics(cell)
    publish_until_received(cell)
    before = totals(diagnostics.after(cell.peer.now()))
    for _ in range(FLOOD):
        cell.driver.publish(ZERO)
    sent = FLOOD + publish_until_received(cell)
    after = totals(diagnostics.after(cell.peer.now()))

    grown = {name: after[name] - before[name] for name in after}
    assert grown["joint states received"] == grown["joint states evaluated"] + grown["joint states passed over"]
    assert grown["joint states received"] + grown["joint states lost"] == sent


def publish_until_received(cell):
    """Gives how many joint states that took: nobody listens at first, and nobody hears when too much comes."""
    stamps = []
    seen = len(cell.states.all())

    def responded():
        nonlocal seen
        # a flood has many answers: each is looked at once
        new = cell.states.all()[seen:]
        seen += len(new)
        return stamps and any(map(two_link.evaluated_of(stamps[-1]), new))

    def publish():
        if responded():
            return True
        if not stamps or cell.peer.now() - stamps[-1] > Duration(seconds=1):
            stamps.append(cell.peer.now())
            cell.driver.publish(ZERO, stamps[-1])
        return False

    cell.peer.wait_for(publish, "an answer to the last joint state")
    return len(stamps)


def test_without_a_model_diagnostics_say_what_to_do(start):
    cell = start(urdf=None)
    status = Diagnostics(cell).wait_for(DiagnosticStatus.ERROR)
    assert "robot_description" in status.message
    assert values(status)["reason"] == "no_model"
