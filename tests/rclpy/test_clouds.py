"""Tests of point clouds: layouts, stamps and age, broken clouds, self-filter, crop, voxels, several sensors.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0). Every point has a radius of 0.02.
"""

from math import inf, nan, sqrt

import numpy as np
import pytest
from clearance_msgs.msg import CollisionState
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2, PointField
from tf2_msgs.msg import TFMessage

from point_cloud_node import ACCURACY, FOLDED, QOS, RADIUS, STRETCHED, WALL, PointCloudNode, to_cloud
from clouds import FLOAT32, FLOAT64, PLAIN, Layout, cloud


@pytest.fixture(scope="module")
def shared(module_peer):
    """One node: every cloud replaces the one before."""
    with PointCloudNode(module_peer) as cell:
        yield cell


LAYOUTS = {
    "plain": PLAIN,
    "as a depth camera": Layout((("x", 0, FLOAT32), ("y", 4, FLOAT32), ("z", 8, FLOAT32), ("rgb", 16, FLOAT32)), 32),
    "as a lidar": Layout(
        (
            *(("x", 0, FLOAT32), ("y", 4, FLOAT32), ("z", 8, FLOAT32), ("intensity", 16, FLOAT32)),
            *(("ring", 20, PointField.UINT16), ("time", 24, FLOAT64)),
        ),
        32,
    ),
    "in another order": Layout(
        (("intensity", 0, FLOAT32), ("z", 4, FLOAT32), ("x", 8, FLOAT32), ("y", 12, FLOAT32)), 16
    ),
    "listed in another order": Layout((("z", 8, FLOAT32), ("x", 0, FLOAT32), ("y", 4, FLOAT32)), 12),
    "on odd offsets": Layout(
        (("tag", 0, PointField.UINT8), ("y", 1, FLOAT32), ("x", 7, FLOAT32), ("z", 13, FLOAT32)), 19
    ),
    "of doubles": Layout((("x", 0, FLOAT64), ("y", 8, FLOAT64), ("z", 16, FLOAT64)), 24),
    "mixed": Layout((("x", 0, FLOAT64), ("y", 8, FLOAT32), ("z", 12, FLOAT64)), 20),
    "big-endian": Layout(big_endian=True),
    "big-endian doubles": Layout((("x", 0, FLOAT64), ("y", 8, FLOAT64), ("z", 16, FLOAT64)), 24, big_endian=True),
    "organised": Layout(height=7),
    "organised with padded rows": Layout((("x", 0, FLOAT32), ("y", 4, FLOAT32), ("z", 8, FLOAT32)), 16, False, 7, 5),
}


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_cloud_of_every_layout_is_read(shared, layout):
    state = shared.sees(cloud(WALL, layout=LAYOUTS[layout]))
    assert state.status == CollisionState.FREE
    assert to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)

    state = shared.sees(cloud([(2.11, 0, 0)], layout=LAYOUTS[layout]))
    assert state.status == CollisionState.COLLIDING


@pytest.mark.parametrize("bad", [nan, inf, -inf])
@pytest.mark.parametrize("axis", range(3))
def test_points_that_are_no_place_are_dropped(shared, bad, axis):
    points = np.array([(2.0, 0.0, 0.0), (2.3, 0.0, 0.0), (2.0, 0.0, 0.0)])
    points[[0, 2], axis] = bad
    message = cloud(points)
    # What a message says of itself is not trusted.
    message.is_dense = True
    assert to_cloud(shared.sees(message)) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


def test_a_cloud_from_the_future_is_rejected(start_cloud):
    cell = start_cloud(parameters={"point_cloud_ttl": 10.0})
    cell.sees(cloud(WALL))
    publisher = cell.scene.topic(PointCloud2, "points", QOS)
    early = cloud(WALL, stamp=cell.peer.now() + Duration(seconds=3600))
    seen = cell.peer.now()

    def rejected():
        publisher.publish(early)
        return any(state.reason_code == "rejected_obstacle" for state in cell.states.after(seen))

    cell.peer.wait_for(rejected, "UNKNOWN for a cloud of another clock")


