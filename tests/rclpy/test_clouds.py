"""Point clouds of every layout, and what becomes of them when they grow old.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0). Every point has a radius of 0.02.
"""

from math import inf, nan, pi, sqrt
from time import monotonic

import numpy as np
import pytest
from clearance_msgs.msg import BodyPair, CollisionState
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2, PointField
from tf2_msgs.msg import TFMessage

from cell import PATIENCE, Cell
from clouds import FLOAT32, FLOAT64, PLAIN, Layout, cloud
from scene_client import SceneClient

ACCURACY = 1e-5  # [m] coordinates of single precision
RADIUS = 0.02
STRETCHED = {"joint1": 0, "joint2": 0}
FOLDED = {"joint1": 0, "joint2": 5 * pi / 6}
NEARBY = {"influence_distance": 0.5, "distance_limit": 3.0}
# Points that touch the robot would be taken for it.
UNFILTERED = {"self_filter_padding": 0.0}
AGELESS = UNFILTERED | {"point_cloud_topics": ["points"], "point_radius": RADIUS, "point_cloud_ttl": 3600.0}
QOS = QoSProfile(depth=10)

# 0.2 before the ball, and farther away all around.
WALL = [(2.3, y / 10, z / 10) for y in range(-5, 6) for z in range(-5, 6)]


class CloudCell(Cell):
    """A cell whose node listens to the topic `points`."""

    def __init__(self, peer, *arguments, parameters=None, **options):
        super().__init__(peer, *arguments, parameters=NEARBY | AGELESS | (parameters or {}), **options)

    def __enter__(self):
        super().__enter__()
        self.scene = SceneClient(self)
        self.driver.report(**STRETCHED)
        return self

    def sees(self, message, qos=QOS):
        """The first state judged with this cloud, which gets a stamp of now."""
        message.header.stamp = self.peer.now().to_msg()
        self.scene.topic(PointCloud2, "points", qos)
        return self.scene.change(message, topic="points")

    def live(self, seconds):
        """From now on clouds count so long."""
        self.parameters.succeed(point_cloud_ttl=seconds)

    def says(self, message, *words, qos=QOS):
        """The complaint about this cloud, which changes nothing."""
        message.header.stamp = self.peer.now().to_msg()
        self.scene.topic(PointCloud2, "points", qos)
        return self.scene.refused(message, *words, topic="points")


@pytest.fixture
def start_cloud(peer, request):
    def start(**options):
        cell = CloudCell(peer, **options)
        cell.__enter__()
        request.addfinalizer(lambda: cell.__exit__(None, None, None))
        return cell

    return start


@pytest.fixture(scope="module")
def shared(module_peer):
    """One node: every cloud replaces the one before."""
    with CloudCell(module_peer) as cell:
        yield cell


def to_cloud(state):
    """The least distance to a body that is no link."""
    return min(
        (near.distance for near in state.pair_distances if BodyPair.OBSTACLE in (near.pair.type_a, near.pair.type_b)),
        default=inf,
    )


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


def on_circle(count, radius=10.0):
    angles = np.linspace(0, 2 * pi, count, endpoint=False)
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), 0 * angles], 1)


def zeros(count):
    """What many drivers write where nothing came back."""
    return np.zeros((count, 3))


