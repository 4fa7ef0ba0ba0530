"""Tests of values of mimic joints in requests and in joint states.

In a request, the value of a mimic joint sets the joint that it mimics. If both have values, they must agree. In a joint
state, they must always agree.
"""

from math import inf, nan, pi

import pytest
from clearance_msgs.action import CheckTrajectory
from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckMotion, CheckStates
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import two_link
from cell import Cell, Companions
from fail_safe import NOTHING_KNOWN, ZERO
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
        cell.evaluate(joint1=0, joint2=0)
        cell.questions = States(module_peer, cell.node)
        cell.motions = Motions(module_peer, cell.node)
        cell.scene = SceneClient(cell)
        yield cell


def rejected(response, *named):
    assert (response.verdict, response.reason_code) == (0, "bad_request"), response
    assert all(word in response.message for word in named), response.message


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
    response = cell.questions.check([(0,), (pi,)], joints=FOLLOWER)
    assert list(response.verdicts) == [CheckStates.Response.FREE, CheckStates.Response.COLLIDING]
    assert response.message == ""
    response = cell.questions.check([(pi, pi)], joints=BOTH)
    assert response.verdict == CheckStates.Response.COLLIDING
    rejected(cell.questions.check([(0, 0), (0, 0.5)], joints=BOTH), "state 1", *CONTRADICTION)
    rejected(cell.questions.check([(0, 0)], joints=("follower", "follower")), "'follower' is given twice")
    distances = cell.questions.distances((NEAR,), joints=FOLLOWER)
    assert distances.pairs[0].distance == pytest.approx(0.2)
    rejected(cell.questions.distances((0, 0.5), joints=BOTH), *CONTRADICTION)


def test_motions_move_leaders_or_have_to_agree(cell):
    for joints, start, goal in (
        (FOLLOWER, [NEAR], [BEYOND]),
        (FOLLOWER, [], [BEYOND]),
        (BOTH, [NEAR, NEAR], [BEYOND, BEYOND]),
    ):
        response = cell.motions.check(start, goal, joints=joints)
        assert response.verdict == CheckMotion.Response.CONTACT, response
    rejected(cell.motions.check([0, 0], [0, 0.5], joints=BOTH), "goal", *CONTRADICTION)
    rejected(cell.motions.check([0, 0.5], [0, 0], joints=BOTH), "start", *CONTRADICTION)


def test_tolerances_count_for_leaders(cell):
    responses = [
        cell.motions.check([0], [NEAR], joints=(joint,), joint_tolerances=[0.5]) for joint in ("joint2", "follower")
    ]
    assert [(response.verdict, response.reason_code) for response in responses] == [(CheckMotion.Response.UNDECIDED, "tube")] * 2
    rejected(cell.motions.check([0], [1], joints=FOLLOWER, joint_tolerances=[-0.5]), "'follower'", "-0.5")


def results(cell, message):
    """Of the service and of the action."""
    name = cell.node.private("check_trajectory")
    client = cell.peer.between_callbacks(lambda: ActionClient(cell.peer.node, CheckTrajectory, name))
    cell.peer.wait_for(client.server_is_ready, "the action")
    handle = cell.peer.between_callbacks(lambda: client.send_goal_async(CheckTrajectory.Goal(trajectory=message)))
    handle = cell.peer.result(handle, "an accepted goal")
    result = cell.peer.result(cell.peer.between_callbacks(handle.get_result_async), "the result").result
    cell.peer.between_callbacks(client.destroy)
    return cell.motions.follow(message), result


def test_trajectories_move_leaders_or_have_to_agree(cell):
    for message in (
        trajectory([NEAR], [BEYOND], joints=FOLLOWER),
        trajectory([NEAR], [BEYOND], joints=FOLLOWER, velocities=[[1], [1]]),
        trajectory([NEAR, NEAR], [BEYOND, BEYOND], joints=BOTH, velocities=[[1, 1], [1, 1]]),
    ):
        for response in results(cell, message):
            assert response.verdict == CheckMotion.Response.CONTACT, response
    for response in results(cell, trajectory([0, 0], [0, 0.5], joints=BOTH)):
        rejected(response, "point 1", *CONTRADICTION)
    for response in results(cell, trajectory([0, 0], [1, 1], joints=BOTH, velocities=[[0, 0.5], [0, 0]])):
        rejected(response, "point 0", *CONTRADICTION)


