"""`~/markers`: what RViz shows."""

from math import pi, sqrt

import pytest
from rclpy.time import Time
from visualization_msgs.msg import Marker, MarkerArray

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
    state = cell.judged(joint1=0, joint2=5 * pi / 6)

    array = markers.wait_for(after(state), "the markers of this state")
    (line,) = markers_of(array, "witness_lines")
    assert line.type == Marker.LINE_LIST
    assert line.header.frame_id == "base"
    assert line.scale.x > 0
    assert line.color.a > 0
    on_cube, on_ball = sorted(map(xyz, line.points))
    assert on_cube == pytest.approx((1 - sqrt(3) / 2, 0.2, 0), abs=1e-4)
    assert on_ball == pytest.approx((1 - sqrt(3) / 2, 0.4, 0), abs=1e-4)
    assert not markers_of(array, "colliding_links")


def test_colliding_links_are_shown_and_taken_away_again(cell, markers):
    state = cell.judged(joint1=0, joint2=pi)

    array = markers.wait_for(after(state), "the markers of this state")
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

    state = cell.judged(joint1=0, joint2=0)
    array = markers.wait_for(after(state), "the markers of the next state")
    gone = markers_of(array, "colliding_links", Marker.DELETE)
    assert {marker.id for marker in gone} == {marker.id for marker in shown}
    assert not markers_of(array, "colliding_links")


def test_markers_can_be_turned_off_and_on(cell, markers):
    state = cell.judged(joint1=0, joint2=pi)
    markers.wait_for(after(state), "markers")

    cell.parameters.succeed(publish_markers=False)
    state = cell.judged(joint1=0, joint2=pi)
    cell.states.wait_for(judged_since(cell.peer.now()), "later states")
    assert not any(
        marker.action == Marker.ADD for array in markers.messages if after(state)(array) for marker in array.markers
    )

    cell.parameters.succeed(publish_markers=True)
    state = cell.judged(joint1=0, joint2=pi)
    assert markers_of(markers.wait_for(after(state), "markers"), "colliding_links")
