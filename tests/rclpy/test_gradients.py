"""Tests of `~/get_distances` with gradients: derivatives of the distances that the same service reports."""

from math import isnan, pi, sqrt

import numpy as np
import pytest
from clearance_msgs.srv import GetDistances

import two_link
from scene import ball
from scene_client import SceneClient
from states import States

ONE, SEVERAL, MANY_UNKNOWN = (
    GetDistances.Response.ONE,
    GetDistances.Response.SEVERAL,
    GetDistances.Response.MANY_UNKNOWN,
)
STEP = 1e-5  # [rad]
ACCURACY = 1e-6  # [m, m/rad]
EMPTY = ("signed_distances", "signed_distances_upper", "normals", "witness_counts", "gradient_joints", "gradient")


@pytest.fixture
def questions(cell):
    """The service of a node whose robot stands at zero, beside a ball at (1.9, 1.2)."""
    SceneClient(cell).change(ball("lamp", 1.9, 1.2, radius=0.05))
    cell.evaluate(joint1=0, joint2=0)
    return States(cell.peer, cell.node)


def names(pair):
    return pair.pair.body_a, pair.pair.body_b


def rows(response):
    return np.array(response.gradient).reshape(len(response.pairs), len(response.gradient_joints))


def signed(response):
    """Signed distances by the names of the bodies."""
    return dict(zip(map(names, response.pairs), response.signed_distances, strict=True))


def differences(questions, state):
    """Central differences of the signed distances, by the names of the bodies."""
    columns = []
    for joint in range(len(state)):
        before, after = (
            signed(questions.distances(tuple(np.add(state, step * np.eye(len(state))[joint])), with_gradients=True))
            for step in (-STEP, STEP)
        )
        columns.append({pair: (after[pair] - before[pair]) / (2 * STEP) for pair in after})
    return {pair: np.array([column[pair] for column in columns]) for pair in columns[0]}


def test_without_the_request_there_are_none(questions):
    response = questions.distances((0.3, 1.9))
    assert response.pairs and all(len(getattr(response, field)) == 0 for field in EMPTY)


@pytest.mark.parametrize("state", [(0.3, 1.9), (-0.4, 0.8), (0.1, 2.5), (0.0, pi - 0.15)], ids=str)
def test_rows_are_derivatives_of_the_distances(questions, state):
    response = questions.distances(state, with_gradients=True)
    assert (response.message, list(response.gradient_joints)) == ("", list(two_link.JOINTS))
    assert len(response.pairs) >= 3, "base and tip, and the lamp with both moving links"
    expected = differences(questions, state)
    smooth = 0
    for pair, row, count in zip(response.pairs, rows(response), response.witness_counts, strict=True):
        if count == ONE:
            assert row == pytest.approx(expected[names(pair)], abs=1e-4), names(pair)
            smooth += 1
    assert smooth >= 2


def test_apart_they_are_the_distances_and_normals_point_to_the_second_body(questions):
    response = questions.distances((0.3, 1.9), with_gradients=True)
    distances = [pair.distance for pair in response.pairs]
    assert list(response.signed_distances) == list(response.signed_distances_upper) == distances
    for pair, normal in zip(response.pairs, response.normals, strict=True):
        first, second = (np.array([p.x, p.y, p.z]) for p in pair.witness_points)
        assert second - first == pytest.approx(pair.distance * np.array([normal.x, normal.y, normal.z]), abs=ACCURACY)


def test_worked_out_by_hand(questions):
    """Stretched along x, the ball of the tip is at (2, 0), and nearer to the lamp at (1.9, 1.2) than the rod is."""
    response = questions.distances((0, 0), bodies=["lamp"], max_pairs=1, with_gradients=True)
    ((pair,), (row,)) = response.pairs, rows(response)
    # the ball of the tip: radius 0.1, the lamp: radius 0.05
    assert set(names(pair)) == {"tip", "lamp"}
    between = np.array([-0.1, 1.2])
    assert pair.distance == pytest.approx(np.linalg.norm(between) - 0.15, abs=ACCURACY)
    # joint1 turns the ball about (0, 0), joint2 about (1, 0): both move it along y
    direction = between / np.linalg.norm(between)
    assert row == pytest.approx([-2 * direction[1], -1 * direction[1]], abs=ACCURACY)
    assert response.witness_counts[0] == ONE


def test_bodies_that_overlap_have_minus_their_depth(questions):
    """The end of the tip is in the base's cube, whose half side is 0.2: 0.05 beside its middle."""
    state = (0, pi - 0.05)
    response = questions.distances(state, bodies=["base"], with_gradients=True)
    first = next(i for i, pair in enumerate(response.pairs) if set(names(pair)) == {"base", "tip"})
    assert response.pairs[first].distance == 0
    assert -0.4 < response.signed_distances[first] <= response.signed_distances_upper[first] < 0
    normal = response.normals[first]
    assert sqrt(normal.x**2 + normal.y**2 + normal.z**2) == pytest.approx(1, abs=ACCURACY)
    assert response.witness_counts[first] in (ONE, SEVERAL, MANY_UNKNOWN)


def test_a_step_along_the_gradient_increases_the_distance(questions):
    state = np.array([0.3, 1.9])
    response = questions.distances(tuple(state), max_pairs=1, with_gradients=True)
    (row,) = rows(response)
    further = questions.distances(tuple(state + 0.01 * row), with_gradients=True)
    change = signed(further)[names(response.pairs[0])] - response.signed_distances[0]
    assert change == pytest.approx(0.01 * row @ row, rel=0.1)


def test_they_follow_the_listed_pairs(questions):
    state = (0.3, 1.9)
    everything = questions.distances(state, with_gradients=True)
    one = questions.distances(state, max_pairs=1, with_gradients=True)
    assert (one.pairs, list(one.gradient)) == (everything.pairs[:1], list(everything.gradient[:2]))
    assert one.normals == everything.normals[:1]
    near = questions.distances(state, max_distance=0.01, with_gradients=True)
    assert len(near.pairs) == len(near.signed_distances) == len(near.witness_counts)


def test_the_current_state_has_them_too(questions):
    assert signed(questions.distances(with_gradients=True)) == signed(questions.distances((0, 0), with_gradients=True))


def test_a_timeout_leaves_none(questions):
    response = questions.distances((0, 0), timeout=1e-9, with_gradients=True)
    assert response.reason_code == "deadline" and not any(map(isnan, response.signed_distances))
    assert len(response.pairs) == len(response.signed_distances) == 0