def test_an_older_cloud_does_not_replace_a_newer_one(start_cloud):
    cell = start_cloud(parameters={"point_cloud_ttl": 60.0})
    publisher = cell.scene.topic(PointCloud2, "points", QOS)
    now = cell.peer.now()
    touching, late = cloud([(2.11, 0, 0)], stamp=now), cloud(WALL, stamp=now - Duration(seconds=0.5))
    # its frame moves with the robot, and where it was then nobody knows
    outlived = cloud([(0.11, 0, 0)], frame="tip", stamp=now - Duration(seconds=10))
    seen = cell.peer.now()

    def published(message, reached):
        publisher.publish(message)
        return any(reached(state) for state in cell.states.after(seen))

    def rejected(words):
        return lambda state: state.reason_code == "rejected_obstacle" and words in state.reason

    cell.peer.wait_for(lambda: published(outlived, rejected("older than the joint states")), "UNKNOWN for an old cloud")
    cell.peer.wait_for(
        lambda: published(touching, lambda state: state.status == CollisionState.COLLIDING), "COLLIDING in the newer cloud"
    )
    cell.peer.wait_for(lambda: published(late, rejected("older than that of the last cloud")), "UNKNOWN for a late cloud")
    seen = cell.peer.now()
    again = cloud([(2.11, 0, 0)], stamp=now + Duration(seconds=0.1))
    cell.peer.wait_for(
        lambda: published(again, lambda state: state.status == CollisionState.COLLIDING), "COLLIDING in the next cloud"
    )


def test_points_far_from_their_frame_keep_their_places(start_cloud):
    """The coordinates of a map grid have half a metre between two 32-bit floats."""
    cell = start_cloud()
    origin = np.array([500_123.4, 5_400_321.7, 0.0])
    transform = TransformStamped(child_frame_id="map")
    transform.header.frame_id = "base"
    place = transform.transform.translation
    place.x, place.y, place.z = (-origin).tolist()
    cell.scene.topic(TFMessage, "tf_static").publish(TFMessage(transforms=[transform]))
    doubles = LAYOUTS["of doubles"]
    floor = [(x, y, -0.6) for x in range(-40, 41, 8) for y in range(-40, 41, 8)]
    free = cloud(origin + np.array([*WALL, *floor]), frame="map", layout=doubles)
    publisher = cell.scene.topic(PointCloud2, "points", QOS)

    def is_free():
        free.header.stamp = cell.peer.now().to_msg()
        publisher.publish(free)
        return any(state.status == CollisionState.FREE for state in cell.states.all())

    cell.peer.wait_for(is_free, "FREE beside the wall")
    assert to_cloud(cell.sees(free)) == pytest.approx(0.2 - RADIUS, abs=1e-4)
    for shift in np.random.default_rng(1).uniform(-0.005, 0.005, (5, 3)):
        touching = np.array([(2.11, 0, 0) + shift, *floor])
        assert cell.sees(cloud(origin + touching, frame="map", layout=doubles)).status == CollisionState.COLLIDING


def organise(message, height, row_step):
    message.height, message.width, message.row_step = height, message.width // height, row_step


def broken(change):
    message = cloud(WALL)
    change(message)
    return message


