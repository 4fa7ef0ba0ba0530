"""Tests of `~/check_motion` and `~/check_trajectory` against hand-computed results."""

import json
import re
from math import asin, cos, inf, isnan, nan, pi, sin

import pytest
from clearance_msgs.msg import BodyPair, CollisionState, DistanceEvent
from clearance_msgs.srv import CheckMotion, CheckTrajectory
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import two_link
from cell import STALE_AFTER, Cell
from motions import Motions
from scene import ball, diff
from scene_client import SceneClient
from swept_volumes import capsules, colours, room

NEAR = (0, 5 * pi / 6)  # folded, still free
BEYOND = (0, 7 * pi / 6)  # the mirror image of it: free too, but between them the ball meets the cube
TOUCH = (two_link.FIRST_TOUCH - NEAR[1]) / (BEYOND[1] - NEAR[1])  # fraction of the way from NEAR to BEYOND


@pytest.fixture(scope="module")
def cell(module_peer):
    """One node answers for the whole module: every question here leaves it as it was."""
    with Cell(module_peer) as cell:
        cell.motions = Motions(module_peer, cell.node)
        cell.evaluate(joint1=0, joint2=0)
        yield cell


def trajectory(*points, joints=two_link.JOINTS):
    """Points as (positions, seconds) or (positions, seconds, velocities)."""
    message = JointTrajectory(joint_names=list(joints))
    for positions, seconds, *velocities in points:
        point = JointTrajectoryPoint(positions=[float(position) for position in positions])
        point.velocities = [float(velocity) for velocity in velocities[0]] if velocities else []
        point.time_from_start.sec = int(seconds)
        point.time_from_start.nanosec = round(seconds % 1 * 1e9)
        message.points.append(point)
    return message


STRAIGHT = trajectory(((0, 0), 0), ((1, 1), 1))


def between(start, goal, t):
    joint1, joint2 = (a + t * (b - a) for a, b in zip(start, goal, strict=True))
    return {"joint1": joint1, "joint2": joint2}


def assert_proven(certificate, segments, ends):
    """Every pair is apart throughout: its intervals cover [0, 1] in every segment, and in each it keeps more than it may lose."""
    proof = json.loads(certificate)
    assert proof["robot"] == "two_link"
    assert proof["joints"] == list(two_link.JOINTS)
    assert [set(pair) for pair in proof["pairs"]] == [{"base", "tip"}]
    assert len(proof["segments"]) == segments
    assert proof["segments"][0]["motion"]["from"] == pytest.approx(ends[0])
    assert proof["segments"][-1]["motion"]["to"] == pytest.approx(ends[1])
    for segment in proof["segments"]:
        reached = 0.0
        for pair, begin, end, lower, bound in segment["proofs"]:
            assert pair == 0
            assert begin <= reached < end
            assert lower > bound >= 0
            reached = end
        assert reached == 1.0


def test_a_free_motion_is_proven(cell):
    response = cell.motions.check((0, 0), (pi / 2, pi / 2), certificate=True)

    assert response.verdict == CheckMotion.Response.FREE
    assert (response.message, response.reason_code) == ("", "")
    assert (response.t_free, response.t_contact) == (1, 1)
    assert (response.pair.body_a, response.pair.body_b) == ("", "")
    assert not response.witness_known
    assert (response.distance_lower, response.distance_upper) == (0, inf)
    assert (response.model_revision, response.world_revision) == (1, 0)
    assert 0 < response.compute_time < 1
    assert_proven(cell.motions.certificate(response), 1, ((0, 0), (pi / 2, pi / 2)))
    without = cell.motions.check((0, 0), (pi / 2, pi / 2))
    assert (without.certificate, without.certificate_digest) == ("", "")


