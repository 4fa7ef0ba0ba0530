"""Tests of the fail-safe table (docs/reference/fail_safe.md): the published results of each condition."""

from math import nan

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.duration import Duration
from rclpy.time import Time
from moveit_msgs.msg import CollisionObject
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import String

import two_link
from fail_safe import LONG, NOTHING_KNOWN, ONTO, ZERO, Situation, drives, runs_out_of_memory, swapping, table
from localization import Localization
from clouds import cloud
from scene import ball, fine_mesh, obstacle, pose
from scene_client import SceneClient
from tracker import Tracker

PLANAR = """
<robot name="two_link">
  <virtual_joint name="drive" type="planar" parent_frame="odom" child_link="base"/>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="upper" link2="tip" reason="Adjacent"/>
</robot>
"""


def memory(s):
    s.evaluating()
    runs_out_of_memory(s)


def disabled(s):
    s.evaluating()
    response = s.enable(False)
    assert response.success
    assert "disabled" in response.message


def no_model(s):
    s.start(urdf=None)


def model_swap(s):
    swap = swapping(s, driving=True)
    s.is_evaluated()
    before = s.peer.now()
    swap()
    said = s.companions.of(s.cell.unknown("model_swap", after=before))
    assert all(is_nothing(said[name]) for name, is_nothing in NOTHING_KNOWN.items()), said


def no_geometry(s):
    s.describe(two_link.description_without_geometry(), "/bare/robot_description")
    s.start(urdf=None, namespace="/bare")


def no_joint_state(s):
    s.start(driving=False)


def clock_jump(s):
    s.simulated()
    s.set_back()


def no_clock(s):
    s.start(parameters={"use_sim_time": True})


def stale(s):
    cell = s.start()
    assert cell.evaluate(**ZERO).status == CollisionState.FREE
    cell.grows_old()
    cell.falls_silent()


def stale_joint(s):
    cell = s.start()
    assert cell.evaluate(**ZERO).status == CollisionState.FREE
    cell.grows_old()
    cell.driver.report(joint1=0.0)


def clock_leap(s):
    s.simulated()
    s.until("stale", lambda: s.tick(200))


def future_stamp(s):
    cell = s.evaluating()
    s.until("future_stamp", lambda: cell.driver.publish(ZERO, s.peer.now() + LONG))


def out_of_order(s):
    cell = s.evaluating()
    s.until("out_of_order", lambda: cell.driver.publish(ZERO, s.peer.now() - Duration(seconds=60)))


def malformed(s):
    s.evaluating()
    s.until("malformed", lambda: s.send(["joint1", "joint2", "joint1"], [0.0, 0.0, 0.0]))


def non_finite(s):
    s.evaluating()
    s.until("non_finite", lambda: s.cell.driver.publish({"joint1": 0.0, "joint2": nan}))


def partial(s):
    cell = s.start(driving=False)
    s.until("partial", lambda: cell.driver.publish({"joint1": 0.0}))


def no_transform(s):
    driver = drives(s).driver
    s.until("no_transform", lambda: driver.publish({"lift": 0.0}))


