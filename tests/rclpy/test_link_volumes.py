"""Tests of `~/link_volumes`: bounding volumes of a chosen level, in the frames of the links."""

import pytest
from rclpy.qos import DurabilityPolicy
from visualization_msgs.msg import Marker, MarkerArray

from scene import attached, ball, xyz
from scene_client import SceneClient


def record(cell):
    return cell.peer.record(MarkerArray, cell.node.private("link_volumes"), durability=DurabilityPolicy.TRANSIENT_LOCAL)


def boxes(array):
    return [marker for marker in array.markers if marker.action == Marker.ADD]


def test_boxes_of_a_level_are_shown_in_the_frames_of_their_links(start):
    cell = start(parameters={"link_volume_level": 0})
    array = record(cell).ever(boxes, "the boxes")
    assert array.markers[0].action == Marker.DELETEALL
    shown = boxes(array)
    assert {marker.ns for marker in shown} == {"base", "upper", "tip"}
    for marker in shown:
        assert (marker.type, marker.header.frame_id, marker.frame_locked) == (Marker.CUBE, marker.ns, True)
        assert marker.color.a > 0
    assert len({marker.id for marker in shown}) == len(shown)
    (base,) = (marker for marker in shown if marker.ns == "base")
    assert (base.scale.x, base.scale.y, base.scale.z) == pytest.approx((0.4, 0.4, 0.4), abs=1e-4)


def test_a_level_can_be_chosen_changed_and_turned_off(cell):
    volumes = record(cell)
    cell.evaluate(joint1=0, joint2=0)
    assert not volumes.all(), "none are asked for"

    cell.parameters.succeed(link_volume_level=0)
    whole = boxes(volumes.ever(boxes, "the boxes of level 0"))
    cell.parameters.succeed(link_volume_level=1)
    finer = volumes.ever(lambda array: len(boxes(array)) > len(whole), "the finer boxes of level 1")

    cell.parameters.succeed(link_volume_level=-1)
    array = volumes.wait_for(lambda array: not boxes(array), "that all are taken away", after=finer)
    assert [marker.action for marker in array.markers] == [Marker.DELETEALL]


def test_what_a_link_takes_up_has_boxes_too(start):
    cell = start(parameters={"link_volume_level": 0})
    cell.evaluate(joint1=0, joint2=0)
    SceneClient(cell).change(attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"]))

    def of_part(array):
        return [marker for marker in boxes(array) if marker.ns == "part"]

    (part,) = of_part(record(cell).ever(of_part, "the box of the part"))
    assert part.header.frame_id == "tip"
    assert xyz(part.pose.position) == pytest.approx((1, 0.4, 0), abs=1e-4)
    assert xyz(part.scale) == pytest.approx((0.1, 0.1, 0.1), abs=1e-4)


def test_levels_that_mean_nothing_are_rejected(cell):
    (result,) = cell.parameters.set(link_volume_level=21)
    assert not result.successful
    assert "link_volume_level must be from -1 to 20" in result.reason
    (described,) = cell.parameters.describe("link_volume_level")
    (between,) = described.integer_range
    assert (between.from_value, between.to_value) == (-1, 20)


def test_volumes_of_the_selected_kinds_are_shown(start):
    cell = start(parameters={"link_volume_level": 0, "volumes": "pss"})
    shown = boxes(record(cell).ever(boxes, "the balls"))
    assert {marker.type for marker in shown} == {Marker.SPHERE}
    (base,) = (marker for marker in shown if marker.ns == "base")
    assert base.scale.x == base.scale.y == base.scale.z > 0.4

    volumes = record(cell)
    cell.parameters.succeed(volumes="obb,tip=rss")

    def of_two_kinds(array):
        return {marker.ns: marker.type for marker in boxes(array)} == {
            "base": Marker.CUBE,
            "upper": Marker.CUBE,
            "tip": Marker.TRIANGLE_LIST,
        }

    (tip,) = (marker for marker in boxes(volumes.ever(of_two_kinds, "both kinds")) if marker.ns == "tip")
    assert len(tip.points) == 3 * 72
    assert cell.parameters.get("volumes") == ["obb,tip=rss"]


def test_kinds_that_do_not_exist_are_rejected(cell):
    (result,) = cell.parameters.set(volumes="box")
    assert not result.successful
    assert "volumes: 'box' is no kind of bounding volume; there are obb, rss" in result.reason
    assert cell.parameters.get("volumes") == ["obb"]


def test_states_are_the_same_with_any_kind(cell):
    # The robot jumps.
    cell.parameters.succeed(check_between_states=False)
    positions = [{"joint1": 0.4 * step, "joint2": 1.1 * step} for step in range(6)]

    def results():
        states = [cell.evaluate(**position) for position in positions]
        return [(state.status, state.self_distance) for state in states]

    with_boxes = results()
    assert len(set(with_boxes)) == len(positions)
    for kind in ("rss", "kdop18", "kios"):
        cell.parameters.succeed(volumes=kind)
        assert results() == with_boxes, kind
