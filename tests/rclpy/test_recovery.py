"""Tests of recovery from collisions: `~/find_free_state` and `~/retreat_direction`."""

from math import asin, hypot, inf, nan, pi

import pytest
from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckStates, FindFreeState
from sensor_msgs.msg import JointState

import two_link
from motions import BURST
from scene import ball
from scene_client import SceneClient
from states import States
from two_link_srdf import SRDF

ERROR, ALREADY_FREE, FOUND, NONE_FOUND = (
    FindFreeState.Response.ERROR,
    FindFreeState.Response.ALREADY_FREE,
    FindFreeState.Response.FOUND,
    FindFreeState.Response.NONE_FOUND,
)
FREE, COLLIDING = CheckStates.Response.FREE, CheckStates.Response.COLLIDING
STRETCHED = (0, 0)
# The ball of the tip is in the cube of the base: in its middle, and 0.041 m deep in one of its faces.
ONTO = (0, pi)
SHALLOW = (0, 11 * pi / 12)
LEAST = asin(0.3)  # [rad] that joint2 alone has to turn from ONTO
PLENTY = 60.0  # [s] no search is cut off on a busy machine
STEP = 0.01  # [rad] along a direction


def positions(state):
    return dict(zip(two_link.JOINTS, state, strict=True))


class Recovery:
    """Asks for free states, and for the states beside them. `terms` are fields of the request, by name."""

    def __init__(self, cell):
        self._peer = cell.peer
        name = cell.node.private("find_free_state")
        self._client = cell.peer.node.create_client(FindFreeState, name, qos_profile=BURST)
        cell.peer.wait_for(self._client.service_is_ready, name)

    def find(self, state=(), joints=two_link.JOINTS, **terms):
        request = FindFreeState.Request(**({"timeout": PLENTY} | terms))
        request.joint_names = list(joints) if state else []
        request.positions = [float(position) for position in state]
        return self._peer.result(self._client.call_async(request), "a free state")


@pytest.fixture
def arm(start, tmp_path):
    """A cell with groups, whose robot is in collision."""
    path = tmp_path / "two_link.srdf"
    path.write_text(SRDF)
    cell = start("--srdf", path)
    cell.evaluate(**positions(ONTO))
    cell.recovery = Recovery(cell)
    return cell


def on_line(response, t):
    return [a + t * (b - a) for a, b in zip(response.start, response.free_state, strict=True)]


@pytest.mark.parametrize("clearance", [0.0, 0.05])
def test_a_found_state_is_free_and_so_is_the_way_to_it_from_the_exit_on(arm, clearance):
    response = arm.recovery.find(ONTO, clearance=clearance)

    assert (response.result, response.message, response.reason_code) == (FOUND, "", "")
    assert (response.joint_names, list(response.start)) == (list(two_link.JOINTS), [float(q) for q in ONTO])
    assert response.distance == pytest.approx(hypot(*(b - a for a, b in zip(response.start, response.free_state))))
    # a turn of both joints may be shorter than that of joint2 alone, but not by much
    assert 0.5 * LEAST < response.distance < 1.3 * LEAST + 2 * clearance
    assert (response.model_revision, response.world_revision) == (1, 0) and response.compute_time > 0

    states = States(arm.peer, arm.node)
    rest = [on_line(response, response.exit + share / 50 * (1 - response.exit)) for share in range(51)]
    checked = states.check(rest + [response.free_state], with_distance=True)
    assert list(checked.verdicts) == [FREE] * 52
    assert checked.distances[-1] >= clearance
    assert states.check([on_line(response, 0.9 * response.exit)]).verdict == COLLIDING


def test_without_names_the_search_begins_where_the_robot_is(arm):
    response = arm.recovery.find()
    assert (response.result, list(response.start)) == (FOUND, list(ONTO))
    # what is found there is free in ~/state too
    assert arm.evaluate(**positions(response.free_state)).status == CollisionState.FREE
    response = arm.recovery.find()
    assert (response.result, len(response.free_state), response.distance) == (ALREADY_FREE, 0, 0.0)


def test_only_what_may_move_moves(arm):
    for terms in ({"group": "wrist"}, {"locked_joints": ["joint1"]}):
        response = arm.recovery.find(ONTO, **terms)
        assert (response.result, response.free_state[0]) == (FOUND, 0.0)
        assert response.distance == pytest.approx(LEAST, abs=0.01)
    response = arm.recovery.find(ONTO, locked_joints=list(two_link.JOINTS))
    assert (response.result, response.reason_code, len(response.free_state)) == (NONE_FOUND, "not_movable", 0)
    assert {response.unmoved_pair.body_a, response.unmoved_pair.body_b} == {"base", "tip"}
    assert "'base'" in response.message and "'tip'" in response.message


def test_none_is_found_beyond_the_limits(arm):
    response = arm.recovery.find(ONTO, max_distance=0.1)
    assert (response.result, response.reason_code, len(response.free_state)) == (NONE_FOUND, "beyond_limits", 0)
    assert "max_distance" in response.message
    response = arm.recovery.find(ONTO, timeout=1e-9)
    assert (response.result, response.reason_code) == (NONE_FOUND, "unfinished") and "timeout" in response.message


