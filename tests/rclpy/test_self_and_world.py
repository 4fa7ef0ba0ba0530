"""Tests of the distances of the robot from itself and from the world, on every topic and in every response."""

from math import inf, isinf, isnan, nan, pi, sqrt

import pytest
from clearance_msgs.msg import BodyPair, CollisionState, PairDistance
from diagnostic_msgs.msg import DiagnosticArray
from visualization_msgs.msg import Marker, MarkerArray

from cell import Companions
from scene import attached, ball
from scene_client import SceneClient
from states import States

ACCURACY = 1e-6  # [m]
# The tip's ball, of radius 0.1, is at (2, 0, 0); the cube of the base ends at 0.2, the elbow begins at 0.9.
OF_SELF = 0.7
# Beside the tip: 1.2 between the balls, and farther from all other links.
LAMP = ball("lamp", 2, 1.4)
OF_WORLD = 1.2
STRETCHED = {"joint1": 0, "joint2": 0}
FOLDED = {"joint1": 0, "joint2": 5 * pi / 6}
ONTO = {"joint1": 0, "joint2": pi}
NOTHING = PairDistance()


@pytest.fixture
def cell(start):
    cell = start(parameters={"distance_limit": 2.0})
    cell.evaluate(**STRETCHED)
    return cell


@pytest.fixture
def lit(cell):
    """The same cell with a lamp."""
    SceneClient(cell).change(LAMP)
    return cell


def names(pair_distance):
    return {pair_distance.pair.body_a, pair_distance.pair.body_b}


def points(pair_distance):
    """By the name of the body that each lies on."""
    on_a, on_b = ((point.x, point.y, point.z) for point in pair_distance.witness_points)
    return {pair_distance.pair.body_a: on_a, pair_distance.pair.body_b: on_b}


def test_the_state_has_both_distances_with_their_pairs_and_nearest_points(lit):
    state = lit.evaluate(**STRETCHED)

    assert state.self_distance == state.self_nearest.distance == pytest.approx(OF_SELF, abs=ACCURACY)
    assert names(state.self_nearest) == {"base", "tip"}
    assert (state.self_nearest.pair.type_a, state.self_nearest.pair.type_b) == (BodyPair.LINK, BodyPair.LINK)
    assert points(state.self_nearest)["base"][0] == pytest.approx(0.2, abs=ACCURACY)
    assert points(state.self_nearest)["tip"][0] == pytest.approx(0.9, abs=ACCURACY)
    assert state.world_distance == state.world_nearest.distance == pytest.approx(OF_WORLD, abs=ACCURACY)
    pair = state.world_nearest.pair
    assert (pair.body_a, pair.type_a, pair.body_b, pair.type_b) == ("tip", BodyPair.LINK, "lamp", BodyPair.OBSTACLE)
    assert points(state.world_nearest)["tip"] == pytest.approx((2, 0.1, 0), abs=1e-4)
    assert points(state.world_nearest)["lamp"] == pytest.approx((2, 1.3, 0), abs=1e-4)
    # the nearer of the two, as before
    assert state.nearest == state.self_nearest

    SceneClient(lit).change(ball("near", 2, 0.5))
    state = lit.evaluate(**STRETCHED)
    assert state.nearest == state.world_nearest and names(state.nearest) == {"tip", "near"}
    assert state.world_distance == pytest.approx(0.3, abs=ACCURACY)
    assert state.self_distance == pytest.approx(OF_SELF, abs=ACCURACY)


def test_what_the_robot_holds_belongs_to_the_robot(lit):
    # from the end of the tip to the lamp: 0.5 between the balls, and beside the base where the arm is folded
    SceneClient(lit).change(attached("tip", ball("part", 1, 0.7, frame="tip"), ["tip"]))
    state = lit.evaluate(**STRETCHED)
    assert names(state.world_nearest) == {"part", "lamp"}
    assert BodyPair.ATTACHED in (state.world_nearest.pair.type_a, state.world_nearest.pair.type_b)
    assert state.world_distance == pytest.approx(0.5, abs=ACCURACY)

    state = lit.evaluate(**ONTO)
    assert {"base", "part"} not in [{pair.body_a, pair.body_b} for pair in state.colliding_pairs]
    assert state.self_distance == 0