def test_a_contact_between_free_ends_is_found_where_it_is(cell):
    # The robot jumps to the other end.
    cell.parameters.succeed(check_between_states=False)
    for end in (NEAR, BEYOND):
        assert cell.evaluate(**between(end, end, 0)).status == CollisionState.FREE
    response = cell.motions.check(NEAR, BEYOND)

    assert response.verdict == CheckMotion.Response.CONTACT
    assert {response.pair.body_a, response.pair.body_b} == {"base", "tip"}
    assert response.t_free <= TOUCH <= response.t_contact
    assert response.t_contact - response.t_free < 1e-3
    assert response.witness_known
    # On the cube's upper face, where the ball comes down.
    assert response.witness_point.y == pytest.approx(0.2, abs=2e-3)
    assert (response.distance_lower, response.distance_upper) == (0, 0)
    assert response.certificate == ""

    # What it says is what a joint state there gets.
    assert cell.evaluate(**between(NEAR, BEYOND, 0.999 * response.t_free)).status == CollisionState.FREE
    assert cell.evaluate(**between(NEAR, BEYOND, response.t_contact)).status == CollisionState.COLLIDING


def test_any_contact_will_do(cell):
    response = cell.motions.check(NEAR, BEYOND, any_contact=True)

    assert response.verdict == CheckMotion.Response.CONTACT
    assert response.t_free == 0
    assert cell.evaluate(**between(NEAR, BEYOND, response.t_contact)).status == CollisionState.COLLIDING


@pytest.mark.parametrize("goal", [(0, 2.8), (1, pi)])
def test_every_sample_of_a_verdict_agrees_with_the_state(cell, goal):
    response = cell.motions.check((0, 0), goal)

    for i in range(21):
        t = i / 20
        status = cell.evaluate(**between((0, 0), goal, t)).status
        if t < response.t_free:
            assert status == CollisionState.FREE
    expected = CheckMotion.Response.FREE if goal[1] < pi else CheckMotion.Response.CONTACT
    assert response.verdict == expected


def test_what_the_tube_leaves_open_is_undecided(cell):
    response = cell.motions.check((0, 0), NEAR, joint_tolerances=[0.0, 0.5])

    assert response.verdict == CheckMotion.Response.UNDECIDED
    assert response.reason_code == "tube"
    assert "base" in response.message and "tip" in response.message
    assert 0 < response.t_free <= response.t_contact <= 1
    # Half a radian before the first touch it is open at the latest; how much earlier depends on the bound on what half a radian does.
    assert 1.5 < response.t_free * NEAR[1] <= two_link.FIRST_TOUCH - 0.5
    assert cell.motions.check((0, 0), NEAR, joint_tolerances=[0.0, 0.1]).verdict == CheckMotion.Response.FREE


def test_a_timeout_is_undecided(cell):
    response = cell.motions.check((0, 0), (0, 2.83), timeout=1e-9)

    assert response.verdict == CheckMotion.Response.UNDECIDED
    assert response.reason_code == "deadline"
    assert response.message
    assert cell.motions.check((0, 0), (0, 2.83), timeout=60.0).verdict == CheckMotion.Response.FREE


def test_a_motion_begins_at_the_current_joint_state(cell):
    cell.evaluate(joint1=0.5, joint2=NEAR[1])
    response = cell.motions.check((), (0.7,), joints=["joint1"], certificate=True)
    assert response.verdict == CheckMotion.Response.FREE
    assert_proven(cell.motions.certificate(response), 1, ((0.5, NEAR[1]), (0.7, NEAR[1])))

    cell.evaluate(joint1=0, joint2=pi)
    response = cell.motions.check((), (0.7,), joints=["joint1"])
    assert (response.verdict, response.t_free, response.t_contact) == (CheckMotion.Response.CONTACT, 0, 0)


def test_without_a_joint_state_there_is_no_start(start):
    cell = start(driving=False)
    motions = Motions(cell.peer, cell.node)
    cell.has_model()
    response = motions.check((), (0, 0))
    assert (response.verdict, response.reason_code) == (CheckMotion.Response.ERROR, "no_joint_state")

    response = motions.check((0,), (1,), joints=["joint1"])
    assert response.verdict == CheckMotion.Response.FREE
    assert "'joint2'" in response.message

    cell.driver.resume()
    cell.evaluate(joint1=0, joint2=0)
    assert motions.check((), (0, 1)).verdict == CheckMotion.Response.FREE
    cell.grows_old()
    cell.driver.pause()
    cell.unknown("stale")
    response = motions.check((), (0, 1))
    assert (response.verdict, response.reason_code) == (CheckMotion.Response.ERROR, "no_joint_state")
    assert f"stale_after is {STALE_AFTER:g} s" in response.message


