"""Tests of `~/markers` for RViz: lines and distances of near pairs, colliding links."""

from math import pi, sqrt

import pytest
from rclpy.time import Time
from visualization_msgs.msg import Marker, MarkerArray

from scene import attached, ball
from scene_client import SceneClient
from two_link import judged_since


@pytest.fixture
def markers(cell):
    return cell.peer.record(MarkerArray, cell.node.private("markers"))


def after(state):
    """Accepts the markers of this judgement and of those that follow."""
    later = judged_since(Time.from_msg(state.header.stamp))
    return lambda array: array.markers and all(later(marker) for marker in array.markers)


def markers_of(array, namespace, action=Marker.ADD):
    return [marker for marker in array.markers if (marker.ns, marker.action) == (namespace, action)]


def xyz(vector):
    return vector.x, vector.y, vector.z


def test_a_near_pair_is_joined_by_a_line_between_its_witness_points(cell, markers):
    state = cell.evaluate(joint1=0, joint2=5 * pi / 6)

    array = markers.ever(after(state), "the markers of this state")
    (line,) = markers_of(array, "witness_lines")
    assert line.type == Marker.LINE_LIST
    assert line.header.frame_id == "base"
    assert line.scale.x > 0
    assert line.color.a > 0
    on_cube, on_ball = sorted(map(xyz, line.points))
    assert on_cube == pytest.approx((1 - sqrt(3) / 2, 0.2, 0), abs=1e-4)
    assert on_ball == pytest.approx((1 - sqrt(3) / 2, 0.4, 0), abs=1e-4)
    assert not markers_of(array, "colliding_links")


def test_distances_are_written_beside_their_lines(cell, markers):
    scene = SceneClient(cell)
    cell.evaluate(joint1=0, joint2=5 * pi / 6)
    cell.parameters.succeed(influence_distance=0.5)
    # the ball at the tip's end is at (0.134, 0.5): this one is 0.3 above it
    scene.change(ball("lamp", 1 - sqrt(3) / 2, 0.95, radius=0.05))
    state = cell.evaluate(joint1=0, joint2=5 * pi / 6)
    assert len(state.pair_distances) == 2

    array = markers.ever(after(state), "the markers of this state")
    (least,) = markers_of(array, "least_distance")
    assert (least.type, least.text) == (Marker.TEXT_VIEW_FACING, "0.200 m")
    (other,) = markers_of(array, "distances")
    assert (other.type, other.text) == (Marker.TEXT_VIEW_FACING, "0.300 m")
    assert other.pose.position.y == pytest.approx(0.75, abs=1e-4)


def test_what_the_robot_holds_is_shown_when_it_collides(cell, markers):
    cell.evaluate(joint1=0, joint2=0)
    SceneClient(cell).change(attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"]))
    # folded, the tip is free and the part is in the cube of the base
    state = cell.evaluate(joint1=0, joint2=5 * pi / 6)

    array = markers.ever(after(state), "the markers of this state")
    (part,) = markers_of(array, "colliding_attached_objects")
    assert part.type == Marker.SPHERE
    assert xyz(part.scale) == pytest.approx((0.1, 0.1, 0.1))
    where = 1 - sqrt(3) / 2 - 0.2, 0.5 - 0.4 * sqrt(3) / 2, 0
    assert xyz(part.pose.position) == pytest.approx(where, abs=1e-4)
    # the cube of the base alone
    assert [marker.type for marker in markers_of(array, "colliding_links")] == [Marker.CUBE]


def test_colliding_links_are_shown_and_taken_away_again(cell, markers):
    state = cell.evaluate(joint1=0, joint2=pi)

    array = markers.ever(after(state), "the markers of this state")
    shown = markers_of(array, "colliding_links")
    # The cube of the base, and the elbow, rod and ball of the tip.
    assert sorted(marker.type for marker in shown) == sorted(
        [Marker.CUBE, Marker.SPHERE, Marker.CYLINDER, Marker.SPHERE]
    )
    assert all(marker.header.frame_id == "base" and marker.color.a > 0 for marker in shown)
    (cube,) = (marker for marker in shown if marker.type == Marker.CUBE)
    assert xyz(cube.scale) == pytest.approx((0.4, 0.4, 0.4))
    assert xyz(cube.pose.position) == pytest.approx((0, 0, 0))
    elbow_and_ball = sorted(xyz(marker.pose.position) for marker in shown if marker.type == Marker.SPHERE)
    assert elbow_and_ball == [pytest.approx((0, 0, 0)), pytest.approx((1, 0, 0))]
    assert not markers_of(array, "witness_lines")

    state = cell.evaluate(joint1=0, joint2=0)
    array = markers.ever(after(state), "the markers of the next state")
    gone = markers_of(array, "colliding_links", Marker.DELETE)
    assert {marker.id for marker in gone} == {marker.id for marker in shown}
    assert not markers_of(array, "colliding_links")


def test_markers_can_be_turned_off_and_on(cell, markers):
    state = cell.evaluate(joint1=0, joint2=pi)
    markers.ever(after(state), "markers")

    cell.parameters.succeed(publish_markers=False)
    state = cell.evaluate(joint1=0, joint2=pi)
    cell.states.ever(judged_since(cell.peer.now()), "later states")
    assert not any(
        marker.action == Marker.ADD for array in markers.all() if after(state)(array) for marker in array.markers
    )

    cell.parameters.succeed(publish_markers=True)
    state = cell.evaluate(joint1=0, joint2=pi)
    assert markers_of(markers.ever(after(state), "markers"), "colliding_links")
