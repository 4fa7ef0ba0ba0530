"""Tests of messages that cannot be decoded, such as text that is not UTF-8: nothing is free without their content."""

import pytest
from clearance_msgs.msg import CollisionState, ObstacleState, ObstacleStates
from moveit_msgs.msg import AttachedCollisionObject, CollisionObject, PlanningScene, PlanningSceneWorld
from octomap_msgs.msg import Octomap
from rclpy.serialization import serialize_message

from fail_safe import ZERO
from octree import OCCUPIED, Octree
from scene import attached, ball, diff, full, removal
from scene_client import SceneClient

NAME = "Tuer"


def in_latin_1(message):
    """The message as sent by a program that wrote its name as Latin-1."""
    raw = serialize_message(message)
    assert NAME.encode() in raw
    return raw.replace(NAME.encode(), "Tür ".encode("latin-1"))


FAR = Octree(0.1).set(OCCUPIED, 0.05, 5.05, 0.05)


def octomap_named():
    message = FAR.message()
    message.id = NAME
    return message


SCENES = {
    "collision_object": (CollisionObject, ball(NAME, 2.1), full()),
    "attached_collision_object": (AttachedCollisionObject, attached("tip", ball(NAME, 0.5, frame="tip")), full()),
    "planning_scene": (PlanningScene, diff(ball(NAME, 2.1)), full()),
    "planning_scene_world": (
        PlanningSceneWorld,
        PlanningSceneWorld(collision_objects=[ball(NAME, 2.1)]),
        PlanningSceneWorld(collision_objects=[ball("far", 5.0)]),
    ),
    "octomap_binary": (Octomap, octomap_named(), FAR.message()),
    "octomap_full": (Octomap, octomap_named(), FAR.message(binary=False)),
}


@pytest.mark.parametrize("topic", SCENES)
def test_what_a_message_announced_that_cannot_be_decoded_is_missing(start, topic):
    kind, message, remedy = SCENES[topic]
    cell = start()
    cell.evaluate(**ZERO)
    scene = SceneClient(cell)
    publisher = scene.topic(kind, topic)
    begin = cell.peer.now()
    publisher.publish(in_latin_1(message))
    state = cell.states.wait_for(
        lambda state: state.status == CollisionState.UNKNOWN, "UNKNOWN for what is missing", begin
    )
    if topic.startswith("octomap"):
        assert state.reason_code == "rejected_obstacle"
    else:
        assert state.reason_code == "lost_messages"
        # removing all objects brings neither attached objects nor what is allowed
        scene.publish(removal())
        assert cell.state_now().reason_code == "lost_messages"
    assert topic in state.reason
    assert any("UTF-8" in text for text in (state.reason, *state.warnings))
    scene.publish(remedy, topic=topic if isinstance(remedy, Octomap) else None)
    cell.becomes(CollisionState.FREE, "FREE again", after=state)


def test_states_of_obstacles_that_cannot_be_decoded_count_as_lost(start):
    cell = start()
    cell.evaluate(**ZERO)
    raw = in_latin_1(ObstacleStates(obstacles=[ObstacleState(name=NAME)]))
    publisher = cell.peer.node.create_publisher(ObstacleStates, cell.node.private("obstacle_states"), 10)
    # the subscription is best effort
    timer = cell.peer.node.create_timer(0.05, lambda: publisher.publish(raw))
    state = cell.unknown("lost_messages")
    assert "obstacle_states" in state.reason
    timer.cancel()
    cell.peer.between_callbacks(lambda: None)
    scene = SceneClient(cell)

    def is_free():
        scene.publish(full())
        return cell.state_now().status == CollisionState.FREE

    cell.peer.wait_for(is_free, "FREE again")