def test_without_a_model_there_is_an_error(start):
    cell = start(urdf=None)
    motions = Motions(cell.peer, cell.node)

    for response in (motions.check((0, 0), (1, 1)), motions.follow(STRAIGHT)):
        assert (response.verdict, response.reason_code, response.model_revision) == (CheckMotion.Response.ERROR, "no_model", 0)
        assert response.message


def test_a_world_that_is_not_known_is_an_error(start):
    cell = start(parameters={"point_cloud_topics": ["points"]})
    motions = Motions(cell.peer, cell.node)
    cell.unknown("stale_world")

    for response in (motions.check((0, 0), (1, 1)), motions.check((), (1, 1)), motions.follow(STRAIGHT)):
        assert (response.verdict, response.reason_code, response.t_free) == (CheckMotion.Response.ERROR, "stale_world", 0)
        assert "is the sensor running?" in response.message


@pytest.mark.parametrize(
    ("request_of", "named"),
    [
        ({"joints": ["joint1", "wrist"]}, "'wrist'"),
        ({"joints": ["joint1", "joint1"]}, "'joint1' is given twice"),
        ({"joints": []}, "joint_names is empty"),
        ({"start": (0,)}, "start has 1"),
        ({"goal": (0, 1, 2)}, "goal has 3"),
        ({"goal": ()}, "goal has 0"),
        ({"start": (0, nan)}, "'joint2' has position NaN"),
        ({"goal": (inf, 0)}, "'joint1' has position inf"),
        ({"goal": (1e300, 0)}, "'joint1' has position 1e300"),
        ({"tolerance": -1.0}, "tolerance is -1"),
        ({"tolerance": nan}, "tolerance is NaN"),
        ({"tolerance": inf}, "tolerance is inf"),
        ({"timeout": -1.0}, "timeout is -1"),
        ({"timeout": nan}, "timeout is NaN"),
        ({"goal": [0.0] * 500_000}, "goal has 500000"),
        ({"margin": -0.1}, "margin is -0.1"),
        ({"margin": inf}, "margin is inf"),
        ({"event_distance": -0.1}, "event_distance is -0.1"),
        ({"event_distance": nan}, "event_distance is NaN"),
        ({"joint_tolerances": [0.1]}, "joint_tolerances has 1"),
        ({"joint_tolerances": [0.1, nan]}, "'joint2' is NaN"),
        ({"joints": ["x" * 1_000_000, "joint2"]}, "the name 'xxx"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_bad_request_is_rejected_by_name(cell, request_of, named):
    response = cell.motions.check(**({"start": (0, 0), "goal": (1, 1)} | request_of))

    assert (response.verdict, response.reason_code) == (CheckMotion.Response.ERROR, "bad_request")
    assert named in response.message
    assert len(response.message) < 500
    assert response.t_free == 0


def test_a_huge_motion_is_never_free(cell):
    for terms in ({}, {"any_contact": True}, {"certificate": True}):
        response = cell.motions.check((0, 0), (1e8, -1e8), timeout=0.3, **terms)
        assert response.verdict in (CheckMotion.Response.CONTACT, CheckMotion.Response.UNDECIDED)
        assert response.compute_time < 1
        response = cell.motions.check((0, 0), (1e8, 0), timeout=0.3, **terms)
        assert (response.verdict, response.reason_code) == (CheckMotion.Response.UNDECIDED, "deadline")
        assert 0.3 <= response.compute_time < 1


def test_a_free_trajectory_is_proven(cell):
    response = cell.motions.follow(trajectory(((0, 0), 0), ((1, 0), 1.5), ((1, 1), 4)), certificate=True)

    assert response.verdict == CheckTrajectory.Response.FREE
    assert (response.segment, response.time_free, response.time_contact) == (1, 4, 4)
    assert_proven(cell.motions.certificate(response), 2, ((0, 0), (1, 1)))


def test_a_trajectory_that_collides_says_where_and_when(cell):
    response = cell.motions.follow(trajectory(((0, 0), 0), (NEAR, 2), (BEYOND, 4)))

    assert response.verdict == CheckTrajectory.Response.CONTACT
    assert response.segment == 1
    assert response.t_free <= TOUCH <= response.t_contact
    assert response.time_free <= 2 + 2 * TOUCH <= response.time_contact
    assert response.time_contact - response.time_free < 1e-3
    assert cell.evaluate(**between(NEAR, BEYOND, response.t_contact)).status == CollisionState.COLLIDING


def test_velocities_bend_the_way(cell):
    # Both ends are free and so is the straight way, but not one that arrives at full speed the wrong way round.
    straight = trajectory(((0, 2), 0), ((0, 2.5), 1))
    bent = trajectory(((0, 2), 0, (0, 6)), ((0, 2.5), 1, (0, -6)))

    assert cell.motions.follow(straight).verdict == CheckTrajectory.Response.FREE
    response = cell.motions.follow(bent)
    assert response.verdict == CheckTrajectory.Response.CONTACT
    # 2 + 6 t - 10.5 t^2 + 5 t^3 - ... : the cubic with these ends and slopes
    t = response.t_contact
    joint2 = 2 + 6 * t + (3 * 0.5 - 2 * 6 + 6) * t**2 + (6 - 6 - 2 * 0.5) * t**3
    assert cell.evaluate(joint1=0, joint2=joint2).status == CollisionState.COLLIDING


def assert_claims_nothing(least):
    assert (least.lower, least.upper, least.segment) == (0, inf, 0) and isnan(least.t) and isnan(least.time)
    assert (least.nearest.pair.body_a, least.nearest.distance) == ("", 0)


def test_distances_that_are_not_requested_claim_nothing(cell):
    for response in (cell.motions.check((0, 0), NEAR), cell.motions.follow(STRAIGHT), cell.motions.check((0, 0), (nan, 0))):
        for least in (response.self_clearance, response.world_clearance):
            assert_claims_nothing(least)
        assert response.clearance_reason_code == ""
        event = response.event
        assert (event.result, event.reason_code, event.pair.body_a) == (DistanceEvent.NOT_CHECKED, "", "")
        assert (event.segment, event.t_farther, event.t_reached) == (0, 0, 0)
        assert isnan(event.time_farther) and isnan(event.time_reached)


# The ball's centre is sin(joint2) above the middle of the cube of half side 0.2, where it is above the cube.
LEAST = 0.5 - 0.2 - 0.1
WITHIN = 0.25
REACHED = (pi - asin(WITHIN + 0.3)) / NEAR[1]


def assert_nearest(least, lowest):
    assert lowest - 3e-3 < least.lower <= lowest + 1e-9 and lowest - 1e-9 < least.upper < lowest + 3e-3
    nearest = least.nearest
    assert nearest.distance == least.upper
    assert {nearest.pair.body_a, nearest.pair.body_b} == {"base", "tip"}
    assert nearest.pair.type_a == nearest.pair.type_b == BodyPair.LINK
    ys = {nearest.pair.body_a: nearest.witness_points[0].y, nearest.pair.body_b: nearest.witness_points[1].y}
    assert ys["base"] == pytest.approx(0.2, abs=1e-3) and ys["tip"] == pytest.approx(0.4, abs=3e-3)


def test_the_least_distances_along_a_motion(cell):
    response = cell.motions.check((0, 0), NEAR, with_clearance=True)
    assert response.verdict == CheckMotion.Response.FREE
    assert_nearest(response.self_clearance, LEAST)
    assert response.self_clearance.t > 0.99 and isnan(response.self_clearance.time)
    # no obstacles
    assert (response.world_clearance.lower, response.world_clearance.upper) == (inf, inf)
    assert response.clearance_reason_code == "" and response.event.result == DistanceEvent.NOT_CHECKED

    collides = cell.motions.check(NEAR, BEYOND, with_clearance=True)
    assert (collides.self_clearance.lower, collides.self_clearance.upper) == (0, 0)
    late = cell.motions.check((0, 0), NEAR, with_clearance=True, timeout=1e-9)
    assert (late.self_clearance.lower, late.clearance_reason_code) == (0, "deadline")
    loose = cell.motions.check((0, 0), (0, 1), with_clearance=True, joint_tolerances=[0.0, 0.2])
    assert loose.clearance_reason_code == "tube" and 0 < loose.self_clearance.lower < loose.self_clearance.upper


def test_the_least_distances_along_a_trajectory(cell):
    response = cell.motions.follow(trajectory(((0, 0), 0), ((0, 1), 2), (NEAR, 4)), with_clearance=True)
    assert_nearest(response.self_clearance, LEAST)
    assert response.self_clearance.segment == 1
    assert response.self_clearance.time == pytest.approx(2 + 2 * response.self_clearance.t)


def test_when_a_pair_first_comes_within_a_distance(cell):
    event = cell.motions.check((0, 0), NEAR, event_distance=WITHIN).event
    assert (event.result, event.reason_code, event.segment) == (DistanceEvent.REACHED, "", 0)
    assert event.t_farther <= REACHED <= event.t_reached < event.t_farther + 2e-3
    assert {event.pair.body_a, event.pair.body_b} == {"base", "tip"}
    assert isnan(event.time_farther) and isnan(event.time_reached)
    event = cell.motions.follow(trajectory(((0, 0), 1), (NEAR, 3)), event_distance=WITHIN).event
    assert event.time_farther <= 1 + 2 * REACHED <= event.time_reached

    event = cell.motions.check((0, 0), NEAR, event_distance=0.19).event
    assert (event.result, event.t_farther, event.t_reached) == (DistanceEvent.FARTHER, 1, 1)
    event = cell.motions.check((0, 0), NEAR, event_distance=0.19, timeout=1e-9).event
    assert (event.result, event.reason_code) == (DistanceEvent.UNDECIDED, "deadline")


def test_a_pair_within_the_margin_counts_as_touching(cell):
    assert cell.motions.check((0, 0), NEAR, margin=0.19).verdict == CheckMotion.Response.FREE
    for response in (
        cell.motions.check((0, 0), NEAR, margin=WITHIN),
        cell.motions.follow(trajectory(((0, 0), 0), (NEAR, 1)), margin=WITHIN),
    ):
        assert (response.verdict, response.distance_upper) == (CheckMotion.Response.CONTACT, WITHIN)
        assert response.t_free <= REACHED <= response.t_contact


def test_the_least_distance_to_the_world(peer, start):
    cell = start()
    cell.evaluate(joint1=0, joint2=0)
    assert SceneClient(cell).apply(diff(ball("lamp", 0, 2.5, radius=0.2)))
    # at joint1 = 90 degrees the stretched arm ends at (0, 2), with a ball of radius 0.1
    response = Motions(peer, cell.node).check((0, 0), (pi / 2, 0), with_clearance=True)
    world = response.world_clearance
    assert 0.2 - 3e-3 < world.lower <= 0.2 + 1e-9 and 0.2 - 1e-9 < world.upper < 0.2 + 3e-3 and world.t > 0.95
    assert (world.nearest.pair.body_a, world.nearest.pair.body_b) == ("tip", "lamp")
    assert (world.nearest.pair.type_a, world.nearest.pair.type_b) == (BodyPair.LINK, BodyPair.OBSTACLE)
    # elbow and edge of the cube, at 45 degrees
    assert response.self_clearance.upper == pytest.approx(0.9 - 2**0.5 / 5, abs=1e-2)


def test_a_trajectory_without_times_has_no_times_in_its_answer(cell):
    response = cell.motions.follow(trajectory((NEAR, 0), (BEYOND, 0)))

    assert response.verdict == CheckTrajectory.Response.CONTACT
    assert isnan(response.time_free) and isnan(response.time_contact)


@pytest.mark.parametrize(
    ("message", "named"),
    [
        (trajectory(), "at least two points"),
        (trajectory(((0, 0), 0)), "at least two points"),
        (trajectory(((0, 0), 0), ((1,), 1)), "point 1: 1 positions for 2 joints"),
        (trajectory(((0, 0), 0), ((1, nan), 1)), "joint 'joint2' is not finite"),
        (trajectory(((0, 0), 0, (0, 0)), ((1, 1), 1, (0,))), "point 1: 1 velocities for 2 joints"),
        (trajectory(((0, 0), 0, (0, 0, 0)), ((1, 1), 1)), "point 0: 3 velocities for 2 joints"),
        (trajectory(((0, 0), 0, (0, nan)), ((1, 1), 1, (0, 0))), "joint 'joint2' is not finite"),
        (trajectory(((0, 0), 2), ((1, 1), 1)), "time_from_start 1 s"),
        (trajectory(((0, 0), 0), ((1, 1), 1), joints=("joint1", "wrist")), "'wrist'"),
        (trajectory(((0,), 0), ((1e200,), 1), joints=("joint1",)), "'joint1' has position 1e200"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_bad_trajectory_is_rejected_by_name(cell, message, named):
    response = cell.motions.follow(message)

    assert (response.verdict, response.reason_code) == (CheckTrajectory.Response.ERROR, "bad_request")
    assert named in response.message


@pytest.mark.parametrize(
    ("terms", "named"),
    [
        ({"tolerance": -1.0}, "tolerance is -1"),
        ({"tolerance": nan}, "tolerance is NaN"),
        ({"timeout": -1.0}, "timeout is -1"),
        ({"timeout": inf}, "timeout is inf"),
        ({"joint_tolerances": [0.1]}, "joint_tolerances has 1"),
        ({"joint_tolerances": [0.1, -0.1]}, "'joint2' is -0.1"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_bad_terms_of_a_trajectory_are_rejected_by_name(cell, terms, named):
    response = cell.motions.follow(STRAIGHT, **terms)

    assert (response.verdict, response.reason_code) == (CheckTrajectory.Response.ERROR, "bad_request")
    assert named in response.message
    assert response.t_free == 0


def test_a_timeout_of_a_trajectory_is_undecided(cell):
    response = cell.motions.follow(STRAIGHT, timeout=1e-9)

    assert (response.verdict, response.reason_code) == (CheckTrajectory.Response.UNDECIDED, "deadline")
    assert (response.segment, response.time_free) == (0, 0)


def test_a_long_certificate_arrives_whole_and_a_longer_one_is_left_out(cell):
    def zigzag(points):
        return trajectory(*(((i % 2, 0), float(i)) for i in range(points)))

    response = cell.motions.follow(zigzag(400), certificate=True)
    assert response.verdict == CheckTrajectory.Response.FREE
    assert len(response.certificate) > 50_000
    assert_proven(cell.motions.certificate(response), 399, ((0, 0), (1, 0)))

    response = cell.motions.follow(zigzag(4000), certificate=True)
    assert response.verdict == CheckTrajectory.Response.FREE
    assert (response.certificate, response.certificate_digest) == ("", "")
    assert "certificate" in response.message


def assert_swept(capsules_of_tip, start, goal):
    """The tip at any time, by forward kinematics, lies within its capsule of that time."""
    count = len(capsules_of_tip)
    for i in range(1001):
        t = i / 1000
        q = between(start, goal, t)
        elbow = cos(q["joint1"]), sin(q["joint1"]), 0
        turned = q["joint1"] + q["joint2"]
        ball = elbow[0] + cos(turned), elbow[1] + sin(turned), 0
        held = [c for k, c in enumerate(capsules_of_tip) if k <= t * count <= k + 1]
        assert held
        for capsule in held:
            assert min(room(elbow, capsule), room(ball, capsule)) >= 0.1 - 1e-6


def test_the_volume_that_is_swept_over_is_shown(cell):
    start, goal = (-1.0, 0.5), (1.5, -2.0)
    response, markers = cell.motions.with_swept_volume(
        lambda: cell.motions.check(start, goal, swept_volume_intervals=16)
    )

    assert (response.verdict, response.message) == (CheckMotion.Response.FREE, "")
    tip = capsules(markers, "tip")
    assert len(tip) == len(capsules(markers, "upper")) == len(capsules(markers, "base")) == 16
    assert_swept(tip, start, goal)
    assert all(green > red for red, green in colours(markers, "tip"))
    assert max(radius for *_, radius in tip) < 0.5, "sixteen intervals make it tight"

    _, markers = cell.motions.with_swept_volume(
        lambda: (
            cell.motions.check(start, goal, certificate=True),
            cell.motions.check(start, goal, swept_volume_intervals=3),
        )
    )
    assert len(capsules(markers, "tip")) == 3, "unasked, nothing is shown"


def test_the_volume_of_a_trajectory_is_red_where_it_touches(cell):
    response, markers = cell.motions.with_swept_volume(
        lambda: cell.motions.follow(trajectory(((0, 0), 0), (NEAR, 2), (BEYOND, 4)), swept_volume_intervals=10)
    )

    assert (response.verdict, response.segment) == (CheckTrajectory.Response.CONTACT, 1)
    tip = capsules(markers, "tip")
    assert len(tip) == 20
    assert_swept(tip[:10], (0, 0), NEAR)
    assert_swept(tip[10:], NEAR, BEYOND)
    red = [red > green for red, green in colours(markers, "tip")]
    assert sum(red) == len(red) // 20, "one interval of twenty"
    assert [red > green for red, green in colours(markers, "upper")].count(True) == 0


def test_more_volumes_than_a_message_holds_are_rejected(cell):
    response, markers = cell.motions.with_swept_volume(
        lambda: cell.motions.check((0, 0), (1, 0), swept_volume_intervals=2**32 - 1)
    )
    assert (response.verdict, response.reason_code) == (CheckMotion.Response.ERROR, "bad_request")
    assert "swept_volume_intervals is 4294967295" in response.message
    assert markers == [], "what was shown is about another request"

    most = int(re.search(r"at most (\d+) intervals", response.message).group(1))
    response, markers = cell.motions.with_swept_volume(
        lambda: cell.motions.check((0, 0), (1, 0), swept_volume_intervals=most)
    )
    assert response.verdict == CheckMotion.Response.FREE
    assert [len(capsules(markers, link)) for link in ("base", "upper", "tip")] == [most] * 3
    response = cell.motions.check((0, 0), (1, 0), swept_volume_intervals=most + 1)
    assert response.reason_code == "bad_request"


def test_eight_clients_at_once_get_responses_while_states_go_on(peer, start):
    cell = start()
    clients = [Motions(peer, cell.node) for _ in range(8)]
    cell.evaluate(joint1=0, joint2=0)
    goals = [(0, 2.7 + 0.05 * i) for i in range(8)]
    assert sum(goal[1] < two_link.FIRST_TOUCH for goal in goals) == 3

    ways = [trajectory(((0, 0), 0), (goal, 1)) for goal in reversed(goals)]

    def expected(goal):
        return CheckMotion.Response.FREE if goal[1] < two_link.FIRST_TOUCH else CheckMotion.Response.CONTACT

    for _ in range(5):
        start = peer.now()
        straight = [client.ask((0, 0), goal) for client, goal in zip(clients, goals, strict=True)]
        followed = [client.ask_to_follow(way) for client, way in zip(clients, ways, strict=True)]
        assert [peer.result(future).verdict for future in straight] == [expected(goal) for goal in goals]
        assert [peer.result(future).verdict for future in followed] == [expected(goal) for goal in reversed(goals)]
        cell.becomes(CollisionState.FREE, "a state of meanwhile", after=start)


def endless(clients, timeout):
    """More requests than may wait, motions and trajectories by turns, each of which works for long: joint 1 turns round and round, and
    nothing ever touches."""
    terms = {"timeout": timeout, "certificate": True}
    way = trajectory(((0, 0), 0), ((1e8, 0), 1))
    pairs = [(c.ask((0, 0), (1e8, 0), **terms), c.ask_to_follow(way, **terms)) for _ in range(3) for c in clients]
    return [future for pair in pairs for future in pair]


def test_a_request_while_too_many_wait_is_rejected_at_once(peer, start):
    cell = start()
    clients = [Motions(peer, cell.node) for _ in range(8)]
    cell.evaluate(joint1=0, joint2=0)
    futures = endless(clients, timeout=0.2)
    start = peer.now()
    responses = [peer.result(future) for future in futures]
    meanwhile = cell.states.after(start)

    busy = [response for response in responses if response.reason_code == "busy"]
    worked = [response for response in responses if response.reason_code != "busy"]
    assert busy and len(worked) >= 16
    assert all(response.verdict == CheckMotion.Response.ERROR for response in busy)
    assert all(response.verdict == CheckMotion.Response.UNDECIDED for response in worked)
    # The monitor went on all the while.
    assert len(meanwhile) >= len(worked)


def test_a_node_that_checks_long_motions_still_ends(peer, start):
    cell = start()
    clients = [Motions(peer, cell.node) for _ in range(8)]
    cell.evaluate(joint1=0, joint2=0)
    futures = endless(clients, timeout=30.0)
    peer.wait_for(lambda: any(future.done() and future.result().reason_code == "busy" for future in futures), "busy")
    # The cell asks it to end, and sees that it does in time.