BROKEN = {
    "no z": (broken(lambda message: message.fields.pop()), "z"),
    "integers": (broken(lambda message: setattr(message.fields[1], "datatype", PointField.INT32)), "y"),
    "a field twice": (broken(lambda message: setattr(message.fields[2], "name", "x")), "x"),
    "an unknown type": (broken(lambda message: setattr(message.fields[0], "datatype", 77)), "x"),
    "a field outside of its point": (broken(lambda message: setattr(message.fields[2], "offset", 9)), "z"),
    "an offset beyond all numbers": (broken(lambda message: setattr(message.fields[2], "offset", 2**32 - 2)), "z"),
    "cut short": (broken(lambda message: setattr(message, "data", message.data[:-1])), "data"),
    "more points than bytes": (broken(lambda message: setattr(message, "width", 2**32 - 1)), ""),
    "rows shorter than their points": (broken(lambda message: organise(message, 11, row_step=12)), "row_step"),
    "points of no size": (broken(lambda message: setattr(message, "point_step", 0)), "point_step"),
    "an unknown frame": (broken(lambda message: setattr(message.header, "frame_id", "nowhere")), "nowhere"),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_cloud_makes_the_state_unknown_until_one_is_right(shared, fault):
    message, named = BROKEN[fault]
    shared.sees(cloud(WALL))
    seen = shared.peer.now()
    shared.reports(message, "points", named)
    state = shared.unknown("rejected_obstacle", after=seen)
    assert "'points'" in state.reason and named in state.reason
    assert to_cloud(shared.sees(cloud(WALL))) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


def test_a_broken_cloud_is_a_warning_if_that_is_wanted_and_the_last_one_kept(start_cloud):
    cell = start_cloud(parameters={"rejected_obstacle": "warn"})
    before = to_cloud(cell.sees(cloud(WALL)))
    message, named = BROKEN["no z"]
    cell.reports(message, "points", named)
    state = cell.state_now()
    assert (state.status, to_cloud(state)) == (CollisionState.FREE, before)


def test_two_sensors_on_one_topic_are_not_taken_for_one(start_cloud):
    cell = start_cloud(parameters={"point_cloud_ttl": 60.0})
    topic = cell.node.relative("points")
    left, right = (cell.peer.node.create_publisher(PointCloud2, topic, QOS) for _ in range(2))
    cell.peer.wait_for(lambda: left.get_subscription_count() and right.get_subscription_count(), "the subscription")

    def seen_in(status, *publishers, reason=""):
        since = cell.peer.now()

        def sent_and_seen():
            for publisher in publishers:
                publisher.publish(cloud(WALL, stamp=cell.peer.now()))
            return any(state.status == status and reason in state.reason for state in cell.states.after(since))

        return sent_and_seen

    cell.peer.wait_for(seen_in(CollisionState.FREE, left), "FREE with one sensor")
    cell.peer.wait_for(
        seen_in(CollisionState.UNKNOWN, left, right, reason="several publishers send on this topic"),
        "UNKNOWN with two sensors",
    )
    # one of them ends
    cell.peer.wait_for(seen_in(CollisionState.FREE, right), "FREE with one sensor again")


def test_a_best_effort_driver_is_received(start_cloud):
    cell = start_cloud()
    publisher = cell.scene.topic(PointCloud2, "points", qos_profile_sensor_data)

    def seen():
        publisher.publish(cloud(WALL))
        return any(to_cloud(state) < inf for state in cell.states.all())

    cell.peer.wait_for(seen, "the cloud")


def test_a_cloud_in_the_frame_of_a_link_stays_where_the_link_was(start_cloud):
    cell = start_cloud()
    # a cloud is only placed by joint states that are not younger
    cell.evaluate(**STRETCHED)
    # The tip's frame is at (1, 0, 0).
    state = cell.sees(cloud(np.array(WALL) - (1, 0, 0), frame="tip"))
    assert to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)
    assert to_cloud(cell.evaluate(**FOLDED)) == inf
    assert to_cloud(cell.evaluate(**STRETCHED)) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


def test_a_cloud_is_of_the_time_of_its_stamp(start_cloud):
    """The link with the camera has moved on before the cloud comes."""
    cell = start_cloud()
    cell.falls_silent()
    start = cell.peer.now()

    def report(positions, seconds):
        return cell.evaluated(positions, start + Duration(seconds=seconds))

    report(STRETCHED, 1.0)
    report(FOLDED, 1.5)
    message = cloud(np.array(WALL) - (1, 0, 0), frame="tip", stamp=start + Duration(seconds=1.0))
    cell.scene.topic(PointCloud2, "points")
    cell.scene.change(message, topic="points")
    assert to_cloud(report(STRETCHED, 2.0)) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


def test_nothing_is_free_before_the_first_cloud(start_cloud):
    cell = start_cloud()
    state = cell.states.ever(lambda state: "points" in state.reason, "UNKNOWN for want of points")
    assert state.status == CollisionState.UNKNOWN
    assert cell.sees(cloud(WALL)).status == CollisionState.FREE
    assert all(state.status == CollisionState.UNKNOWN for state in cell.states.all() if state.world_revision == 0)


