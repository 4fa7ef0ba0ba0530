"""Tests of `~/check_motions` (batches) against `~/check_motion`, motion by motion."""

from math import inf, nan, pi

import numpy as np
import pytest
from clearance_msgs.msg import BodyPair
from clearance_msgs.srv import CheckMotions

import two_link
from cell import Cell
from motions import BURST, Motions
from scene import ball, diff
from scene_client import SceneClient
from two_link_srdf import SRDF

Response = CheckMotions.Response
ERROR, FREE, CONTACT, UNDECIDED = Response.ERROR, Response.FREE, Response.CONTACT, Response.UNDECIDED
MOST = 10_000  # motions of a batch
REASONS = {"": Response.REASON_NONE, "tolerance": Response.REASON_TOLERANCE, "tube": Response.REASON_TUBE}


class Batches:
    """Asks the service, and waits for its answers. `terms` are the other fields of the request, by name."""

    def __init__(self, peer, node):
        self._peer = peer
        self._client = peer.node.create_client(CheckMotions, node.private("check_motions"), qos_profile=BURST)
        peer.wait_for(self._client.service_is_ready, self._client.srv_name)

    def check(self, motions, joints=two_link.JOINTS, **terms):
        request = CheckMotions.Request(joint_names=list(joints), **terms)
        request.starts = [float(position) for start, _ in motions for position in start]
        request.goals = [float(position) for _, goal in motions for position in goal]
        return self._peer.result(self._client.call_async(request), "an answer of check_motions")


@pytest.fixture(scope="module")
def cell(module_peer, tmp_path_factory):
    path = tmp_path_factory.mktemp("robot") / "two_link.srdf"
    path.write_text(SRDF)
    with Cell(module_peer, "--srdf", path) as cell:
        cell.batches = Batches(module_peer, cell.node)
        cell.motions = Motions(module_peer, cell.node)
        cell.evaluate(joint1=0, joint2=0)
        yield cell


def random_motions(count):
    random = np.random.default_rng(3)
    starts = random.uniform(-2.5, 2.5, (count, 2))
    return [(tuple(start), tuple(start + random.uniform(-1.5, 1.5, 2))) for start in starts]


def bodies_of(response, i):
    indices = (response.pair_a[i], response.pair_b[i])
    return [response.bodies[index] if index >= 0 else "" for index in indices]


def assert_as_single(cell, motions, response, **terms):
    assert len(response.verdicts) == len(motions)
    for i, (start, goal) in enumerate(motions):
        single = cell.motions.check(start, goal, **terms)
        assert response.verdicts[i] == single.verdict, (start, goal, single)
        assert (response.t_free[i], response.t_contact[i]) == (single.t_free, single.t_contact)
        assert response.reasons[i] == REASONS[single.reason_code]
        assert bodies_of(response, i) == [single.pair.body_a, single.pair.body_b]


@pytest.mark.parametrize(
    "terms",
    [{}, {"any_contact": True}, {"joint_tolerances": [0.02, 0.02]}, {"tolerance": 0.05}],
    ids=["earliest", "any", "tube", "tolerance"],
)
def test_every_motion_gets_the_answer_of_check_motion(cell, terms):
    motions = random_motions(60)
    response = cell.batches.check(motions, **terms)

    assert response.reason_code == ""
    assert response.verdict == CONTACT and {FREE, CONTACT} <= set(response.verdicts)
    assert set(response.body_types) == {BodyPair.LINK}
    assert list(response.joint_names) == list(two_link.JOINTS)
    assert_as_single(cell, motions, response, **terms)


LISTS = ["lower", "upper", "t", "pair_a", "pair_b"]


def test_distances_are_those_of_check_motion(cell):
    motions, terms = random_motions(30), {"with_clearance": True, "event_distance": 0.3, "margin": 0.05}
    response = cell.batches.check(motions, **terms)
    assert_as_single(cell, motions, response, **terms)
    assert {Response.EVENT_FARTHER, Response.EVENT_REACHED} <= set(response.event_results)

    def names(a, b):
        return [response.bodies[index] if index >= 0 else "" for index in (a, b)]

    for i, (start, goal) in enumerate(motions):
        single = cell.motions.check(start, goal, **terms)
        for kind, least in (("self", single.self_clearance), ("world", single.world_clearance)):
            lower, upper, t, a, b = (getattr(response, f"{kind}_{name}")[i] for name in LISTS)
            assert (lower, upper) == (least.lower, least.upper)
            assert t == least.t or (np.isnan(t) and np.isnan(least.t))
            assert names(a, b) == [least.nearest.pair.body_a, least.nearest.pair.body_b]
        assert response.clearance_reasons[i] == REASONS[single.clearance_reason_code]
        event = single.event
        assert response.event_results[i] == event.result and response.event_reasons[i] == REASONS[event.reason_code]
        assert (response.event_t_farther[i], response.event_t_reached[i]) == (event.t_farther, event.t_reached)
        assert names(response.event_pair_a[i], response.event_pair_b[i]) == [event.pair.body_a, event.pair.body_b]

    without = cell.batches.check(motions)
    lists = [f"{kind}_{name}" for kind in ("self", "world") for name in LISTS] + ["clearance_reasons", "event_results"]
    lists += ["event_reasons", "event_t_farther", "event_t_reached", "event_pair_a", "event_pair_b"]
    assert [len(getattr(without, name)) for name in lists] == [0] * len(lists)


def test_distances_that_the_timeout_left_out_claim_nothing(cell):
    response = cell.batches.check([((0, 0), (1, 1))] * 3, timeout=1e-9, with_clearance=True, event_distance=0.1)
    assert response.reason_code == "deadline"
    assert list(response.self_lower) == [0] * 3 and list(response.self_upper) == [inf] * 3
    assert list(response.clearance_reasons) == list(response.event_reasons) == [Response.REASON_DEADLINE] * 3
    assert list(response.event_results) == [Response.EVENT_UNDECIDED] * 3


