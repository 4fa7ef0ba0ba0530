"""Tests of `clearance doctor`: it reports faults of the ROS network and the robot, and nothing else."""

import json
import subprocess
from math import nan

import pytest
from moveit_msgs.msg import CollisionObject
from rclpy.duration import Duration
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

import two_link
from node_process import BINARY, ROOT, environment_of_node


def doctor(domain_id, *arguments, code, wait=3.0, **environment):
    """Its findings: (verdict, about, text)."""
    command = [BINARY, "doctor", *map(str, arguments), "--wait", str(wait), "--format", "json"]
    done = subprocess.run(
        command, cwd=ROOT, env=environment_of_node(domain_id, environment), capture_output=True, text=True, timeout=100
    )
    assert done.returncode == code, done.stdout + done.stderr
    return [(finding["verdict"], finding["about"], finding["text"]) for finding in json.loads(done.stdout)]


def wrong(findings):
    return {about: text for verdict, about, text in findings if verdict == "wrong"}


def test_where_everything_runs_nothing_is_wrong(peer, domain_id):
    two_link.Driver(peer, "/joint_states")
    peer.latch(String(data=two_link.description()), "/robot_description")
    findings = doctor(domain_id, code=0)
    assert not wrong(findings)
    texts = " ".join(text for _, _, text in findings)
    assert "'two_link'" in texts and "'joint1' and 'joint2'" in texts and "free of itself" in texts and "comes back" in texts


def test_nodes_of_one_name_are_counted(peer, start, domain_id):
    two_link.Driver(peer, "/twins/joint_states")
    given = "--urdf", two_link.URDF, "--ros-args", "-r", "__ns:=/twins", "--"
    for expected, words in ("note", "no node is named"), ("good", "/twins/clearance is there"), ("wrong", "2 nodes are named"):
        findings = doctor(domain_id, *given, code=int(expected == "wrong"))
        verdict, text = next((verdict, text) for verdict, about, text in findings if about == "node")
        assert (verdict, words in text) == (expected, True), text
        if expected != "wrong":
            start(name="clearance", namespace="/twins", driving=False)


def test_the_srdf_of_another_robot_is_wrong_and_reported_once(peer, domain_id, tmp_path):
    two_link.Driver(peer, "/joint_states")
    srdf = tmp_path / "other.srdf"
    srdf.write_text('<robot name="other"><disable_collisions link1="a" link2="b" reason="Never"/></robot>')
    given = "--urdf", two_link.URDF, "--srdf", srdf
    findings = doctor(domain_id, *given, code=1)
    assert "right file?" in wrong(findings)["robot"]
    assert sum("the SRDF is of robot 'other'" in text for _, _, text in findings) == 1


def test_topics_that_nobody_publishes_are_named(domain_id):
    findings = wrong(doctor(domain_id, code=1, wait=0.5))
    assert findings.keys() == {"robot_description", "joint_states"}
    assert all(f"domain {domain_id}" in text for text in findings.values())


def test_joints_that_are_not_the_robots_are_named(peer, domain_id):
    driver = two_link.Driver(peer, "/joint_states")
    driver.report(shoulder=0, joint1=0)
    findings = doctor(domain_id, "--urdf", two_link.URDF, code=1)
    assert "joint2" in wrong(findings)["joint_states"]


def test_a_name_by_remap_and_a_position_that_is_none(peer, domain_id):
    driver = two_link.Driver(peer, "/arm/states")
    driver.report(joint1=0, joint2=nan)
    findings = doctor(domain_id, "--urdf", two_link.URDF, "--ros-args", "-r", "joint_states:=/arm/states", "--", code=1)
    assert "joint2" in wrong(findings)["joint_states"]


def test_parameters_that_say_which_joints_are_the_robots_are_heeded(peer, domain_id):
    two_link.Driver(peer, "/joint_states").report(left_joint1=0, left_joint2=0)
    given = "--urdf", two_link.URDF, "--ros-args", "-p", "joint_prefix:=left_", "--"
    assert not wrong(doctor(domain_id, *given, code=0))
    rover = "--urdf", "tests/rclpy/rover.urdf", "--ros-args", "-p", "transform_joints:=[drive]", "--"
    assert "'drive'" in wrong(doctor(domain_id, *rover, code=1))["joint_states"]


SIMULATED = "--urdf", two_link.URDF, "--ros-args", "-p", "use_sim_time:=true", "--"


