"""Tests of the direction of continuous joints in `~/check_motion` and `~/check_trajectory`."""

import json
from math import pi

import pytest
from clearance_msgs.srv import CheckMotion, CheckTrajectory
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from cell import Cell
from motions import Motions

# A bar of 1 m on a continuous joint, and a ball where the joint is at half a turn.
URDF = """<robot name="wheel">
  <link name="base"/>
  <link name="bar"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.05 0.05"/></geometry></collision></link>
  <joint name="j" type="continuous"><parent link="base"/><child link="bar"/><axis xyz="0 0 1"/></joint>
</robot>"""
WORLD = """world:
  collision_objects:
    - id: ball
      header: {frame_id: base}
      primitives: [{type: sphere, dimensions: [0.02]}]
      primitive_poses: [{position: [-0.8, 0, 0], orientation: [0, 0, 0, 1]}]
"""
FREE, CONTACT, ERROR = CheckMotion.Response.FREE, CheckMotion.Response.CONTACT, CheckMotion.Response.ERROR
SHORTEST, AS_GIVEN = CheckMotion.Request.SHORTEST, CheckMotion.Request.AS_GIVEN
LONG = "'j' turns by more than half a turn, from 3"


@pytest.fixture(scope="module")
def cell(module_peer, tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    urdf, world = folder / "robot.urdf", folder / "world.yaml"
    urdf.write_text(URDF)
    world.write_text(WORLD)
    with Cell(module_peer, "--world", str(world), urdf=str(urdf)) as cell:
        cell.evaluate(j=3)
        cell.motions = Motions(module_peer, cell.node)
        yield cell


def turned(response):
    """Where the joint starts and ends in what was checked."""
    assert list(response.continuous_joints) == ["j"]
    return response.continuous_starts[0], response.continuous_goals[0]


def test_from_the_current_state_a_joint_goes_as_the_controller_does(cell):
    response = cell.motions.check([], [-3], joints=["j"])
    assert response.verdict == CONTACT
    assert turned(response) == (pytest.approx(3 - 2 * pi), -3)
    assert response.message == ""


def test_a_request_says_which_way_is_meant(cell):
    for start in ([], [3]):
        response = cell.motions.check(start, [-3], joints=["j"], continuous_joint_direction=AS_GIVEN)
        assert (response.verdict, turned(response)) == (FREE, (3, -3))
        assert LONG in response.message
        response = cell.motions.check(start, [-3], joints=["j"], continuous_joint_direction=SHORTEST)
        assert (response.verdict, turned(response)) == (CONTACT, (pytest.approx(3 - 2 * pi), -3))
    assert cell.motions.check([3], [-3], joints=["j"]).verdict == FREE
    response = cell.motions.check([3], [-3], joints=["j"], continuous_joint_direction=3)
    assert (response.verdict, response.reason_code) == (ERROR, "bad_request")
    assert "continuous_joint_direction is 3" in response.message


def test_the_parameter_says_which_way_is_usual(cell):
    cell.parameters.succeed(continuous_joint_direction="as_given")
    response = cell.motions.check([], [-3], joints=["j"])
    assert (response.verdict, turned(response)) == (FREE, (3, -3))
    cell.parameters.succeed(continuous_joint_direction="shortest")
    assert cell.motions.check([], [-3], joints=["j"]).verdict == CONTACT


def test_the_certificate_holds_the_way_that_was_proven(cell):
    # by 1 rad backwards, not by nearly a whole turn onwards
    response = cell.motions.check([], [2 + 2 * pi], joints=["j"], certificate=True)
    assert (response.verdict, turned(response)) == (FREE, (pytest.approx(3 + 2 * pi), 2 + 2 * pi))
    motion = json.loads(cell.motions.certificate(response))["segments"][0]["motion"]
    assert (motion["from"], motion["to"]) == ([pytest.approx(3 + 2 * pi)], [2 + 2 * pi])


def test_trajectories_go_as_given_unless_asked(cell):
    message = JointTrajectory(joint_names=["j"])
    for second, position in enumerate((2.0, 3.0, -3.0)):
        point = JointTrajectoryPoint(positions=[position])
        point.time_from_start.sec = second
        message.points.append(point)
    response = cell.motions.follow(message)
    assert (response.verdict, turned(response)) == (FREE, (2, -3))
    assert "segment 1" in response.message and LONG in response.message
    response = cell.motions.follow(message, continuous_joint_direction=CheckTrajectory.Request.SHORTEST)
    assert (response.verdict, response.segment) == (CONTACT, 1)
    assert turned(response) == (pytest.approx(2 - 2 * pi), -3)