def test_state_validity_moves_leaders_or_rejects_the_state(cell):
    assert cell.scene.validity({"follower": 0}).valid
    assert not cell.scene.validity({"follower": pi}).valid
    assert not cell.scene.validity({"follower": pi, "joint2": pi}).valid
    response = cell.scene.validity({"follower": 0.5, "joint2": 0})
    assert not response.valid
    cell.scene.complaints.wait_for("check_state_validity", *CONTRADICTION)


def test_a_group_moves_what_mimics_its_joints(cell):
    assert not cell.scene.validity({"joint2": pi}, group="elbow").valid
    # the flag's joint moves its leader, and so the tip
    assert not cell.scene.validity({"joint2": pi}, group="flag").valid


# Reports of `follower` while joint2 is at 0.
WRONG = {
    "beyond the play of gears": (0.03, "contradiction"),
    "far off": (1.5, "contradiction"),
    "a whole turn off": (2 * pi, "contradiction"),
    "NaN": (nan, "non_finite"),
    "infinite": (-inf, "non_finite"),
    "absurd": (1e300, "malformed"),
}


@pytest.fixture
def reporting(cell):
    """The same node, with what it publishes beside `~/state`; afterwards a right report takes the place of the last one."""
    cell.companions = Companions(cell)
    yield cell
    cell.parameters.succeed(mimic_contradiction="unknown")
    cell.evaluate(**ZERO, follower=0.0)


def nothing_is_known(cell, state, reason_code):
    assert (state.status, state.reason_code) == (CollisionState.UNKNOWN, reason_code), state
    assert "'follower'" in state.reason
    said = cell.companions.of(state)
    assert all(is_nothing(said[name]) for name, is_nothing in NOTHING_KNOWN.items()), said


@pytest.mark.parametrize(("position", "reason_code"), WRONG.values(), ids=WRONG)
def test_a_wrong_report_is_never_free(reporting, position, reason_code):
    nothing_is_known(reporting, reporting.evaluate(**ZERO, follower=position), reason_code)
    assert reporting.evaluate(**ZERO, follower=0.01).status == CollisionState.FREE


@pytest.mark.parametrize(("position", "reason_code"), WRONG.values(), ids=WRONG)
def test_a_wrong_report_of_another_publisher_is_never_free(reporting, position, reason_code):
    reporting.evaluate(**ZERO)
    other = two_link.Driver(reporting.peer, reporting.node.relative("joint_states"))
    other.report(follower=position)
    nothing_is_known(reporting, reporting.unknown(reason_code), reason_code)
    other.report(follower=0.0)
    reporting.becomes(CollisionState.FREE, "FREE after a right report")
    other.disconnect()


def test_a_mimic_joint_that_is_reported_twice_is_malformed(reporting):
    reporting.evaluate(**ZERO)
    reporting.driver.pause()
    publisher = reporting.peer.node.create_publisher(JointState, reporting.node.relative("joint_states"), 10)
    message = JointState(name=["joint1", "joint2", "follower", "follower"], position=[0.0] * 4)

    def malformed():
        message.header.stamp = reporting.peer.now().to_msg()
        publisher.publish(message)
        return next((state for state in reporting.states.after(start) if state.reason_code == "malformed"), None)

    start = reporting.peer.now()
    nothing_is_known(reporting, reporting.peer.wait_for(malformed, "the reason malformed"), "malformed")
    reporting.peer.node.destroy_publisher(publisher)
    reporting.driver.resume()


def test_services_start_from_no_state_that_contradicts_itself(reporting):
    reporting.evaluate(**ZERO, follower=1.5)
    for response in (
        reporting.motions.check([], [0.1], joints=("joint1",)),
        reporting.questions.distances(),
        reporting.questions.check([(0.1,)], joints=("joint1",)),
    ):
        assert (response.verdict, response.reason_code) == (CheckStates.Response.ERROR, "no_joint_state")
        assert "'follower' is reported at 1.5" in response.message
    assert not reporting.scene.validity({"joint1": 0.1}).valid
    # what names all joints depends on no joint state
    assert reporting.scene.validity({"joint1": 0.1, "joint2": 0.0}).valid


def test_contradictions_are_warnings_if_that_is_wanted(reporting):
    reporting.evaluate(**ZERO, follower=1.5)
    reporting.parameters.succeed(mimic_contradiction="warn")
    state = reporting.becomes(CollisionState.FREE, "FREE with a warning")
    assert any("'follower' is reported at 1.5, but it mimics 'joint2'" in text for text in state.warnings)
    for position, reason_code in WRONG.values():
        if reason_code != "contradiction":
            nothing_is_known(reporting, reporting.evaluate(**ZERO, follower=position), reason_code)