def blind_cloud(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"]})
    cell.driver.report(**ZERO)
    sensor = s.peer.node.create_publisher(PointCloud2, cell.node.relative("points"), 10)
    s.peer.node.create_timer(0.05, lambda: sensor.publish(cloud([[nan, nan, nan]] * 5, stamp=s.peer.now())))


def rejected_obstacle(s):
    cell = s.start()
    cell.driver.report(**ZERO)
    scene = SceneClient(cell)
    s.until("rejected_obstacle", lambda: scene.publish(ball("pillar", 9.0, frame="nowhere")))


def lost_messages(s):
    """A publisher that keeps one message overwrites what it could not send yet; bytes are published faster than they are received."""
    cell = s.start()
    cell.driver.report(**ZERO)
    scene = SceneClient(cell)
    topic = scene.topic(CollisionObject, "collision_object", QoSProfile(depth=1))
    message = serialize_message(obstacle("far", fine_mesh(2000), at=pose(9.0)))

    def overwhelm():
        for _ in range(300):
            topic.publish(message)

    s.until("lost_messages", overwhelm)


def world_update(s):
    cell = s.start()
    cell.driver.report(**ZERO)
    SceneClient(cell).publish(obstacle("fine", fine_mesh(200_000), at=pose(9.0)))
    s.ends = lambda: cell.states.ever(lambda state: state.world_revision > 0, "the mesh in force", 100.0)


def stale_world(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"]})
    cell.driver.report(**ZERO)


def lost_obstacle(s):
    cell = s.start()
    cell.driver.report(**ZERO)
    SceneClient(cell).change(ball("cart", 9.0))
    tracker = Tracker(cell, 9.0, 0.1)
    cell.states.ever(lambda state: state.world_revision > 5, "an obstacle that moves")
    tracker.falls_silent()


def missing_scene(s):
    cell = s.start(parameters={"require_planning_scene": True})
    cell.driver.report(**ZERO)


def lost_root(s):
    cell = s.start(parameters={"transform_ttl": 1.0})
    cell.driver.report(**ZERO)
    scene = SceneClient(cell)
    localization = Localization(cell)
    s.peer.wait_for(lambda: scene.publish(ball("pillar", 9.0, frame="odom")) or "pillar" in scene.obstacles(), "a pillar")
    # the root stands still, and is told of again and again
    reported = localization.reported
    s.peer.wait_for(lambda: localization.reported > reported + 20, "transforms")
    localization.fall_silent()


def deadline(s):
    s.start(parameters={"check_deadline": 1e-9})


def no_positions(s):
    s.evaluating()
    s.until("gives no positions", lambda: s.send(["joint1", "joint2"], []))


def unknown_joint(s):
    s.evaluating()
    s.until("'gripper'", lambda: s.cell.driver.publish(s.pose | {"gripper": 0.3}))


def outside_limits(s):
    s.evaluating()
    s.until("limits", lambda: s.cell.driver.publish(s.pose | {"joint1": 4.0}))


def mimic(s, policy="warn"):
    s.describe(two_link.description_with_follower(), "/mimic/robot_description")
    cell = s.start(urdf=None, namespace="/mimic", parameters={"mimic_contradiction": policy})
    cell.has_model()
    cell.driver.report(**s.pose, follower=0.5)


def mimic_contradiction(s):
    mimic(s, "unknown")


def contradiction(s):
    cell = s.evaluating(stale_after=10.0)

    def publish():
        stamp = s.peer.now()
        cell.driver.publish(s.pose, stamp)
        s.send(list(s.pose), [s.pose["joint1"], s.pose["joint2"] - 0.1], stamp)

    s.until("contradiction", publish)


def unlocated_root(s):
    srdf = s.tmp_path / "planar.srdf"
    srdf.write_text(PLANAR)
    cell = s.start("--srdf", srdf)
    scene = SceneClient(cell)
    cell.driver.report(**s.pose)
    s.peer.wait_for(lambda: scene.publish(ball("pillar", 9.0, frame="odom")) or "pillar" in scene.obstacles(), "a pillar")


def no_stamp(s):
    s.evaluating()
    s.until("no stamp", lambda: s.cell.driver.publish(s.pose, Time()))


def rejected_description(s):
    publisher = s.describe(two_link.description(), "/refused/robot_description")
    cell = s.start(urdf=None, namespace="/refused")
    cell.has_model()
    s.is_evaluated()
    publisher.publish(String(data="<robot"))


SCENARIOS = {
    "the process uses more memory than `memory_limit`; it ends with exit code 5": memory,
    "checking is turned off (`~/enable`)": disabled,
    "no robot description has arrived, or none that loads": no_model,
    "a new robot description has arrived, and its model is under construction": model_swap,
    "no link of the robot has collision geometry": no_geometry,
    "no joint state has arrived": no_joint_state,
    "the clock was set back by more than `stale_after`, and nothing arrived since": clock_jump,
    "`use_sim_time` is set and nothing arrives on `/clock`": no_clock,
    "the last joint state is older than `stale_after`": stale,
    "the last joint state with some joint is older than `stale_after`": stale_joint,
    "the clock jumped forward by more than `stale_after`": clock_leap,
    "the stamp is more than `stale_after` in the future": future_stamp,
    "the stamp is older than the last one of its publisher for these joints": out_of_order,
    "names and positions differ in number, or a joint is named twice": malformed,
    "a position is NaN or infinite": non_finite,
    "`tf` has no current transform for a joint of `transform_joints`": no_transform,
    "no message has ever named a joint of the robot": partial,
    "two publishers report different positions of a joint at about the same time": contradiction,
    "a mimic joint and its leader disagree (`mimic_contradiction: unknown`)": mimic_contradiction,
    "a cloud or octomap shows nothing of the environment (`blind_cloud: unknown`)": blind_cloud,
    "a part of the world was rejected (`rejected_obstacle: unknown`)": rejected_obstacle,
    "messages about the world were lost (`lost_messages: unknown`)": lost_messages,
    "messages about the world were received more than 0.1 s ago and are not yet applied": world_update,
    "a cloud or octomap has expired, or a cloud has never arrived": stale_world,
    "an obstacle moves, and its last state is older than `obstacle_state_ttl`": lost_obstacle,
    "a whole scene is required and has not arrived": missing_scene,
    "`tf` stopped reporting the root in the frame of the obstacles": lost_root,
    "`check_deadline` passed with undecided pairs and without a contact": deadline,
    "a joint state has names without positions, and is skipped": no_positions,
    "a joint state names a joint that the robot does not have": unknown_joint,
    "a joint is outside its limits": outside_limits,
    "a mimic joint and its leader disagree (`mimic_contradiction: warn`)": mimic,
    "`tf` has never located the root for obstacles in the virtual joint's frame": unlocated_root,
    "the joint state has no stamp": no_stamp,
    "the last robot description was rejected, and the previous one stays in use": rejected_description,
}


def test_every_line_has_a_scenario():
    assert [line.condition for line in table()] == list(SCENARIOS)


# What does not prevent a judgement is brought about in a free pose, and in one that collides.
POSES = {"UNKNOWN": {"": ZERO}, "FREE or COLLIDING": {"": ZERO, "_colliding": ONTO}}
CASES = {
    SCENARIOS[line.condition].__name__ + suffix: (line, pose)
    for line in table()
    for suffix, pose in POSES[line.status].items()
}


@pytest.mark.parametrize(("line", "pose"), CASES.values(), ids=CASES)
def test_the_line_holds(line, pose, peer, start, tmp_path):
    situation = Situation(peer, start, tmp_path, pose)
    SCENARIOS[line.condition](situation)
    what = f"what the table says of '{line.condition}'"
    if situation.ends:
        situation.cell.states.ever(line.holds, what)
        situation.ends()
        return
    # a driver may still report what was asked of it before
    first = situation.cell.states.wait_for(line.holds, what, after=peer.now())
    heartbeats = situation.heartbeats(first)
    assert all(line.holds(state) for state in heartbeats), heartbeats
    for state in heartbeats:
        said = situation.companions.of(state)
        assert said["is_free"] == (state.status == CollisionState.FREE)
        assert line.is_free in ("true or false", str(said["is_free"]).lower())
        if state.status == CollisionState.UNKNOWN:
            assert all(is_nothing(said[name]) for name, is_nothing in NOTHING_KNOWN.items()), said
            assert not state.distance_known


def test_what_is_enabled_again_is_evaluated_at_once(peer, start, tmp_path):
    situation = Situation(peer, start, tmp_path)
    cell = situation.evaluating()
    for enabled, status in [(False, CollisionState.UNKNOWN), (True, CollisionState.FREE)] * 2:
        assert situation.enable(enabled).success
        # nothing older is published after the response
        state = cell.states.event(lambda _: True, "a state", since=peer.now())
        assert (state.status, state.reason_code) == (status, "" if enabled else "disabled")


def test_joint_states_after_the_clock_was_set_back_are_evaluated(peer, start, tmp_path):
    situation = Situation(peer, start, tmp_path)
    cell = situation.simulated()
    situation.set_back()
    assert cell.evaluated(ZERO, Time(seconds=10)).status == CollisionState.FREE