def test_a_collision_is_at_distance_zero_and_the_other_distance_stays(lit):
    state = lit.evaluate(**ONTO)
    assert state.status == CollisionState.COLLIDING
    assert (state.self_distance, state.self_nearest.distance) == (0, 0)
    assert names(state.self_nearest) == {"base", "tip"}
    assert 0 < state.world_distance < 2

    SceneClient(lit).change(ball("onto_tip", 2, 0.15))
    state = lit.evaluate(**STRETCHED)
    assert state.status == CollisionState.COLLIDING
    assert (state.world_distance, names(state.world_nearest)) == (0, {"tip", "onto_tip"})
    assert state.self_distance == pytest.approx(OF_SELF, abs=ACCURACY)


def test_what_is_not_there_is_infinitely_far_and_what_is_unknown_is_no_number(cell):
    state = cell.evaluate(**STRETCHED)
    assert (state.world_distance, state.world_nearest) == (inf, NOTHING)
    assert state.self_distance == pytest.approx(OF_SELF, abs=ACCURACY)

    SceneClient(cell).change(LAMP)
    cell.parameters.succeed(distance_limit=1.0)
    state = cell.evaluate(**STRETCHED)
    assert (state.world_distance, state.world_nearest) == (inf, NOTHING)
    cell.parameters.succeed(distance_limit=0.5)
    state = cell.evaluate(**STRETCHED)
    assert (state.self_distance, state.self_nearest, state.distance_known) == (inf, NOTHING, False)

    state = cell.evaluate(joint1=0, joint2=nan)
    assert state.status == CollisionState.UNKNOWN
    assert isnan(state.self_distance) and isnan(state.world_distance)
    assert (state.self_nearest, state.world_nearest) == (NOTHING, NOTHING)


def test_the_topics_report_the_distances_of_every_state(lit):
    companions = Companions(lit)
    first = lit.evaluate(**STRETCHED)
    for positions in (ONTO, FOLDED, STRETCHED | {"joint2": nan}, STRETCHED):
        lit.evaluate(**positions)

    for state in [first, *lit.states.after(first)]:
        said = companions.of(state)
        for kind in ("self", "world"):
            distance = getattr(state, f"{kind}_distance")
            assert said[f"{kind}_distance"] == distance or (isnan(distance) and isnan(said[f"{kind}_distance"]))
            assert isnan(distance) == (state.status == CollisionState.UNKNOWN)
    assert companions.of(first)["self_distance"] == pytest.approx(OF_SELF, abs=ACCURACY)
    assert companions.of(first)["world_distance"] == pytest.approx(OF_WORLD, abs=ACCURACY)


def test_heartbeats_report_them_too(lit):
    companions = Companions(lit)
    lit.falls_silent()
    state = lit.state_now()
    assert companions.of(state)["world_distance"] == pytest.approx(OF_WORLD, abs=ACCURACY)


def markers_of(array, namespace):
    return [marker for marker in array.markers if (marker.ns, marker.action) == (namespace, Marker.ADD)]


def test_markers_show_both_nearest_pairs(lit):
    recorded = lit.peer.record(MarkerArray, lit.node.private("markers"))
    lit.evaluate(**STRETCHED)
    array = recorded.ever(lambda array: markers_of(array, "world_distance"), "markers of the nearest pairs")
    for kind, text, ends in [
        ("self", "self 0.700 m", ((0.2, 0), (0.9, 0))),
        ("world", "world 1.200 m", ((2, 0.1), (2, 1.3))),
    ]:
        line, label = markers_of(array, f"{kind}_distance")
        assert (line.type, label.type, label.text) == (Marker.LINE_LIST, Marker.TEXT_VIEW_FACING, text)
        found = sorted((point.x, point.y) for point in line.points)
        for end, expected in zip(found, ends, strict=True):
            assert end == pytest.approx(expected, abs=1e-4)

    lit.evaluate(**ONTO)
    array = recorded.ever(
        lambda array: any((m.ns, m.action) == ("self_distance", Marker.DELETE) for m in array.markers),
        "the line is taken away where the robot touches itself",
    )
    assert markers_of(array, "colliding_links")


