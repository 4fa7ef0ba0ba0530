"""Tests of moving obstacles in `~/check_motion` and `~/check_trajectory`, and of their limits in `~/speed_scale`.

Requests have limits, twists and poses of the obstacles. The robot stretches along x, its tip is a ball of 0.1 m at
(2, 0, 0). The cart, a ball of 0.1 m, is 0.8 m beside it, along y.
"""

import json
from math import isclose

import pytest
from clearance_msgs.action import CheckTrajectory as Action
from clearance_msgs.msg import MovingObstacle, ObstacleLimit
from clearance_msgs.srv import CheckMotion
from geometry_msgs.msg import Pose
from rclpy.action import ActionClient
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from motions import Motions
from scene import ball
from scene_client import SceneClient
from test_speed_scale import Speed

REST = (0.0, 0.0)
FREE, CONTACT, UNDECIDED, ERROR = (
    CheckMotion.Response.FREE,
    CheckMotion.Response.CONTACT,
    CheckMotion.Response.UNDECIDED,
    CheckMotion.Response.ERROR,
)


@pytest.fixture
def beside(start):
    """A cell with the cart."""
    cell = start(parameters={"distance_limit": 5.0})
    cell.moving({"joint1": 0.0, "joint2": 0.0}, [0.0, 0.0])
    SceneClient(cell).change(ball("cart", 2, 1))
    return cell


def limit(speed, acceleration=0.0, name=""):
    return ObstacleLimit(name=name, speed=speed, acceleration=acceleration)


def twist(y):
    moving = MovingObstacle(name="cart")
    moving.twist.linear.y = y
    return moving


def poses(*places):
    """Displacements along y at times."""
    moving = MovingObstacle(name="cart", times=[float(time) for time, _ in places])
    for _, y in places:
        pose = Pose()
        pose.position.y = float(y)
        moving.poses.append(pose)
    return moving


def resting(*seconds):
    trajectory = JointTrajectory(joint_names=["joint1", "joint2"])
    for sec in seconds:
        point = JointTrajectoryPoint(positions=list(REST))
        point.time_from_start.sec = sec
        trajectory.points.append(point)
    return trajectory


def test_free_holds_for_every_motion_within_the_limits(beside):
    motions = Motions(beside.peer, beside.node)

    def verdict(duration, *limits, **terms):
        response = motions.check(REST, REST, duration=duration, obstacle_limits=list(limits), **terms)
        return response.verdict, response.reason_code

    assert verdict(1.0, limit(0.7)) == (FREE, "")
    assert verdict(2.0, limit(0.7)) == (UNDECIDED, "tube")
    assert verdict(1.0, limit(0.7), obstacle_latency=0.5) == (UNDECIDED, "tube")
    assert verdict(1.0, limit(0.7, 1.0)) == (UNDECIDED, "tube")
    assert verdict(2.0, limit(5.0), limit(0.3, name="cart")) == (FREE, "")
    assert verdict(0.0, limit(0.7)) == (ERROR, "bad_request")
    assert "duration" in motions.check(REST, REST, moving_obstacles=[twist(1.0)]).message
    assert verdict(1.0, limit(0.7, name="car")) == (ERROR, "bad_request")


def test_a_certificate_contains_the_limits(beside):
    motions = Motions(beside.peer, beside.node)
    response = motions.check(REST, REST, duration=1.0, obstacle_limits=[limit(0.7)], certificate=True)
    (segment,) = json.loads(motions.certificate(response))["segments"]
    assert segment["motion"]["obstacle_uncertainty"]["limits"]["default"]["speed"] == 0.7


def test_a_known_motion_has_a_time_of_contact(beside):
    motions = Motions(beside.peer, beside.node)
    approaching = motions.check(REST, REST, duration=2.0, moving_obstacles=[twist(-1.0)])
    assert approaching.verdict == CONTACT and isclose(approaching.t_contact, 0.4, abs_tol=1e-3)
    assert {approaching.pair.body_a, approaching.pair.body_b} == {"tip", "cart"}
    assert motions.check(REST, REST, duration=2.0, moving_obstacles=[twist(1.0)]).verdict == FREE

    path = poses((0, 0), (1, 0.1), (3, 0.1), (4, -0.9))
    along = motions.follow(resting(0, 2, 4), moving_obstacles=[path], with_clearance=True)
    assert (along.verdict, along.segment) == (CONTACT, 1)
    assert isclose(along.time_contact, 3.9, abs_tol=1e-3) and isclose(along.t_contact, 0.95, abs_tol=1e-3)
    assert along.world_clearance.upper == 0
    short = motions.follow(resting(0, 3), moving_obstacles=[path], with_clearance=True)
    assert short.verdict == FREE
    assert 0.79 < short.world_clearance.lower <= 0.8 <= short.world_clearance.upper < 0.81
    late = motions.follow(resting(0, 5), moving_obstacles=[path])
    assert late.verdict == ERROR and "'cart' has poses from time 0 to 4" in late.message


def test_the_action_takes_moving_obstacles(beside):
    name = beside.node.private("check_trajectory")
    client = beside.peer.between_callbacks(lambda: ActionClient(beside.peer.node, Action, name))
    beside.peer.wait_for(client.server_is_ready, "the action")
    goal = Action.Goal(trajectory=resting(0, 2, 4), moving_obstacles=[twist(-0.25)])
    handle = beside.peer.result(client.send_goal_async(goal), "the goal")
    result = beside.peer.result(handle.get_result_async(), "the result").result
    assert (result.verdict, result.segment) == (CONTACT, 1)
    assert isclose(result.time_contact, 3.2, abs_tol=1e-3)
    beside.peer.between_callbacks(client.destroy)


def test_obstacles_that_may_move_slow_the_robot_down_earlier(beside):
    speed = Speed(beside)
    beside.parameters.succeed(slowdown_distance_world=1.0, stop_distance_world=0.2, slowdown_reaction_time=0.25)
    speed.becomes((0.8 - 0.2) / 0.8)
    beside.parameters.succeed(obstacle_speed=1.0)
    speed.becomes((0.8 - 0.25 - 0.2) / 0.8)
    beside.parameters.succeed(obstacle_latency=0.25)
    speed.becomes((0.8 - 0.5 - 0.2) / 0.8)
    beside.parameters.succeed(obstacle_limits=["cart 0.2 0.0"])
    speed.becomes((0.8 - 0.1 - 0.2) / 0.8)
