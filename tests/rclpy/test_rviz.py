"""Tests of `launch_scripts/clearance.rviz`: topics and markers of the node, with display classes of RViz."""

import re
from pathlib import Path

import pytest
import yaml
from rclpy.qos import DurabilityPolicy

CONFIG = Path(__file__).resolve().parents[2] / "launch_scripts/clearance.rviz"

# From plugins_description.xml of rviz_default_plugins and of moveit_ros_visualization, and rviz_common's own panels.
KNOWN_CLASSES = {
    "rviz_common/Displays",
    "rviz_common/Selection",
    "rviz_common/Views",
    "rviz_default_plugins/FocusCamera",
    "rviz_default_plugins/Grid",
    "rviz_default_plugins/Interact",
    "rviz_default_plugins/MarkerArray",
    "rviz_default_plugins/Measure",
    "rviz_default_plugins/MoveCamera",
    "rviz_default_plugins/Orbit",
    "rviz_default_plugins/RobotModel",
    "rviz_default_plugins/Select",
    "rviz_default_plugins/TF",
    "moveit_rviz_plugin/PlanningScene",
}


@pytest.fixture(scope="module")
def config():
    return yaml.safe_load(CONFIG.read_text())


def mappings(value):
    """Every mapping in a document."""
    if isinstance(value, dict):
        yield value
    for inside in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from mappings(inside)


def test_every_class_is_one_of_rviz(config):
    classes = {mapping["Class"] for mapping in mappings(config) if mapping.get("Class")}
    assert classes <= KNOWN_CLASSES
    assert {"rviz_default_plugins/RobotModel", "rviz_default_plugins/MarkerArray"} <= classes


def test_subscribed_topics_are_published_with_compatible_qos(config, peer, start):
    node = start(name="clearance", namespace="").node
    displays = config["Visualization Manager"]["Displays"]
    arrays = [display["Topic"] for display in displays if display["Class"].endswith("/MarkerArray")]
    assert {topic["Value"] for topic in arrays} == {
        node.private(name) for name in ("markers", "link_volumes", "swept_volume")
    }
    for topic in arrays:

        def publishers(name=topic["Value"]):
            return peer.node.get_publishers_info_by_topic(name)

        (info,) = peer.wait_for(publishers, f"a publisher of {topic['Value']}")
        assert info.topic_type == "visualization_msgs/msg/MarkerArray"
        if topic["Durability Policy"] == "Transient Local":
            assert info.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
    (scene,) = (display for display in displays if display["Class"].endswith("/PlanningScene"))
    peer.wait_for(
        lambda: peer.node.get_publishers_info_by_topic(scene["Planning Scene Topic"]), "a publisher of the scene"
    )


def test_every_namespace_of_markers_is_listed(config):
    topics = CONFIG.parents[1] / "crates/ros/src/topics"
    source = "".join(path.read_text() for path in [topics / "markers.rs", *sorted(topics.glob("markers/*.rs"))])
    (findings,) = (d for d in config["Visualization Manager"]["Displays"] if d["Name"] == "Findings")
    namespaces = re.findall(r'^const \w+: &str = "(\w+)";', source, re.MULTILINE)
    assert sorted(findings["Namespaces"]) == sorted(namespaces)