# Each shows nothing of the room: points, frame, and a word of the cause. The origin of `base` is inside of its link.
BLIND = {
    "empty": ([], "base", "no points"),
    "all NaN": ([(nan, nan, nan)] * 5, "base", "none of its 5 points"),
    "all infinite": ([(inf, 0, 0), (0, -inf, 0)], "base", "none of its 2 points"),
    "all far away": ([(1e30, 0, 0)], "base", "none of its 1 points"),
    "all zero inside of a link": (zeros(1000), "base", "none of its 1000 points"),
    "all zero in the frame of another link": (zeros(1000), "tip", "none of its 1000 points"),
    "a single zero": (zeros(1), "base", "none of its 1 points"),
    "zeros and NaN": (np.concatenate([zeros(500), [(nan, nan, nan)] * 500]), "base", "none of its 1000 points"),
    "next to zero": ([(1e-7, 0, 0), (0, -1e-7, 1e-8)], "base", "none of its 2 points"),
    "all cropped": ([(50, 0, 0), (60, 0, 0)], "base", "all of its 2 points"),
    "cropped or zero": (np.concatenate([zeros(9), [(50, 0, 0), (60, 0, 0)]]), "base", "all of its 2 points"),
    "cropped but for one zero": ([(0, 0, 0), (50, 0, 0)], "base", "all of its 1 points"),
    "all at the range limit": (on_circle(100), "base", "10.000 m"),
    "ten at the range limit": (on_circle(10), "base", "10.000 m"),
    "three at the range limit": (on_circle(3), "base", "10.000 m"),
    "all at the range limit but one zero": (np.concatenate([on_circle(1000), zeros(1)]), "base", "10.000 m"),
    "zeros and the range limit": (np.concatenate([zeros(100), on_circle(100)]), "base", "10.000 m"),
    "NaN and the range limit": (np.concatenate([[(nan, nan, nan)] * 100, on_circle(100)]), "base", "10.000 m"),
    "a range limit that reaches the robot": (on_circle(100, 2.0), "base", "2.000 m"),
    "one place again and again": ([(0.3, 0.5, 1.1)] * 10, "base", "as if that were the range"),
}


CROP = {"cloud_crop_min": [-20.0] * 3, "cloud_crop_max": [20.0] * 3}

def published_until(cell, message, is_there, what):
    """The first state of which this holds after the cloud was published: again if it is lost, and no more often, for a copy would count later."""
    publisher = cell.scene.topic(PointCloud2, "points", QOS)
    seen = cell.peer.now()
    sent = []  # times [s] of publishing

    def found():
        if not sent or monotonic() > sent[-1] + PATIENCE:
            sent.append(monotonic())
            message.header.stamp = cell.peer.now().to_msg()
            publisher.publish(message)
        return next((state for state in cell.states.after(seen) if is_there(state)), None)

    return cell.peer.wait_for(found, what)


def is_blind(state):
    return state.status == CollisionState.UNKNOWN and state.reason_code == "blind_cloud"


@pytest.fixture(scope="module")
def cropping(module_peer):
    """One node with a crop box for all blind clouds."""
    with CloudCell(module_peer, parameters=CROP) as cell:
        yield cell


def blind(kind):
    points, frame, cause = BLIND[kind]
    return cloud(points, frame=frame), cause


@pytest.mark.parametrize("kind", ["empty", "all zero inside of a link", "all at the range limit"])
def test_a_sensor_whose_first_cloud_shows_nothing_is_blind(start_cloud, kind):
    cell = start_cloud(parameters=CROP)
    message, cause = blind(kind)
    first = published_until(cell, message, is_blind, "UNKNOWN for a blind sensor")
    assert "'points'" in first.reason and cause in first.reason
    assert all(state.status != CollisionState.FREE for state in cell.states.all())


@pytest.mark.parametrize("kind", BLIND)
def test_a_sensor_that_shows_nothing_is_blind_and_no_empty_room(cropping, kind):
    message, cause = blind(kind)
    state = cropping.sees(cloud([(2.11, 0, 0)]))
    assert state.status == CollisionState.COLLIDING
    seen = cropping.peer.now()
    state = published_until(cropping, message, is_blind, "UNKNOWN for a sensor gone blind")
    assert "'points'" in state.reason and cause in state.reason
    assert not cropping.scene.validity(FOLDED).valid
    assert all(state.status != CollisionState.FREE for state in cropping.states.after(seen))
    # the last cloud that showed something is in force beside that
    cropping.parameters.succeed(blind_cloud="warn")
    cropping.becomes(CollisionState.COLLIDING, "a state in the last cloud that showed something")
    cropping.parameters.succeed(blind_cloud="unknown")
    assert cropping.sees(cloud(WALL)).status == CollisionState.FREE


@pytest.fixture
def warning(cropping):
    cropping.parameters.succeed(blind_cloud="warn")
    yield cropping
    cropping.parameters.succeed(blind_cloud="unknown")


