"""Tests of the node in the ROS graph: names, types and quality of service of its endpoints, and remapped topics."""

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy, qos_profile_sensor_data
from sensor_msgs.msg import JointState
from std_msgs.msg import String

import two_link

PUBLISHED = {
    "~/state": "clearance_msgs/msg/CollisionState",
    "~/heartbeat_state": "clearance_msgs/msg/CollisionState",
    "~/is_free": "std_msgs/msg/Bool",
    "~/distance": "std_msgs/msg/Float64",
    "~/self_distance": "std_msgs/msg/Float64",
    "~/world_distance": "std_msgs/msg/Float64",
    "~/speed_scale": "std_msgs/msg/Float64",
    "~/separation": "clearance_msgs/msg/Separation",
    "~/time_to_contact": "std_msgs/msg/Float64",
    "~/retreat_direction": "sensor_msgs/msg/JointState",
    "~/certificates": "std_msgs/msg/String",
    "~/swept_volume": "visualization_msgs/msg/MarkerArray",
    "~/markers": "visualization_msgs/msg/MarkerArray",
    "~/link_volumes": "visualization_msgs/msg/MarkerArray",
    "monitored_planning_scene": "moveit_msgs/msg/PlanningScene",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/rosout": "rcl_interfaces/msg/Log",
    "/parameter_events": "rcl_interfaces/msg/ParameterEvent",
}
SUBSCRIBED = {
    "joint_states": "sensor_msgs/msg/JointState",
    "robot_description": "std_msgs/msg/String",
}
SERVICES = {
    "~/enable": "std_srvs/srv/SetBool",
    "~/check_motion": "clearance_msgs/srv/CheckMotion",
    "~/check_motions": "clearance_msgs/srv/CheckMotions",
    "~/check_trajectory": "clearance_msgs/srv/CheckTrajectory",
    "~/check_states": "clearance_msgs/srv/CheckStates",
    "~/get_distances": "clearance_msgs/srv/GetDistances",
    "~/find_free_state": "clearance_msgs/srv/FindFreeState",
    "~/describe_parameters": "rcl_interfaces/srv/DescribeParameters",
    "~/get_parameter_types": "rcl_interfaces/srv/GetParameterTypes",
    "~/get_parameters": "rcl_interfaces/srv/GetParameters",
    "~/list_parameters": "rcl_interfaces/srv/ListParameters",
    "~/set_parameters": "rcl_interfaces/srv/SetParameters",
    "~/set_parameters_atomically": "rcl_interfaces/srv/SetParametersAtomically",
}


def resolved(names, node):
    def resolve(name):
        if name.startswith("~/"):
            return node.private(name[2:])
        return name if name.startswith("/") else node.relative(name)

    return {(resolve(name), (kind,)) for name, kind in names.items()}


def flat(names_and_types):
    """The names, but for those of actions, and their types."""
    return {(name, tuple(kinds)) for name, kinds in names_and_types if "/_action/" not in name}


@pytest.mark.parametrize("namespace", ["", "/cell", "/plant/cell_7"])
def test_names_and_types_stand_in_the_graph(peer, start, namespace):
    node = start(namespace=namespace).node
    graph = peer.node

    def complete():
        if (node.name, namespace or "/") not in graph.get_node_names_and_namespaces():
            return False
        own = node.name, namespace or "/"
        return (
            resolved(PUBLISHED, node) == flat(graph.get_publisher_names_and_types_by_node(*own))
            and resolved(SUBSCRIBED, node) <= flat(graph.get_subscriber_names_and_types_by_node(*own))
            and resolved(SERVICES, node) <= flat(graph.get_service_names_and_types_by_node(*own))
        )

    peer.wait_for(complete, f"the names of {node.path}")


def test_every_publisher_is_reliable_and_the_joint_states_match_both(peer, cell):
    cell.evaluate(joint1=0, joint2=0)

    def only(infos, topic):
        """The quality of service of the only endpoint, once it is known."""
        (info,) = peer.wait_for(lambda: infos(topic), topic)
        return info.qos_profile

    for topic in ("state", "is_free", "distance", "markers"):
        quality = only(peer.node.get_publishers_info_by_topic, cell.node.private(topic))
        assert quality.reliability == ReliabilityPolicy.RELIABLE
    subscribed = peer.node.get_subscriptions_info_by_topic
    assert only(subscribed, cell.node.relative("joint_states")).reliability == ReliabilityPolicy.BEST_EFFORT
    assert only(subscribed, cell.node.relative("robot_description")).durability == DurabilityPolicy.TRANSIENT_LOCAL


def test_topics_can_be_remapped(peer, start):
    cell = start(
        urdf=None,
        ros_arguments=[
            *("-r", "joint_states:=/arm/measured_joints"),
            *("--remap", "robot_description:=arm_description"),
            *("-r", "~/state:=/safety/state"),
        ],
    )
    cell.driver.disconnect()
    driver = two_link.Driver(peer, "/arm/measured_joints")
    peer.latch(String(data=two_link.description()), cell.node.relative("arm_description"))
    states = peer.record(CollisionState, "/safety/state")

    stamp = driver.report(joint1=0, joint2=0)
    state = states.ever(lambda state: state.status == CollisionState.FREE, "a judgement")
    assert two_link.judged_since(stamp)(state)
    assert cell.states.all() == []


def test_a_best_effort_driver_is_received(peer, cell):
    cell.driver.disconnect()
    publisher = peer.node.create_publisher(JointState, cell.node.relative("joint_states"), qos_profile_sensor_data)

    def evaluate():
        message = JointState(name=list(two_link.JOINTS), position=[0.0, 0.0])
        message.header.stamp = peer.now().to_msg()
        publisher.publish(message)
        return any(state.status == CollisionState.FREE for state in cell.states.all())

    peer.wait_for(evaluate, "a judgement")
