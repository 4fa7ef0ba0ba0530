"""`/diagnostics`: what an operator's panel shows."""

from math import pi

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus


class Diagnostics:
    """What a cell's node says about its collision monitor."""

    def __init__(self, cell):
        self.name = f"{cell.node.path[1:]}: collision monitor"
        self._arrays = cell.peer.record(DiagnosticArray, "/diagnostics")

    def wait_for(self, level):
        """The first status of this level that comes from now on."""

        def of_level(array):
            return [status for status in array.status if (status.name, status.level) == (self.name, level)]

        array = self._arrays.wait_for(of_level, f"level {level} of {self.name}", after=len(self._arrays.messages))
        return of_level(array)[0]


@pytest.fixture
def diagnostics(cell):
    return Diagnostics(cell)


def values(status):
    return {item.key: item.value for item in status.values}


def test_diagnostics_follow_the_state(cell, diagnostics):
    cell.judged(joint1=0, joint2=0)
    free = diagnostics.wait_for(DiagnosticStatus.OK)
    assert "free" in free.message
    assert free.hardware_id == "two_link"
    assert values(free)["status"] == "FREE"
    assert float(values(free)["least distance (m)"]) == pytest.approx(0.7)

    cell.judged(joint1=0, joint2=pi)
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
    cell.judged(joint1=0, joint2=0, gripper=0.3)
    status = diagnostics.wait_for(DiagnosticStatus.WARN)
    assert "gripper" in values(status)["warning"]


def test_the_numbers_of_the_last_second_are_told(cell, diagnostics):
    cell.judged(joint1=0, joint2=0)
    diagnostics.wait_for(DiagnosticStatus.OK)

    told = values(diagnostics.wait_for(DiagnosticStatus.OK))
    assert float(told["joint states per second"]) == pytest.approx(50, rel=0.3)
    assert 0 < float(told["mean compute time (ms)"]) <= float(told["longest compute time (ms)"])
    assert (told["pairs checked"], told["pairs skipped"]) == ("1", "2")
    assert told["model"] == "two_link"


def test_without_a_model_diagnostics_say_what_to_do(start):
    cell = start(urdf=None)
    status = Diagnostics(cell).wait_for(DiagnosticStatus.ERROR)
    assert "robot_description" in status.message
    assert values(status)["reason"] == "no_model"
