"""Values that requests give for mimic joints: they move the joints that these mimic, or have to agree with them."""

from math import pi

import pytest
from clearance_msgs.action import CheckTrajectory
from clearance_msgs.srv import CheckMotion, CheckStates
from rclpy.action import ActionClient
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import two_link
from cell import Cell
from motions import Motions
from scene_client import SceneClient
from states import States

NEAR = 5 * pi / 6  # [rad] joint2, which the flag's joint `follower` mimics: free here, and again beyond the base
BEYOND = 7 * pi / 6
FOLLOWER = ("follower",)
BOTH = ("joint2", "follower")
CONTRADICTION = ("'follower'", "0.5", "'joint2'")


@pytest.fixture(scope="module")
def cell(module_peer, tmp_path_factory):
    folder = tmp_path_factory.mktemp("robot")
    urdf, srdf = folder / "robot.urdf", folder / "robot.srdf"
    urdf.write_text(two_link.description_with_follower())
    srdf.write_text(
        '<robot name="two_link"><group name="elbow"><joint name="joint2"/></group>'
        '<group name="flag"><joint name="follower"/></group>'
        '<disable_collisions link1="base" link2="upper" reason="Adjacent"/>'
        '<disable_collisions link1="upper" link2="tip" reason="Adjacent"/></robot>'
    )
    with Cell(module_peer, "--srdf", str(srdf), urdf=str(urdf)) as cell:
        cell.judged(joint1=0, joint2=0)
        cell.questions = States(module_peer, cell.node)
        cell.motions = Motions(module_peer, cell.node)
        cell.scene = SceneClient(cell)
        yield cell


def refused(answer, *named):
    assert (answer.verdict, answer.reason_code) == (0, "bad_request"), answer
    assert all(word in answer.message for word in named), answer.message


def trajectory(*states, joints, velocities=None):
    """One state a second."""
    message = JointTrajectory(joint_names=list(joints))
    for second, positions in enumerate(states):
        point = JointTrajectoryPoint(positions=[float(position) for position in positions])
        if velocities:
            point.velocities = [float(velocity) for velocity in velocities[second]]
        point.time_from_start.sec = second
        message.points.append(point)
    return message


def test_states_move_leaders_or_have_to_agree(cell):
    answer = cell.questions.check([(0,), (pi,)], joints=FOLLOWER)
    assert list(answer.verdicts) == [CheckStates.Response.FREE, CheckStates.Response.COLLIDING]
    assert answer.message == ""
    answer = cell.questions.check([(pi, pi)], joints=BOTH)
    assert answer.verdict == CheckStates.Response.COLLIDING
    refused(cell.questions.check([(0, 0), (0, 0.5)], joints=BOTH), "state 1", *CONTRADICTION)
    refused(cell.questions.check([(0, 0)], joints=("follower", "follower")), "'follower' is given twice")
    distances = cell.questions.distances((NEAR,), joints=FOLLOWER)
    assert distances.pairs[0].distance == pytest.approx(0.2)
    refused(cell.questions.distances((0, 0.5), joints=BOTH), *CONTRADICTION)


def test_motions_move_leaders_or_have_to_agree(cell):
    for joints, start, goal in (
        (FOLLOWER, [NEAR], [BEYOND]),
        (FOLLOWER, [], [BEYOND]),
        (BOTH, [NEAR, NEAR], [BEYOND, BEYOND]),
    ):
        answer = cell.motions.check(start, goal, joints=joints)
        assert answer.verdict == CheckMotion.Response.CONTACT, answer
    refused(cell.motions.check([0, 0], [0, 0.5], joints=BOTH), "goal", *CONTRADICTION)
    refused(cell.motions.check([0, 0.5], [0, 0], joints=BOTH), "start", *CONTRADICTION)


def test_tolerances_count_for_leaders(cell):
    answers = [
        cell.motions.check([0], [NEAR], joints=(joint,), joint_tolerances=[0.5]) for joint in ("joint2", "follower")
    ]
    assert [(answer.verdict, answer.reason_code) for answer in answers] == [(CheckMotion.Response.UNDECIDED, "tube")] * 2
    refused(cell.motions.check([0], [1], joints=FOLLOWER, joint_tolerances=[-0.5]), "'follower'", "-0.5")


def results(cell, message):
    """Of the service and of the action."""
    name = cell.node.private("check_trajectory")
    client = cell.peer.between_callbacks(lambda: ActionClient(cell.peer.node, CheckTrajectory, name))
    cell.peer.wait_for(client.server_is_ready, "the action")
    handle = cell.peer.result(client.send_goal_async(CheckTrajectory.Goal(trajectory=message)), "an accepted goal")
    result = cell.peer.result(handle.get_result_async(), "the result").result
    cell.peer.between_callbacks(client.destroy)
    return cell.motions.follow(message), result


def test_trajectories_move_leaders_or_have_to_agree(cell):
    for message in (
        trajectory([NEAR], [BEYOND], joints=FOLLOWER),
        trajectory([NEAR], [BEYOND], joints=FOLLOWER, velocities=[[1], [1]]),
        trajectory([NEAR, NEAR], [BEYOND, BEYOND], joints=BOTH, velocities=[[1, 1], [1, 1]]),
    ):
        for answer in results(cell, message):
            assert answer.verdict == CheckMotion.Response.CONTACT, answer
    for answer in results(cell, trajectory([0, 0], [0, 0.5], joints=BOTH)):
        refused(answer, "point 1", *CONTRADICTION)
    for answer in results(cell, trajectory([0, 0], [1, 1], joints=BOTH, velocities=[[0, 0.5], [0, 0]])):
        refused(answer, "point 0", *CONTRADICTION)


def test_state_validity_moves_leaders_or_refuses(cell):
    assert cell.scene.validity({"follower": 0}).valid
    assert not cell.scene.validity({"follower": pi}).valid
    assert not cell.scene.validity({"follower": pi, "joint2": pi}).valid
    answer = cell.scene.validity({"follower": 0.5, "joint2": 0})
    assert not answer.valid
    cell.scene.complaints.wait_for("check_state_validity", *CONTRADICTION)


def test_a_group_moves_what_mimics_its_joints(cell):
    assert not cell.scene.validity({"joint2": pi}, group="elbow").valid
    # the flag's joint moves its leader, and so the tip
    assert not cell.scene.validity({"joint2": pi}, group="flag").valid
