"""Tests of warnings about publishers of world topics from which the node cannot receive."""

import pytest
from clearance_msgs.msg import CollisionState
from moveit_msgs.msg import CollisionObject
from rclpy.qos import QoSProfile, ReliabilityPolicy
from std_msgs.msg import Float64
from tf2_msgs.msg import TFMessage

BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
VOLATILE = QoSProfile(depth=1)

PUBLISHERS = {
    "best effort": (CollisionObject, "collision_object", BEST_EFFORT, "it offers best effort, volatile"),
    "of another type": (Float64, "octomap_binary", VOLATILE, "octomap_binary has the type std_msgs::msg::dds_::Float64_"),
    "volatile": (TFMessage, "tf_static", VOLATILE, "it offers reliable, volatile"),
}


@pytest.mark.parametrize("fault", PUBLISHERS)
def test_a_publisher_that_is_not_received_is_a_warning_while_it_exists(cell, fault):
    kind, topic, quality, named = PUBLISHERS[fault]
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    publisher = cell.peer.node.create_publisher(kind, cell.node.relative(topic), quality)

    def warned(state):
        return any(topic in text and named in text for text in state.warnings)

    cell.states.wait_for(
        lambda state: state.status == CollisionState.FREE and warned(state), "FREE with a warning", after=cell.peer.now()
    )
    cell.peer.node.destroy_publisher(publisher)
    cell.states.wait_for(
        lambda state: state.status == CollisionState.FREE and not warned(state), "FREE without it", after=cell.peer.now()
    )
