"""Tests of blind sensors, whose point clouds show nothing of the environment: they are reported, never free space."""

from math import inf, nan, pi
from time import monotonic

import numpy as np
import pytest
from clearance_msgs.msg import CollisionState
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

from cell import PATIENCE
from point_cloud_node import ACCURACY, FOLDED, QOS, RADIUS, WALL, PointCloudNode, to_cloud
from clouds import cloud


@pytest.fixture(scope="module")
def shared(module_peer):
    """One node: every cloud replaces the one before."""
    with PointCloudNode(module_peer) as cell:
        yield cell


def on_circle(count, radius=10.0):
    angles = np.linspace(0, 2 * pi, count, endpoint=False)
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), 0 * angles], 1)


def zeros(count):
    """What many drivers write where nothing came back."""
    return np.zeros((count, 3))


# Each shows nothing of the environment: points, frame, and a word of the cause. The origin of `base` is inside of its link.
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
    with PointCloudNode(module_peer, parameters=CROP) as cell:
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