def test_a_group_names_the_joints(cell):
    response = cell.batches.check([((0,), (1,)), ((0,), (pi,))], joints=[], group="wrist")
    assert list(response.joint_names) == ["joint2"]
    assert list(response.verdicts) == [FREE, CONTACT]
    named = cell.batches.check([((0,), (1,)), ((0,), (pi,))], joints=["joint2"])
    assert list(named.t_contact) == list(response.t_contact)


def test_other_joints_stand_where_they_are_given(cell):
    turn = [((0,), (1,))]
    assert cell.batches.check(turn, joints=["joint1"]).verdict == FREE
    folded = cell.batches.check(turn, joints=["joint1"], other_joints=["joint2"], other_positions=[pi])
    assert list(folded.verdicts) == [CONTACT] and list(folded.t_contact) == [0.0]


@pytest.mark.parametrize(
    ("motions", "terms", "named"),
    [
        ([((0, 0), (1, 1))], {"joints": ["joint1", "wrist"]}, "'wrist'"),
        ([((0, 0), (1, 1))], {"joints": ["joint1", "joint1"]}, "'joint1' is given twice"),
        ([((0, 0), (1, 1))], {"joints": []}, "joint_names is empty"),
        ([((0, 0), (1, 1))], {"group": "arm"}, "both joint_names and group"),
        ([((0, 0), (1, 1))], {"joints": [], "group": "leg"}, "no group 'leg'"),
        ([], {}, "starts has 0"),
        ([((0, 0), (1, 1)), ((0,), (1,))], {}, "starts has 3"),
        ([((0, 0), (1, 1)), ((0, 0), ())], {}, "goals has 2 numbers, but starts has 4"),
        ([((0, 0), (1, 1)), ((0, 0), (0, nan))], {}, "motion 1: goal: joint 'joint2' has position NaN"),
        ([((inf, 0), (1, 1))], {}, "motion 0: start: joint 'joint1' has position inf"),
        ([((0, 0), (1, 1))] * (MOST + 1), {}, "10001 motions"),
        ([((0, 0), (1, 1))], {"timeout": -1.0}, "timeout is -1"),
        ([((0, 0), (1, 1))], {"tolerance": nan}, "tolerance is NaN"),
        ([((0, 0), (1, 1))], {"margin": nan}, "margin is NaN"),
        ([((0, 0), (1, 1))], {"event_distance": inf}, "event_distance is inf"),
        ([((0, 0), (1, 1))], {"joint_tolerances": [0.1]}, "joint_tolerances has 1"),
        ([((0, 0), (1, 1))], {"continuous_joint_direction": 9}, "continuous_joint_direction is 9"),
        ([((0, 0), (1, 1))], {"other_joints": ["joint1"], "other_positions": [0.0]}, "'joint1' is given twice"),
        ([((0,), (1,))], {"joints": ["joint1"], "other_joints": ["joint2"]}, "other_positions has 0"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_bad_batch_is_rejected_by_name(cell, motions, terms, named):
    response = cell.batches.check(motions, **terms)

    assert (response.verdict, response.reason_code) == (ERROR, "bad_request")
    assert named in response.message
    assert len(response.message) < 500
    assert len(response.verdicts) == len(response.joint_names) == 0


def test_a_timeout_leaves_motions_undecided_and_never_free(cell):
    response = cell.batches.check([((0, 0), (1, 1))] * 3, timeout=1e-9)
    assert (response.verdict, response.reason_code) == (UNDECIDED, "deadline")
    assert list(response.verdicts) == [UNDECIDED] * 3
    assert list(response.reasons) == [Response.REASON_DEADLINE] * 3
    assert list(response.t_free) == [0.0] * 3


@pytest.mark.parametrize("more", [{}, {"with_clearance": True, "event_distance": 0.05}])
def test_a_batch_of_the_most_motions_arrives_whole(cell, more):
    motions = [((0, pi * i / MOST), (0, pi * (i + 1) / MOST)) for i in range(MOST)]
    response = cell.batches.check(motions, **more)
    if more:
        assert len(response.world_lower) == len(response.event_t_reached) == MOST

    assert len(response.verdicts) == len(response.t_free) == len(response.pair_a) == MOST
    first = next(i for i, verdict in enumerate(response.verdicts) if verdict != FREE)
    assert motions[first][0][1] <= two_link.FIRST_TOUCH <= motions[first][1][1]
    assert set(response.verdicts[:first]) == {FREE} and FREE not in response.verdicts[first:]


def test_batches_follow_the_world(start):
    cell = start()
    batches, scene = Batches(cell.peer, cell.node), SceneClient(cell)
    cell.evaluate(joint1=0, joint2=0)
    motions = [((-1, 0), (1, 0)), ((1, 0), (2, 0))]
    before = batches.check(motions)
    assert list(before.verdicts) == [FREE, FREE]

    assert scene.apply(diff(ball("in the way", 2, 0, radius=0.2)))
    after = batches.check(motions)
    assert list(after.verdicts) == [CONTACT, FREE]
    assert after.world_revision > before.world_revision and after.model_revision == before.model_revision
    assert "in the way" in bodies_of(after, 0)
    assert BodyPair.OBSTACLE in after.body_types


def test_without_a_model_there_is_an_error(start):
    cell = start(urdf=None)
    response = Batches(cell.peer, cell.node).check([((0, 0), (1, 1))])
    assert (response.verdict, response.reason_code, response.model_revision) == (ERROR, "no_model", 0)
    assert response.message