def test_topics_of_obstacles_that_the_node_cannot_read_are_named(peer, domain_id):
    two_link.Driver(peer, "/joint_states")
    peer.latch(String(data=two_link.description()), "/robot_description")
    others = [
        peer.node.create_publisher(String, "/clearance/obstacle_states", 1),
        peer.node.create_publisher(CollisionObject, "/collision_object", QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)),
        peer.node.create_publisher(String, "/camera/points", 1),
    ]
    given = "--ros-args", "-p", "point_cloud_topics:=[/camera/points]", "--"
    texts = [text for verdict, about, text in doctor(domain_id, *given, code=1) if (verdict, about) == ("wrong", "peers")]
    for topic in "/clearance/obstacle_states has the type", "of /collision_object is incompatible", "/camera/points has the type":
        assert sum(topic in text for text in texts) == 1, texts
    assert len(texts) == len(others)


def test_simulated_time_that_nobody_publishes_is_missed(peer, domain_id):
    two_link.Driver(peer, "/joint_states")
    findings = wrong(doctor(domain_id, *SIMULATED, code=1))
    assert "use_sim_time" in findings["clock"] and "--clock" in findings["clock"]
    assert "/clock" in findings["joint_states"]


def test_stamps_of_a_played_bag_are_evaluated_by_its_clock(peer, domain_id):
    """Joint states of 1970, as a simulator stamps them: stale by the system's time, fresh by theirs."""
    driver = two_link.Driver(peer, "/joint_states", driving=False)
    clock = peer.node.create_publisher(Clock, "/clock", 10)
    start = peer.now()

    def play():
        now = Time(seconds=100) + (peer.now() - start)
        clock.publish(Clock(clock=now.to_msg()))
        driver.publish({"joint1": 0.0, "joint2": 0.0}, now)

    peer.node.create_timer(0.02, play)
    assert not wrong(doctor(domain_id, *SIMULATED, code=0))
    assert "joint_states" in wrong(doctor(domain_id, "--urdf", two_link.URDF, code=1))


@pytest.mark.parametrize(("seconds", "side"), [(-3.0, "past"), (100.0, "future")])
def test_stamps_of_another_clock_are_wrong(peer, domain_id, seconds, side):
    driver = two_link.Driver(peer, "/joint_states", driving=False)
    offset = Duration(seconds=seconds)
    peer.node.create_timer(0.02, lambda: driver.publish({"joint1": 0.0, "joint2": 0.0}, peer.now() + offset))
    text = wrong(doctor(domain_id, "--urdf", two_link.URDF, code=1))["joint_states"]
    assert f"s in the {side}" in text and "synchronise the clocks" in text and "use_sim_time" in text


def test_a_mesh_that_is_not_found_is_named(peer, domain_id, tmp_path):
    mesh = '<mesh filename="package://arm_description/tip.stl"/>'
    peer.latch(String(data=two_link.description().replace('<sphere radius="0.1"/>', mesh)), "/robot_description")
    fault = wrong(doctor(domain_id, code=1))["robot_description"]
    assert "arm_description/tip.stl" in fault and "--package-path" in fault


def test_meshes_that_are_no_plain_solids_are_listed(domain_id, tmp_path):
    (tmp_path / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    robot = tmp_path / "sheet.urdf"
    robot.write_text(
        '<robot name="sheet"><link name="a"><collision><geometry><mesh filename="sheet.obj"/></geometry></collision></link></robot>'
    )
    for given, count in ((), 0), (("--mesh", "solid"), 1):
        findings = doctor(domain_id, "--urdf", robot, *given, code=1, wait=0.5)
        texts = [text for verdict, about, text in findings if (verdict, about) == ("note", "solid meshes")]
        assert len(texts) == count
        assert all("mesh of link 'a'" in text and "not closed" in text for text in texts)


@pytest.mark.parametrize(
    ("variable", "value"),
    [("RMW_IMPLEMENTATION", "rmw_zenoh_cpp"), ("ROS_LOCALHOST_ONLY", "perhaps"), ("ROS_STATIC_PEERS", "10.0.0.1")],
)
def test_variables_that_part_it_from_others_are_named(domain_id, variable, value):
    findings = wrong(doctor(domain_id, code=1, wait=0.5, **{variable: value}))
    assert variable in findings["environment"]


def test_a_machine_without_multicast_is_reported(domain_id):
    command = [BINARY, "doctor", "--wait", "0.5", "--format", "json"]
    alone = ["unshare", "-rn", "bash", "-c", 'ip link set lo up; exec "$@"', "bash", *command]
    environment = environment_of_node(domain_id, {})
    done = subprocess.run(alone, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=100)
    assert done.returncode in (1, 3), done.stderr
    if done.returncode == 1:
        findings = [(f["verdict"], f["about"], f["text"]) for f in json.loads(done.stdout)]
        assert "multicast" in wrong(findings)