def test_a_cloud_that_went_stale_makes_the_state_unknown(start_cloud):
    cell = start_cloud()
    assert cell.sees(cloud(WALL)).status == CollisionState.FREE

    cell.live(1.0)
    state = cell.states.wait_for(
        lambda state: "points" in state.reason, "UNKNOWN for a stale cloud", after=cell.peer.now()
    )
    assert state.status == CollisionState.UNKNOWN
    assert state.reason_code
    assert not state.distance_known
    # The heartbeat does not make it free again, and a new cloud does.
    assert all(later.status == CollisionState.UNKNOWN for later in cell.states.more(10, after=state))
    cell.live(3600.0)
    assert cell.sees(cloud(WALL)).status == CollisionState.FREE


def test_a_colliding_cloud_that_went_stale_is_never_free(start_cloud):
    cell = start_cloud()
    first = cell.sees(cloud([(2.11, 0, 0)]))
    assert first.status == CollisionState.COLLIDING
    cell.live(1.0)
    cell.states.ever(lambda state: state.header.stamp.sec > first.header.stamp.sec + 3, "three seconds")
    assert all(state.status != CollisionState.FREE for state in cell.states.after(first))


def test_a_cloud_that_went_stale_is_dropped_with_a_warning_if_that_is_wanted(start_cloud):
    cell = start_cloud(parameters={"stale_source_policy": "drop"})
    cell.sees(cloud([(2.11, 0, 0)]))
    cell.live(1.0)
    state = cell.becomes(CollisionState.FREE, "FREE without the stale cloud")
    assert any("points" in warning for warning in state.warnings)


def test_a_dropped_cloud_is_missing_once_stale_clouds_make_the_state_unknown(start_cloud):
    cell = start_cloud(parameters={"stale_source_policy": "drop"})
    cell.sees(cloud([(2.11, 0, 0)]))
    cell.live(1.0)
    cell.becomes(CollisionState.FREE, "FREE without the stale cloud")
    cell.live(3600.0)
    seen = cell.peer.now()
    cell.parameters.succeed(stale_source_policy="unknown")
    state = cell.unknown("stale_world", after=seen)
    assert all(later.status == CollisionState.UNKNOWN for later in cell.states.more(10, after=state))
    assert cell.sees(cloud(WALL)).status == CollisionState.FREE


def test_a_cloud_from_before_its_topic_was_added_again_is_not_used(start_cloud):
    cell = start_cloud()
    cell.sees(cloud(WALL))
    seen = cell.peer.now()
    cell.parameters.succeed(point_cloud_topics=[])
    cell.states.wait_for(lambda state: to_cloud(state) == inf and state.status == CollisionState.FREE, "no cloud", after=seen)
    seen = cell.peer.now()
    cell.parameters.succeed(point_cloud_topics=["points"])
    state = cell.unknown("stale_world", after=seen)
    assert all(later.status == CollisionState.UNKNOWN for later in cell.states.more(20, after=state))


def test_a_broken_cloud_does_not_keep_the_last_one_fresh(start_cloud):
    cell = start_cloud()
    cell.sees(cloud(WALL))
    cell.live(1.0)
    message, _ = BROKEN["no z"]
    publisher = cell.scene.topic(PointCloud2, "points")

    start = cell.peer.now()

    def stale():
        publisher.publish(message)
        return any(state.status == CollisionState.UNKNOWN for state in cell.states.after(start))

    cell.peer.wait_for(stale, "UNKNOWN beside broken clouds")


def test_the_age_of_a_cloud_is_that_of_its_stamp(start_cloud):
    """A cloud that was late on its way has already used up its time."""
    cell = start_cloud(parameters={"point_cloud_ttl": 1.0})
    old = cell.peer.now()
    later = cell.states.ever(lambda state: stamp_of(state) > old.nanoseconds + 1_100_000_000, "1.1 s later")
    cell.scene.topic(PointCloud2, "points", QOS).publish(cloud(WALL, stamp=old))
    cell.states.more(20, after=cell.peer.now())
    assert all(state.status == CollisionState.UNKNOWN for state in cell.states.after(later))
    cell.live(3600.0)
    assert cell.sees(cloud(WALL)).status == CollisionState.FREE


def stamp_of(state):
    return state.header.stamp.sec * 1_000_000_000 + state.header.stamp.nanosec