@pytest.mark.parametrize("kind", BLIND)
def test_a_blind_sensor_is_a_warning_if_that_is_wanted(warning, kind):
    message, cause = blind(kind)
    assert warning.sees(cloud(WALL)).status == CollisionState.FREE
    state = published_until(warning, message, lambda state: any(cause in text for text in state.warnings), "a warning")
    assert state.status == CollisionState.FREE


def test_a_cloud_of_the_robot_alone_is_not_blind(start_cloud):
    cell = start_cloud(parameters={"self_filter_padding": 0.03})
    state = cell.sees(cloud([(2, 0, 0), (1.5, 0, 0), (nan, nan, nan)]))
    assert (state.status, to_cloud(state)) == (CollisionState.FREE, inf)


SEEN = {
    "a wall": WALL,
    "a wall and zeros": np.concatenate([WALL, zeros(500)]),
    "a wall and the range limit": np.concatenate([WALL, on_circle(1000)]),
    "one place before it": [(2.3, 0, 0)],
    "one place and zeros": np.concatenate([[(2.3, 0, 0)], zeros(500)]),
}


@pytest.mark.parametrize("kind", SEEN)
def test_a_sensor_that_shows_something_is_not_blind(shared, kind):
    state = shared.sees(cloud(SEEN[kind]))
    assert state.status == CollisionState.FREE
    assert to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


def test_zeros_are_no_obstacles_but_one_cell_of_a_map_is(start_cloud):
    """The origin of the frame `map` is before the ball."""
    cell = start_cloud()
    transform = TransformStamped(child_frame_id="map")
    transform.header.frame_id = "base"
    transform.transform.translation.x = 2.11
    cell.scene.topic(TFMessage, "tf_static").publish(TFMessage(transforms=[transform]))
    elsewhere = [(0.3, 0.1, 0), (0.3, 0.2, 0.1)]
    state = published_until(
        cell, cloud([*zeros(5), *elsewhere], frame="map"), lambda state: state.status == CollisionState.FREE, "FREE beside zeros"
    )
    assert to_cloud(state) > 0.1
    assert cell.sees(cloud([*zeros(1), *elsewhere], frame="map")).status == CollisionState.COLLIDING


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
    shared.says(message, "points", named)
    state = shared.unknown("rejected_obstacle", after=seen)
    assert "'points'" in state.reason and named in state.reason
    assert to_cloud(shared.sees(cloud(WALL))) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


def test_a_broken_cloud_is_a_warning_if_that_is_wanted_and_the_last_one_kept(start_cloud):
    cell = start_cloud(parameters={"rejected_obstacle": "warn"})
    before = to_cloud(cell.sees(cloud(WALL)))
    message, named = BROKEN["no z"]
    cell.says(message, "points", named)
    state = cell.state_now()
    assert (state.status, to_cloud(state)) == (CollisionState.FREE, before)


def test_a_best_effort_driver_is_heard(start_cloud):
    cell = start_cloud()
    publisher = cell.scene.topic(PointCloud2, "points", qos_profile_sensor_data)

    def seen():
        publisher.publish(cloud(WALL))
        return any(to_cloud(state) < inf for state in cell.states.all())

    cell.peer.wait_for(seen, "the cloud")


def test_a_cloud_in_the_frame_of_a_link_stays_where_the_link_was(start_cloud):
    cell = start_cloud()
    # The tip's frame is at (1, 0, 0).
    state = cell.sees(cloud(np.array(WALL) - (1, 0, 0), frame="tip"))
    assert to_cloud(state) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)
    assert to_cloud(cell.judged(**FOLDED)) == inf
    assert to_cloud(cell.judged(**STRETCHED)) == pytest.approx(0.2 - RADIUS, abs=ACCURACY)


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
    state = cell.judged(**FOLDED)
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


def test_the_time_from_message_to_use_is_told(start_cloud):
    cell = start_cloud()
    diagnostics = cell.peer.record(DiagnosticArray, "/diagnostics")
    cell.sees(cloud(WALL))

    def told(array):
        return any(
            "points" in item.key and "ms" in item.key and float(item.value) > 0
            for status in array.status
            for item in status.values
        )

    diagnostics.ever(told, "the latency of the cloud")


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
