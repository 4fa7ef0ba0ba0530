"""Tests of `~/speed_scale`: lower near obstacles, zero when UNKNOWN, never lower for motion away from them.

Beside the base the tip's ball is at height sin(joint2), with joint1 at zero: see urdf/two_link. Below it the top of the base is at 0.2.
"""

from math import pi, sin

import pytest
from clearance_msgs.msg import CollisionState
from std_msgs.msg import Float64
from std_srvs.srv import SetBool

SLOWDOWN, STOP = 0.4, 0.1
SETTINGS = {
    "slowdown_distance_self": SLOWDOWN,
    "stop_distance_self": STOP,
    "slowdown_reaction_time": 0.1,
    "slowdown_release_count": 2,
    "distance_limit": 5.0,
}
NEAR = {"joint1": 0.0, "joint2": 5 * pi / 6}  # distance 0.2
TOUCHING = {"joint1": 0.0, "joint2": pi}
FAR = {"joint1": 0.0, "joint2": 0.0}


class Speed:
    def __init__(self, cell):
        self._cell = cell
        self._scales = cell.peer.record(Float64, cell.node.private("speed_scale"))

    def becomes(self, scale):
        expected = pytest.approx(scale, abs=1e-6)
        self._scales.wait_for(
            lambda message: message.data == expected, f"a speed of {scale}", after=self._cell.peer.now()
        )

    def stays_within(self, least, most, count=20):
        scales = self._scales.more(count, after=self._cell.peer.now())
        assert all(least <= message.data <= most for message in scales)


@pytest.fixture
def slowing(start):
    cell = start(parameters=SETTINGS)
    return cell, Speed(cell)


def test_what_is_near_is_slowed_in_proportion(slowing):
    cell, speed = slowing
    cell.moving(FAR, [0.0, 0.0])
    speed.becomes(1.0)
    cell.moving(NEAR, [0.0, 0.0])
    speed.becomes((0.2 - STOP) / (SLOWDOWN - STOP))
    cell.moving({"joint1": 0.0, "joint2": pi - 0.38}, [0.0, 0.0])
    # the ball's distance is sin(0.38) - 0.3 = 0.0709
    assert sin(0.38) - 0.3 < STOP
    speed.becomes(0.0)
    # pairs that slow the robot down are told, beyond the influence distance too
    assert cell.evaluate(**NEAR).pair_distances


def test_what_approaches_is_slower_and_what_moves_away_is_free(slowing):
    cell, speed = slowing
    # the ball sinks by cos(joint2) times the velocity: 0.866
    cell.moving(NEAR, [0.0, 0.5])
    speed.becomes((0.2 - STOP - 0.1 * 0.5 * sin(pi / 3)) / (SLOWDOWN - STOP))
    cell.moving(NEAR, [0.0, -0.5])
    speed.becomes(1.0)
    cell.moving(NEAR, [0.0, 3.0])
    speed.becomes(0.0)
    cell.moving({"joint1": 0.0, "joint2": pi - 0.38}, [0.0, -0.1])
    speed.becomes(1.0)


def test_without_knowledge_there_is_no_speed(slowing):
    cell, speed = slowing
    cell.evaluate(**FAR)
    speed.becomes(1.0)
    cell.evaluate(**TOUCHING)
    speed.becomes(0.0)
    cell.evaluate(**FAR)
    speed.becomes(1.0)
    cell.grows_old()
    cell.driver.pause()
    speed.becomes(0.0)
    cell.driver.resume()
    speed.becomes(1.0)

    client = cell.peer.node.create_client(SetBool, cell.node.private("enable"))
    cell.peer.wait_for(client.service_is_ready, "~/enable")
    assert cell.peer.result(client.call_async(SetBool.Request(data=False))).success
    cell.unknown("disabled")
    speed.stays_within(0.0, 0.0)
    assert cell.peer.result(client.call_async(SetBool.Request(data=True))).success
    speed.becomes(1.0)


def test_the_counts_keep_the_speed_from_chattering(slowing):
    cell, speed = slowing
    cell.parameters.succeed(slowdown_trigger_count=1000, slowdown_release_count=1)
    cell.evaluate(**FAR)
    speed.becomes(1.0)
    cell.evaluate(**NEAR)
    speed.stays_within(1.0, 1.0)
    # a collision does not wait for a thousand states
    cell.evaluate(**TOUCHING)
    speed.becomes(0.0)
    cell.parameters.succeed(slowdown_trigger_count=1, slowdown_release_count=1000)
    cell.evaluate(**FAR)
    speed.stays_within(0.0, 0.0)
    cell.parameters.succeed(slowdown_release_count=3)
    speed.becomes(1.0)


def test_thresholds_of_the_world_are_its_own(start):
    cell = start("--world", "tests/rclpy/beacon.yaml", parameters=SETTINGS)
    speed = Speed(cell)
    # the ball is 0.1 before the beacon, and the robot 0.7 from itself
    assert cell.evaluate(**FAR).status == CollisionState.FREE
    speed.becomes(1.0)
    cell.parameters.succeed(slowdown_distance_world=0.2)
    speed.becomes(0.5)
    cell.parameters.succeed(stop_distance_world=0.1001)
    speed.becomes(0.0)