def test_what_the_robot_sees_of_itself_is_left_out_and_counted(start_cloud):
    cell = start_cloud(parameters={"self_filter_padding": 0.03})
    diagnostics = cell.peer.record(DiagnosticArray, "/diagnostics")
    # In the ball, just outside of it, on the bar and beyond the padding.
    state = cell.sees(cloud([(2, 0, 0), (2.11, 0, 0), (0.5, 0, 0.06), (2.3, 0, 0)]))
    assert state.status == CollisionState.FREE
    assert to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)

    def counted(array):
        return any("self" in item.key and item.value == "3" for status in array.status for item in status.values)

    diagnostics.ever(counted, "three points of the robot itself")
    # What was left out was there: it does not come back when the arm has moved away.
    state = cell.evaluate(**FOLDED)
    assert state.status == CollisionState.FREE


def test_crop_leaves_out_what_is_outside_of_the_box(start_cloud):
    cell = start_cloud(parameters={"cloud_crop_min": [0.0, -0.1, -1.0], "cloud_crop_max": [2.35, 1.0, 1.0]})
    state = cell.sees(cloud([(2.11, -0.2, 0), (2.3, 0, 0), (2.2, 0, 1.1), (-0.25, 0, 0)]))
    assert state.status == CollisionState.FREE
    assert to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


def test_voxels_are_never_farther_away_than_their_points(start_cloud):
    size = 0.05
    cell = start_cloud(parameters={"cloud_voxel_size": size})
    generator = np.random.default_rng(4)
    for _ in range(10):
        points = generator.uniform((2.3, -0.2, -0.2), (2.5, 0.2, 0.2), (200, 3))
        truth = np.linalg.norm(points.astype(np.float32) - (2, 0, 0), axis=1).min() - 0.1 - RADIUS
        assert truth - sqrt(3) * size - ACCURACY <= to_cloud(cell.sees(cloud(points))) <= truth + ACCURACY


@pytest.mark.parametrize("count", [25_000, 100_000])
def test_large_clouds_ten_times_a_second(start_cloud, count):
    """400 kB and 1.6 MB each; the last one of twenty counts, and the heartbeat goes on beneath."""
    cell = start_cloud()
    layout = LAYOUTS["as a depth camera"] if count < 50_000 else LAYOUTS["in another order"]
    generator = np.random.default_rng(5)
    far = generator.uniform((2.6, -1, -1), (3.5, 1, 1), (count, 3))
    clouds = []
    for x in np.linspace(2.5, 2.3, 20):
        far[0] = x, 0, 0
        clouds.append(cloud(far, layout=layout))
    publisher = cell.scene.topic(PointCloud2, "points", QOS)
    cell.peer.node.create_timer(0.1, lambda: publisher.publish(clouds.pop(0) if len(clouds) > 1 else clouds[0]))

    state = cell.states.ever(
        lambda state: to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY), "the last of the clouds", deadline=60.0
    )
    assert state.status == CollisionState.FREE
    assert all(to_cloud(state) > 0.17 for state in cell.states.all())


def test_the_time_from_message_to_use_is_reported(start_cloud):
    cell = start_cloud()
    diagnostics = cell.peer.record(DiagnosticArray, "/diagnostics")
    cell.sees(cloud(WALL))

    def reported(array):
        return any(
            "points" in item.key and "ms" in item.key and float(item.value) > 0
            for status in array.status
            for item in status.values
        )

    diagnostics.ever(reported, "the latency of the cloud")


def test_two_sources_count_both_and_each_grows_old_by_itself(start_cloud):
    cell = start_cloud(parameters={"point_cloud_topics": ["points", "more_points"]})
    for topic in ("points", "more_points"):
        cell.scene.topic(PointCloud2, topic, QOS)
    left, right = cloud([(2.3, 0.2, 0)]), cloud([(2.3, 0, 0)])

    def wait_for(status, publish, what):
        """The first state of this status evaluated from now on, while clouds are published again and again."""
        start = cell.peer.now()

        def found():
            publish()
            return next((state for state in cell.states.after(start) if state.status == status), None)

        return cell.peer.wait_for(found, what)

    def both():
        cell.scene.publish(left, "points")
        cell.scene.publish(right, "more_points")

    state = wait_for(CollisionState.FREE, both, "both clouds")
    assert to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)

    cell.live(2.0)
    state = wait_for(CollisionState.UNKNOWN, lambda: cell.scene.publish(left, "points"), "UNKNOWN for one stale cloud")
    assert "more_points" in state.reason
