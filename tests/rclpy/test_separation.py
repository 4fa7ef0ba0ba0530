"""Tests of speed and separation monitoring: the speed falls only towards an obstacle that may be a person.

The beacon is at (2.3, 0, 0). The tip's ball is at (1 + cos(joint2), sin(joint2)), with joint1 at zero: see urdf/two_link.
"""

from math import cos, hypot, inf, isnan, sin, sqrt

import pytest
from clearance_msgs.msg import CollisionState, Separation
from test_speed_scale import Speed

HUMAN_SPEED, ROBOT_SPEED, REACTION_TIME, DECELERATION = 1.0, 1.0, 0.1, 2.0
SETTINGS = {
    "speed_mode": "ssm",
    "ssm_human_speed": HUMAN_SPEED,
    "ssm_robot_speed": ROBOT_SPEED,
    "ssm_reaction_time": REACTION_TIME,
    "ssm_deceleration": DECELERATION,
    "ssm_acceleration": 4.0,
    "slowdown_release_count": 2,
    "distance_limit": 5.0,
}
BENT = 0.6
NEAR = {"joint1": 0.0, "joint2": BENT}
# The ball is at the same place, and the tip is parallel to the x axis.
PARALLEL = {"joint1": BENT, "joint2": -BENT}
TOUCHING = {"joint1": 0.0, "joint2": 3.14}
FAR = {"joint1": 3.0, "joint2": 0.0}

WAY = (1.3 - cos(BENT), -sin(BENT))
DISTANCE = hypot(*WAY) - 0.2
# approach speed for 1 rad/s of joint2
RATE = (-sin(BENT) * WAY[0] + cos(BENT) * WAY[1]) / hypot(*WAY)


def allowed(distance, human_speed=HUMAN_SPEED):
    return sqrt(human_speed**2 + 2 * DECELERATION * distance) - human_speed - DECELERATION * REACTION_TIME


@pytest.fixture
def monitored(start):
    cell = start("--world", "tests/rclpy/beacon.yaml", parameters=SETTINGS)
    return cell, Speed(cell), cell.peer.record(Separation, cell.node.private("separation"))


def test_the_speed_falls_towards_a_person_and_not_away_from_one(monitored):
    cell, speed, separations = monitored

    def separation(condition, what):
        return separations.wait_for(condition, what, after=cell.peer.now())

    cell.moving(FAR, [0.0, 0.0])
    speed.becomes(1.0)
    far = separation(lambda message: message.distance == inf, "nothing in range")
    assert not far.pair_known and far.allowed_speed == ROBOT_SPEED

    # a robot at rest may be commanded to move at its largest speed
    cell.moving(NEAR, [0.0, 0.0])
    speed.becomes(allowed(DISTANCE) / ROBOT_SPEED)
    resting = separation(lambda message: message.pair_known, "the beacon")
    assert {resting.pair.body_a, resting.pair.body_b} == {"tip", "beacon"}
    assert resting.distance == pytest.approx(DISTANCE, abs=1e-6)
    assert resting.allowed_speed == pytest.approx(allowed(DISTANCE), abs=1e-6)
    assert resting.approach_speed_known and resting.approach_speed == pytest.approx(0.0, abs=1e-6)
    assert resting.protective_distance == pytest.approx(HUMAN_SPEED * REACTION_TIME, abs=1e-6)

    cell.moving(NEAR, [0.0, -0.5])
    speed.becomes(allowed(DISTANCE) / ROBOT_SPEED)
    assert -0.5 * RATE > 0.4
    # the tip is translated: all its points move away
    cell.moving(PARALLEL, [1.0, -1.0])
    speed.becomes(1.0)
    # it turns: the nearest point moves away, and others approach
    cell.moving(NEAR, [0.0, 0.5])
    speed.becomes(allowed(DISTANCE) / ROBOT_SPEED)
    cell.moving(NEAR, [0.0, -3.0])
    speed.becomes(allowed(DISTANCE) / (-3.0 * RATE))
    fast = separation(lambda message: message.approach_speed > 1.0, "a fast approach")
    assert fast.distance < fast.protective_distance

    cell.moving({"joint1": 0.0, "joint2": 0.0}, [0.0, 0.0])
    speed.becomes(0.0)


def test_what_is_not_free_has_no_separation_and_a_resting_obstacle_no_person(monitored):
    cell, speed, separations = monitored
    cell.moving(NEAR, [0.0, 0.0])
    speed.becomes(allowed(DISTANCE))
    assert cell.evaluate(**TOUCHING).status == CollisionState.COLLIDING
    speed.becomes(0.0)
    separations.wait_for(lambda message: isnan(message.distance), "no separation", after=cell.peer.now())
    cell.moving(NEAR, [0.0, 0.0])
    speed.becomes(allowed(DISTANCE))
    cell.parameters.succeed(ssm_resting_obstacles=["bea*"])
    speed.becomes(1.0)
    cell.parameters.succeed(slowdown_distance_world=2 * DISTANCE)
    speed.becomes(0.5)
    cell.parameters.succeed(speed_mode="distances")
    separations.ever(lambda message: isnan(message.allowed_speed), "the end of the monitoring")
    speed.becomes(0.5)


def test_an_obstacle_may_have_a_speed_of_its_own(monitored):
    cell, speed, _ = monitored
    cell.moving(NEAR, [0.0, 0.0])
    speed.becomes(allowed(DISTANCE))
    cell.parameters.succeed(ssm_obstacle_speeds=["bea* 2.5", "other 9"])
    speed.becomes(allowed(DISTANCE, human_speed=2.5))
    cell.parameters.succeed(ssm_resting_obstacles=["beacon"])
    speed.becomes(allowed(DISTANCE, human_speed=2.5))
    (result,) = cell.parameters.set(ssm_obstacle_speeds=["beacon fast"])
    assert not result.successful
    assert "the speed (m/s) must be a number from 0 to 10, but is 'fast'" in result.reason
