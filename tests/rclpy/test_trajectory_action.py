"""Tests of `~/check_trajectory` as an action, with rclpy's action client."""

from math import isnan, pi

import pytest
from action_msgs.msg import GoalStatus
from clearance_msgs.action import CheckTrajectory
from clearance_msgs.msg import CollisionState
from rclpy.action import ActionClient
from rclpy.action.graph import get_action_server_names_and_types_by_node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import two_link
from motions import Motions

FREE, CONTACT, UNDECIDED, ERROR = (
    CheckTrajectory.Result.FREE,
    CheckTrajectory.Result.CONTACT,
    CheckTrajectory.Result.UNDECIDED,
    CheckTrajectory.Result.ERROR,
)
TURNS = 5000  # of joint 1 in a segment, which takes some time to be proven
SEGMENTS = 400  # far more than are checked in a test


def trajectory(*states, joints=two_link.JOINTS):
    """One state a second."""
    message = JointTrajectory(joint_names=list(joints))
    for second, positions in enumerate(states):
        point = JointTrajectoryPoint(positions=[float(position) for position in positions])
        point.time_from_start.sec = second
        message.points.append(point)
    return message


def turning(segments):
    """There and back again: nothing ever touches, and each segment takes its time."""
    return trajectory(*((TURNS * 2 * pi * (i % 2), 0) for i in range(segments + 1)))


class Goals:
    """An action client, and the feedback that it gets."""

    def __init__(self, peer, node):
        self._peer = peer
        name = node.private("check_trajectory")
        # a client of an action is among the node's entities before it has its lock
        self._client = peer.between_callbacks(lambda: ActionClient(peer.node, CheckTrajectory, name))
        peer.wait_for(self._client.server_is_ready, "the action")

    def send(self, trajectory, **terms):
        """The handle of a goal, and its feedback up to now and from now on."""
        feedback = []
        goal = CheckTrajectory.Goal(trajectory=trajectory, **terms)
        note = lambda message: feedback.append(message.feedback)
        return self._call(lambda: self._client.send_goal_async(goal, note), "whether the goal is accepted"), feedback

    def result(self, handle):
        return self._call(handle.get_result_async, "the result")

    def cancel(self, handle):
        return self._call(handle.cancel_goal_async, "an answer to the cancellation")

    def _call(self, send, what):
        """The answer to a request. Jazzy's client drops an answer that arrives before it has noted its own request."""
        return self._peer.result(self._peer.between_callbacks(send), what)


@pytest.fixture
def goals(peer, cell):
    cell.evaluate(joint1=0, joint2=0)
    return Goals(peer, cell.node)


def test_results_are_those_of_the_service(peer, cell, goals):
    motions = Motions(peer, cell.node)
    for states, verdict in (
        (((0, 0), (1, 0), (1, 1)), FREE),
        (((0, 0), (0, 5 * pi / 6), (0, 7 * pi / 6)), CONTACT),
    ):
        handle, _ = goals.send(trajectory(*states), certificate=True)
        assert handle.accepted
        ended = goals.result(handle)
        assert ended.status == GoalStatus.STATUS_SUCCEEDED
        assert ended.result.verdict == verdict
        served = motions.follow(trajectory(*states), certificate=True)
        for field in served.get_fields_and_field_types():
            if field != "compute_time":
                # texts, since NaN is not equal to itself
                assert repr(getattr(ended.result, field)) == repr(getattr(served, field)), field


def test_a_goal_is_found_as_an_action(peer, cell, goals):
    def names():
        # the action may be discovered before the name of its node, without which the query fails
        if (cell.node.name, cell.node.namespace) not in peer.node.get_node_names_and_namespaces():
            return []
        return get_action_server_names_and_types_by_node(peer.node, cell.node.name, cell.node.namespace)

    expected = (cell.node.private("check_trajectory"), ["clearance_msgs/action/CheckTrajectory"])
    peer.wait_for(lambda: expected in names(), "the action in the graph")