@pytest.mark.parametrize(
    ("terms", "words"),
    [
        ({"joints": ["joint1", "wrist"]}, "joint_names: the robot has no joint 'wrist'"),
        ({"joints": ["joint1"]}, "positions has 2 numbers, but joint_names has 1 names"),
        ({"state": (0, nan)}, "positions: joint 'joint2' has position NaN"),
        ({"group": "leg"}, "group: the robot has no group 'leg'; its SRDF has 'arm' and 'wrist'"),
        ({"locked_joints": ["elbow"]}, "locked_joints: the robot has no joint 'elbow'; it has 'joint1' and 'joint2'"),
        ({"max_distance": -1.0}, "max_distance is -1 rad or m, but must be finite and not negative"),
        ({"clearance": nan}, "clearance is NaN m"),
        ({"timeout": -inf}, "timeout is -inf s"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_a_broken_request_is_rejected_by_name(arm, terms, words):
    response = arm.recovery.find(**({"state": ONTO} | terms))
    assert (response.result, response.reason_code) == (ERROR, "bad_request")
    assert words in response.message
    assert (response.joint_names, len(response.start), len(response.free_state)) == ([], 0, 0)


def test_without_a_model_or_a_joint_state_nothing_is_searched(start):
    response = Recovery(start(urdf=None)).find(ONTO)
    assert (response.result, response.reason_code) == (ERROR, "no_model")
    silent = start(driving=False)
    silent.has_model()
    response = Recovery(silent).find()
    assert (response.result, response.reason_code) == (ERROR, "no_joint_state")


@pytest.fixture
def retreating(start):
    """A cell that publishes directions, and their record."""
    cell = start(parameters={"retreat_rate": 50.0})
    cell.directions = cell.peer.record(JointState, cell.node.private("retreat_direction"))
    cell.peer.wait_for(
        lambda: cell.peer.node.count_publishers(cell.node.private("retreat_direction")) == 1, "~/retreat_direction"
    )
    return cell


def direction_of(state):
    """Accepts the directions of a joint state as of this one, or of later ones."""
    stamp = (state.header.stamp.sec, state.header.stamp.nanosec)
    return lambda said: said.name and (said.header.stamp.sec, said.header.stamp.nanosec) >= stamp


def test_a_direction_is_a_unit_vector_that_leads_out(retreating):
    at = list(SHALLOW)
    # the ball is 0.041 m deep, on a lever of a metre
    for _ in range(20):
        state = retreating.evaluate(**positions(at))
        if state.status == CollisionState.FREE:
            break
        said = retreating.directions.ever(direction_of(state), f"a direction of {at}")
        assert (said.name, said.header.frame_id) == (list(two_link.JOINTS), "base")
        assert (len(said.position), len(said.effort)) == (0, 0)
        assert hypot(*said.velocity) == pytest.approx(1, abs=1e-9)
        at = [position + STEP * velocity for position, velocity in zip(at, said.velocity, strict=True)]
    assert state.status == CollisionState.FREE, at
    assert at != list(SHALLOW)


def test_outside_of_a_collision_the_direction_is_withdrawn_once(retreating):
    state = retreating.evaluate(**positions(SHALLOW))
    direction = retreating.directions.ever(direction_of(state), "a direction")
    retreating.evaluate(**positions(STRETCHED))
    withdrawn = retreating.directions.wait_for(lambda said: not said.name, "no direction", after=direction)
    assert (len(withdrawn.velocity), withdrawn.header.frame_id) == (0, "base")
    # a direction of a later collision follows the only message that withdrew the one before
    state = retreating.evaluate(**positions(SHALLOW))
    direction = retreating.directions.ever(direction_of(state), "a direction")
    between = retreating.directions.after(withdrawn)
    assert all(said.name for said in between) and direction in between

    # a joint state that is no number is UNKNOWN
    retreating.evaluate(joint1=0, joint2=nan)
    retreating.directions.wait_for(lambda said: not said.name, "no direction", after=direction)


def test_where_no_joint_helps_there_is_no_direction(retreating):
    state = retreating.evaluate(**positions(SHALLOW))
    direction = retreating.directions.ever(direction_of(state), "a direction")
    # deeper than the tip, and no joint moves the base
    SceneClient(retreating).change(ball("ball", 0))
    retreating.directions.wait_for(lambda said: not said.name, "no direction", after=direction)
    retreating.peer.wait_for(
        lambda: "~/retreat_direction is empty: no joint velocity reduces" in retreating.node.output(), "the reason"
    )


def test_directions_are_off_until_the_parameter_turns_them_on(cell):
    directions = cell.peer.record(JointState, cell.node.private("retreat_direction"))
    state = cell.evaluate(**positions(SHALLOW))
    cell.states.more(10, after=state)
    assert directions.all() == []

    cell.parameters.succeed(retreat_rate=50.0)
    direction = directions.ever(direction_of(state), "a direction")
    cell.parameters.succeed(retreat_rate=0.0)
    last = directions.wait_for(lambda said: not said.name, "no direction", after=direction)
    cell.states.more(10, after=cell.state_now())
    assert directions.after(last) == []


@pytest.mark.parametrize("rate", [-1.0, 100.1, nan])
def test_a_rate_out_of_range_is_rejected(cell, rate):
    (result,) = cell.parameters.set(retreat_rate=rate)
    assert not result.successful and "retreat_rate" in result.reason
