"""Tests of requesting the scene of another node, such as `move_group`, when its service appears.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0).
"""

import re

import pytest
from clearance_msgs.msg import CollisionState
from moveit_msgs.msg import CollisionObject, PlanningScene
from rclpy.qos import DurabilityPolicy, QoSProfile

from move_group import MoveGroup
from scene import ball, diff, fine_mesh, full, obstacle, pose, sphere
from scene_client import SceneClient, distances

SERVICE = "/other/get_planning_scene"
STRETCHED = {"joint1": 0, "joint2": 0}
NEARBY = {"influence_distance": 0.5}
ASKING = NEARBY | {"planning_scene_service": SERVICE}


def names(state):
    """Of the obstacles near the tip."""
    return {name for pair in distances(state) for name in pair} - {"base", "upper", "tip"}


def wait_for_names(cell, *wanted):
    return cell.states.wait_for(
        lambda state: state.status == CollisionState.FREE and names(state) == set(wanted),
        f"{wanted} near, and FREE",
        after=cell.peer.now(),
    )


def test_nothing_is_free_before_the_scene_is_received(start, domain_id):
    cell = start(parameters=ASKING)
    cell.driver.report(**STRETCHED)
    assert SERVICE in cell.unknown("stale_world").reason
    with MoveGroup(domain_id, SERVICE, full(ball("a", 2.3))):
        wait_for_names(cell, "a")
        assert not [state for state in cell.states.all() if state.status == CollisionState.FREE and not names(state)]


def test_a_scene_that_was_there_before_is_asked_for(start, domain_id):
    """The node is the one that comes later, and comes again."""
    with MoveGroup(domain_id, SERVICE, full(ball("a", 2.3))) as other:
        cell = start(parameters=ASKING)
        cell.driver.report(**STRETCHED)
        wait_for_names(cell, "a")
        cell.restart_node()
        cell.peer.wait_for(lambda: other.calls > 1, "the question of the other node")
        wait_for_names(cell, "a")


def test_the_node_neither_calls_nor_receives_from_itself(start):
    cell = start(
        parameters=ASKING | {"planning_scene_service": "get_planning_scene"},
        ros_arguments=["-r", "planning_scene:=monitored_planning_scene"],
    )
    cell.driver.report(**STRETCHED)
    topic = cell.node.relative("monitored_planning_scene")
    own = cell.peer.record(PlanningScene, topic, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    own.ever(lambda scene: not scene.is_diff, "the node's own scene")
    cell.peer.wait_for(lambda: "is the service of this node itself" in cell.node.output(), "a word about it")
    assert {state.reason_code for state in cell.states.more(10, after=cell.peer.now())} == {"stale_world"}


def test_one_that_has_no_robot_yet_reports_nothing(start, domain_id):
    cell = start(parameters=ASKING)
    cell.driver.report(**STRETCHED)

    def forget(asked):
        # until the node has heard it: the first answer may come too late for the node
        asked.scene.robot_model_name = "two_link" if "returns a scene without a robot" in cell.node.output() else ""

    with MoveGroup(domain_id, SERVICE, full(ball("a", 2.3)), forget):
        wait_for_names(cell, "a")
    assert "returns a scene without a robot" in cell.node.output()


def test_one_that_is_started_again_is_asked_again(start, domain_id):
    cell = start(parameters=ASKING)
    cell.driver.report(**STRETCHED)
    for name in ("a", "b", "c"):
        with MoveGroup(domain_id, SERVICE, full(ball(name, 2.3))):
            wait_for_names(cell, name)


def test_the_parameter_may_change(start, domain_id):
    cell = start(parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    wait_for_names(cell)
    with MoveGroup(domain_id, SERVICE, full(ball("a", 2.3))):
        cell.parameters.succeed(planning_scene_service=SERVICE)
        wait_for_names(cell, "a")
    cell.parameters.succeed(planning_scene_service="")
    with MoveGroup(domain_id, "/another/get_planning_scene", full(ball("b", 2.3))):
        cell.parameters.succeed(planning_scene_service="/another/get_planning_scene")
        wait_for_names(cell, "b")


def test_an_answer_that_a_change_overtook_is_asked_for_again(start, domain_id):
    cell = start(parameters=ASKING | {"heartbeat_rate": 50.0})
    cell.driver.report(**STRETCHED)
    changes = SceneClient(cell)
    changes.topic(PlanningScene, "planning_scene")
    old, new = full(ball("a", 2.3)), full(ball("a", 2.3), ball("b", 2.3, 0.3))

    def overtake(asked):
        if asked.calls == 1:
            asked.scene = new
            changes.change(diff(ball("b", 2.3, 0.3)))

    with MoveGroup(domain_id, SERVICE, old, overtake) as other:
        wait_for_names(cell, "a", "b")
        assert other.calls > 1
        assert {frozenset(names(state)) for state in cell.states.all() if state.status == CollisionState.FREE} == {frozenset("ab")}


@pytest.mark.parametrize(("depth", "shape"), [(1, fine_mesh(2000)), (1000, sphere(0.1))], ids=["large, one kept", "small, all kept"])
def test_every_object_has_come_or_is_missed_aloud(start, depth, shape):
    """A publisher that keeps one message overwrites what it could not send yet."""
    count = 300
    cell = start(parameters=NEARBY | {"lost_messages": "warn"})
    cell.evaluate(**STRETCHED)
    scene = SceneClient(cell)
    topic = scene.topic(CollisionObject, "collision_object", QoSProfile(depth=depth))
    scene.change(ball("first", 9.0))
    for number in range(count):
        topic.publish(obstacle(f"far{number}", shape, at=pose(9.0)))
    topic.publish(ball("last", 2.3))
    wait_for_names(cell, "last")
    warnings = cell.state_now().warnings  # they follow what they are about
    lost = sum(int(number) for text in warnings for number in re.findall(r"collision_object: (\d+) messages were lost", text))
    known = len(scene.get("WORLD_OBJECT_NAMES").world.collision_objects)
    assert known + lost == count + 2, warnings
    scene.publish(full(ball("only", 2.3)))
    cell.states.ever(lambda state: names(state) == {"only"} and not state.warnings, "a whole scene, and no word of what was lost")
