"""Tests of two faults at once: the row that is first in the fail-safe table decides.

Each scenario brings both about, and after the `yield` takes the first one away.
"""

from math import nan

import pytest
from rclpy.duration import Duration
from rclpy.time import Time
from sensor_msgs.msg import PointCloud2

import two_link
from clouds import cloud
from fail_safe import LONG, SIMULATED, ZERO, Situation, drives, swapping, table
from localization import Localization
from scene import ball
from scene_client import SceneClient


def disabled_and_no_model(s):
    s.start(urdf=None)
    assert s.enable(False).success
    yield
    assert s.enable(True).success


def no_model_and_no_joint_state(s):
    s.start(urdf=None, namespace="/undescribed", driving=False)
    yield
    s.describe(two_link.description(), "/undescribed/robot_description")


def model_swap_and_no_joint_state(s):
    swap = swapping(s, driving=False)
    swap()
    yield
    s.ends()


def no_geometry_and_no_joint_state(s):
    topic = "/bare/robot_description"
    s.describe(two_link.description_without_geometry(), topic)
    s.start(urdf=None, namespace="/bare", driving=False)
    yield
    s.describe(two_link.description(), topic)


def no_joint_state_and_no_clock(s):
    s.start(parameters=SIMULATED, driving=False)
    yield
    s.cell.driver.resume()


def no_clock_and_stale(s):
    s.start(parameters=SIMULATED, driving=False)
    s.until("no_clock", lambda: s.cell.driver.publish(ZERO, Time(seconds=100)))
    yield
    s.until("stale", lambda: s.tick(200))


def stale_and_future_stamp(s):
    driver = s.evaluating().driver
    s.until("future_stamp", lambda: driver.publish({"joint1": 0.0}, s.peer.now() + LONG))
    s.until("stale", lambda: driver.publish({"joint2": 0.0}, s.peer.now() - LONG))
    yield
    s.until("future_stamp", lambda: driver.publish({"joint2": 0.0}))


def future_stamp_and_out_of_order(s):
    driver = s.evaluating().driver
    s.until("out_of_order", lambda: driver.publish(ZERO, s.peer.now() - Duration(seconds=60)))
    s.until("future_stamp", lambda: driver.publish({"joint1": 0.0}, s.peer.now() + LONG))
    yield
    s.until("out_of_order", lambda: driver.publish({"joint1": 0.0}))


def out_of_order_and_malformed(s):
    s.start(driving=False)
    s.until("", lambda: s.send(list(ZERO), [0.0, 0.0]))
    s.until("out_of_order", lambda: s.send(list(ZERO), [0.0], s.peer.now() - Duration(seconds=60)))
    yield
    s.until("malformed", lambda: s.send(list(ZERO), [0.0]))


def malformed_and_non_finite(s):
    s.evaluating()
    s.until("malformed", lambda: s.send(["joint2", "joint1", "joint1"], [nan, 0.0, 0.0]))
    yield
    s.until("non_finite", lambda: s.send(["joint2", "joint1"], [nan, 0.0]))


def malformed_and_later_non_finite(s):
    """In messages of two publishers."""
    driver = s.evaluating().driver

    def publish(of_joint1):
        s.send(of_joint1, [0.0] * len(of_joint1))
        driver.publish({"joint2": nan})

    s.until("malformed", lambda: publish(["joint1", "joint1"]))
    yield
    s.until("non_finite", lambda: publish(["joint1"]))


def non_finite_and_no_transform(s):
    driver = drives(s).driver
    s.until("non_finite", lambda: driver.publish({"lift": nan}))
    yield
    s.until("no_transform", lambda: driver.publish({"lift": 0.0}))


def no_transform_and_partial(s):
    driver = drives(s).driver
    s.until("no_transform", lambda: driver.publish({"gripper": 0.0}))
    yield
    Localization(s.cell)


def partial_and_contradiction(s):
    cell = s.start(parameters={"stale_after": 10.0}, driving=False)

    def contradict():
        stamp = s.peer.now()
        cell.driver.publish({"joint1": 0.0}, stamp)
        s.send(["joint1"], [0.5], stamp)

    s.until("partial", contradict)
    yield
    s.until("contradiction", lambda: (contradict(), s.send(["joint2"], [0.0])))