def test_a_bad_goal_is_aborted_with_the_reason(goals):
    for bad, named in (
        (trajectory((0, 0)), "at least two points"),
        (trajectory((0, 0), (1, 1), joints=("joint1", "wrist")), "'wrist'"),
    ):
        handle, _ = goals.send(bad)
        ended = goals.result(handle)
        assert ended.status == GoalStatus.STATUS_ABORTED
        assert (ended.result.verdict, ended.result.reason_code) == (ERROR, "bad_request")
        assert named in ended.result.message


def test_progress_is_reported_and_grows(peer, goals):
    handle, feedback = goals.send(turning(SEGMENTS))
    peer.wait_for(lambda: len(feedback) >= 3, "progress")
    goals.cancel(handle)
    goals.result(handle)

    free = [message.segments_free for message in feedback]
    assert free == sorted(set(free)), "only what is new is told"
    for message in feedback:
        assert message.segments == SEGMENTS
        assert message.t_free == pytest.approx(message.segments_free / SEGMENTS)
        assert message.time_free == message.segments_free


def test_a_cancelled_check_stops_with_what_is_known(peer, cell, goals):
    handle, feedback = goals.send(turning(SEGMENTS))
    peer.wait_for(lambda: feedback and feedback[-1].segments_free >= 1, "the first segment")
    response = goals.cancel(handle)
    assert [bytes(goal.goal_id.uuid) for goal in response.goals_canceling] == [bytes(handle.goal_id.uuid)]
    ended = goals.result(handle)

    assert ended.status == GoalStatus.STATUS_CANCELED
    result = ended.result
    assert (result.verdict, result.reason_code) == (UNDECIDED, "canceled")
    assert feedback[-1].segments_free <= result.segment < SEGMENTS
    assert result.segment <= result.time_free <= result.segment + 1
    assert result.certificate == ""
    # Who comes next does not wait for it.
    handle, _ = goals.send(trajectory((0, 0), (1, 0)))
    assert goals.result(handle).result.verdict == FREE


def test_a_goal_that_waits_is_cancelled_at_once(peer, goals):
    first, feedback = goals.send(turning(SEGMENTS))
    peer.wait_for(lambda: feedback, "progress of the first")
    second, untold = goals.send(turning(SEGMENTS))
    goals.cancel(second)
    ended = goals.result(second)

    assert (ended.status, ended.result.reason_code) == (GoalStatus.STATUS_CANCELED, "canceled")
    assert (ended.result.verdict, ended.result.t_free) == (UNDECIDED, 0)
    assert isnan(ended.result.time_free)
    assert not untold
    peer.wait_for(lambda: first.status == GoalStatus.STATUS_EXECUTING, "its status")
    goals.cancel(first)
    assert goals.result(first).status == GoalStatus.STATUS_CANCELED


def test_what_has_ended_cannot_be_cancelled(goals):
    handle, _ = goals.send(trajectory((0, 0), (1, 0)))
    goals.result(handle)
    response = goals.cancel(handle)

    assert response.return_code == response.ERROR_GOAL_TERMINATED
    assert response.goals_canceling == []
    # The result is kept for who asks once more.
    assert goals.result(handle).status == GoalStatus.STATUS_SUCCEEDED


def test_a_node_with_too_many_goals_rejects_more_and_states_go_on(peer, cell, goals):
    handles = [goals.send(turning(SEGMENTS))[0] for _ in range(20)]
    accepted = [handle for handle in handles if handle.accepted]
    assert 16 <= len(accepted) <= 17 and handles[0].accepted
    assert cell.state_now().status == CollisionState.FREE

    for handle in accepted:
        goals.cancel(handle)
        assert goals.result(handle).status == GoalStatus.STATUS_CANCELED
    handle, _ = goals.send(trajectory((0, 0), (1, 0)))
    assert goals.result(handle).result.verdict == FREE