def test_diagnostics_report_both(lit):
    recorded = lit.peer.record(DiagnosticArray, "/diagnostics")
    node = lit.node.private("").strip("/")

    def reported(array):
        for status in array.status:
            values = {item.key: item.value for item in status.values}
            if status.name.startswith(node) and values.get("world distance (m)", "inf") not in ("inf", "NaN"):
                return values
        return None

    values = reported(recorded.ever(reported, "diagnostics with a distance from the world"))
    assert float(values["self distance (m)"]) == pytest.approx(OF_SELF, abs=1e-4)
    assert float(values["world distance (m)"]) == pytest.approx(OF_WORLD, abs=1e-4)


def pair_of(response, kind, i):
    indices = (getattr(response, f"{kind}_pair_a")[i], getattr(response, f"{kind}_pair_b")[i])
    return [response.bodies[index] for index in indices if index >= 0]


def test_a_batch_of_states_has_both_distances_of_each(lit):
    questions = States(lit.peer, lit.node)
    states = [(0, 0), (0, pi), (0, 5 * pi / 6)]
    response = questions.check(states, with_distance=True)
    assert list(response.self_distances) == pytest.approx([OF_SELF, 0, 0.2], abs=ACCURACY)
    # from the elbow, of radius 0.1 at (1, 0), to the lamp: sqrt(1 + 1.4²) between the centres
    folded = sqrt(1 + 1.4**2) - 0.2
    assert list(response.world_distances) == pytest.approx([OF_WORLD, folded, folded], abs=0.02)
    for i in range(3):
        assert set(pair_of(response, "self", i)) == {"base", "tip"}
        body, obstacle = pair_of(response, "world", i)
        assert obstacle == "lamp" and body in ("tip", "upper")
    assert list(response.distances) == list(response.self_distances)

    limited = questions.check(states, with_distance=True, distance_limit=1.0)
    assert all(map(isinf, limited.world_distances)) and list(limited.world_pair_a) == [-1] * 3
    assert list(limited.self_distances) == list(response.self_distances)
    late = questions.check(states, with_distance=True, timeout=1e-9)
    assert all(map(isnan, late.self_distances)) and all(map(isnan, late.world_distances))
    assert list(late.self_pair_b) == list(late.world_pair_b) == [-1] * 3
    without = questions.check(states)
    fields = ("self_distances", "self_pair_a", "self_pair_b", "world_distances", "world_pair_a", "world_pair_b")
    assert all(len(getattr(without, field)) == 0 for field in fields)


def test_the_distances_of_a_state_begin_with_the_nearest_of_either_kind(lit):
    questions = States(lit.peer, lit.node)
    state = lit.evaluate(**STRETCHED)
    for response in (questions.distances(), questions.distances((0, 0), max_pairs=1)):
        assert response.self_distance == pytest.approx(OF_SELF, abs=ACCURACY)
        assert response.world_distance == pytest.approx(OF_WORLD, abs=ACCURACY)
        assert (response.self_nearest, response.world_nearest) == (state.self_nearest, state.world_nearest)

    near = questions.distances((0, 0), max_distance=1.0)
    assert (near.world_distance, near.world_nearest) == (inf, NOTHING)
    of_base = questions.distances((0, 0), bodies=["upper"])
    assert (of_base.self_distance, of_base.self_nearest) == (inf, NOTHING), "its neighbours are not checked"
    assert names(of_base.world_nearest) == {"upper", "lamp"}
    late = questions.distances((0, 0), timeout=1e-9)
    assert isnan(late.self_distance) and isnan(late.world_distance)
    unknown = questions.distances((0, 0), bodies=["nobody"])
    assert isnan(unknown.self_distance) and isnan(unknown.world_distance)


def test_a_robot_alone_in_the_dark(cell):
    """Without obstacles nothing is told of the world, and nothing else changes."""
    response = States(cell.peer, cell.node).check([(0, 0)], with_distance=True)
    assert (list(response.world_distances), list(response.world_pair_a)) == ([inf], [-1])
    assert list(response.distances) == list(response.self_distances)