def contradiction_and_stale_world(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"], "stale_after": 10.0}, driving=False)

    def publish(joint2):
        stamp = s.peer.now()
        cell.driver.publish(ZERO, stamp)
        s.send(list(ZERO), [0.0, joint2], stamp)

    s.until("contradiction", lambda: publish(0.5))
    yield
    s.until("stale_world", lambda: publish(0.0))


def partial_and_stale_world(s):
    driver = s.start(parameters={"point_cloud_topics": ["points"]}, driving=False).driver
    s.until("partial", lambda: driver.publish({"joint1": 0.0}))
    yield
    s.until("stale_world", lambda: driver.publish(ZERO))


def contradiction_and_rejected_obstacle(s):
    cell = s.start(parameters={"stale_after": 10.0}, driving=False)
    scene = SceneClient(cell)

    def publish(joint2):
        stamp = s.peer.now()
        cell.driver.publish(ZERO, stamp)
        s.send(list(ZERO), [0.0, joint2], stamp)
        scene.publish(ball("pillar", 9.0, frame="nowhere"))

    s.until("contradiction", lambda: publish(0.5))
    yield
    s.until("rejected_obstacle", lambda: publish(0.0))


def blind_cloud_and_rejected_obstacle(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"], "point_cloud_ttl": 3600.0})
    cell.driver.report(**ZERO)
    scene = SceneClient(cell)
    sensor = s.peer.node.create_publisher(PointCloud2, cell.node.relative("points"), 10)
    scene.publish(ball("pillar", 9.0, frame="nowhere"))
    s.until("blind_cloud", lambda: sensor.publish(cloud([[nan, nan, nan]], stamp=s.peer.now())))
    yield
    s.until("rejected_obstacle", lambda: sensor.publish(cloud([[5.0, 5.0, 5.0]], stamp=s.peer.now())))


def rejected_obstacle_and_stale_world(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"]})
    cell.driver.report(**ZERO)
    scene = SceneClient(cell)
    s.until("rejected_obstacle", lambda: scene.publish(ball("pillar", 9.0, frame="nowhere")))
    yield
    s.until("stale_world", lambda: scene.publish(ball("pillar", 9.0)))


def stale_world_and_deadline(s):
    s.start(parameters={"point_cloud_topics": ["points"], "check_deadline": 1e-9})
    yield
    sensor = s.peer.node.create_publisher(PointCloud2, s.cell.node.relative("points"), 10)
    s.until("deadline", lambda: sensor.publish(cloud([[5.0, 5.0, 5.0]], stamp=s.peer.now())))


TWO_FAULTS = [
    ("disabled", "no_model", disabled_and_no_model),
    ("no_model", "no_joint_state", no_model_and_no_joint_state),
    ("model_swap", "no_joint_state", model_swap_and_no_joint_state),
    ("no_geometry", "no_joint_state", no_geometry_and_no_joint_state),
    ("no_joint_state", "no_clock", no_joint_state_and_no_clock),
    ("no_clock", "stale", no_clock_and_stale),
    ("stale", "future_stamp", stale_and_future_stamp),
    ("future_stamp", "out_of_order", future_stamp_and_out_of_order),
    ("out_of_order", "malformed", out_of_order_and_malformed),
    ("malformed", "non_finite", malformed_and_non_finite),
    ("malformed", "non_finite", malformed_and_later_non_finite),
    ("non_finite", "no_transform", non_finite_and_no_transform),
    ("no_transform", "partial", no_transform_and_partial),
    ("partial", "contradiction", partial_and_contradiction),
    ("contradiction", "stale_world", contradiction_and_stale_world),
    ("partial", "stale_world", partial_and_stale_world),
    ("contradiction", "rejected_obstacle", contradiction_and_rejected_obstacle),
    ("blind_cloud", "rejected_obstacle", blind_cloud_and_rejected_obstacle),
    ("rejected_obstacle", "stale_world", rejected_obstacle_and_stale_world),
    ("stale_world", "deadline", stale_world_and_deadline),
]


@pytest.mark.parametrize(("first", "second", "scenario"), TWO_FAULTS, ids=[case[2].__name__ for case in TWO_FAULTS])
def test_of_two_faults_the_line_that_stands_first_decides(first, second, scenario, peer, start, tmp_path):
    codes = [line.reason_code for line in table()]
    assert codes.index(first) < codes.index(second)
    situation = Situation(peer, start, tmp_path)
    steps = scenario(situation)
    before = peer.now()
    next(steps)
    cell = situation.cell
    state = cell.unknown(first, after=before if situation.ends else peer.now())
    if not situation.ends:
        assert {state.reason_code for state in situation.heartbeats(state)} == {first}
    before = peer.now()
    next(steps, None)
    cell.unknown(second, after=before)
