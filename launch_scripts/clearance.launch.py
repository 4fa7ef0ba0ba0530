"""The node `clearance` for one robot.

    ros2 launch clearance clearance.launch.py                              robot from the topic robot_description
    ros2 launch clearance clearance.launch.py urdf:=ur5e.urdf srdf:=ur5e.srdf world:=cell.yaml
    ros2 launch clearance clearance.launch.py namespace:=left joint_states:=/left/joint_states
    ros2 launch clearance clearance.launch.py urdf:=ur5e.urdf rviz:=true view:=true   with RViz and a live view for web browsers

Also in a namespace, transforms are received from /tf and /tf_static, where robot_state_publisher and tf2 publish them. If the
namespace has its own transforms, as with Nav2: tf:=tf tf_static:=tf_static.

Without an installed package: ros2 launch launch_scripts/clearance.launch.py executable:=target/release/clearance
"""

from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

RVIZ_CONFIG = Path(__file__).resolve().with_name("clearance.rviz")

TRANSFORMS = ("tf", "tf_static")

# Topics of the RViz configuration, by their names without a namespace.
RVIZ_TOPICS = ("clearance/markers", "clearance/link_volumes", "clearance/swept_volume", "monitored_planning_scene", "robot_description")

ARGUMENTS = {
    "namespace": ("", "namespace of the node and of the relative topics"),
    "urdf": ("", "URDF file of the robot; if empty, the URDF is received from the topic robot_description"),
    "srdf": ("", "SRDF file: link pairs that are not checked"),
    "package_path": ("", "folder for package://NAME/path, which is read from DIR/NAME/path"),
    "world": ("", "obstacles: the YAML of a moveit_msgs/PlanningScene, MoveIt's .scene text, an octree (.bt, .ot) or a cloud (.pcd, .ply)"),
    "params_file": ("", "parameter file, such as config/clearance.yaml"),
    "record": ("", "MCAP file for a recording of inputs and results"),
    "joint_states": ("joint_states", "topic of the joint states"),
    "tf": ("/tf", "topic of the transforms"),
    "tf_static": ("/tf_static", "topic of the static transforms"),
    "use_sim_time": ("", "true or false: whether time is read from /clock; if empty, params_file decides"),
    "executable": ("", "path of the program, if it is not the one of the installed package"),
    "demo_motion": ("false", "whether the node publishes a slow motion of every joint; never together with a real driver"),
    "respawn": ("false", "whether the node is restarted when it ends; it then has only the obstacles of its files"),
    "view": ("", "true, or PORT or IP:PORT: a live view for web browsers"),
    "rviz": ("false", "whether RViz is started, with clearance.rviz; it shows the robot if a robot_state_publisher runs"),
    "fixed_frame": ("", "fixed frame of RViz; if empty, the root link of the URDF, or base_link"),
}


def is_true(text):
    return text.lower() == "true"


def root_link(urdf):
    """Name of the link that is not the child of any joint."""
    robot = ElementTree.parse(urdf).getroot()
    children = {child.get("link") for child in robot.iterfind("joint/child")}
    return next(link.get("name") for link in robot.iterfind("link") if link.get("name") not in children)


def rviz(given):
    namespace = given["namespace"].strip("/")
    topics = {name: name for name in RVIZ_TOPICS} | {name: given[name] for name in TRANSFORMS}
    absolute = {f"/{name}": str(PurePosixPath("/", namespace, topic)) for name, topic in topics.items()}
    frame = given["fixed_frame"] or (root_link(given["urdf"]) if given["urdf"] else "base_link")
    return Node(
        package="rviz2",
        executable="rviz2",
        arguments=["-d", str(RVIZ_CONFIG), "-f", frame],
        parameters=[{"use_sim_time": is_true(given["use_sim_time"])}],
        remappings=[(name, topic) for name, topic in absolute.items() if topic != name],
    )


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    options = {
        "--urdf": "urdf",
        "--srdf": "srdf",
        "--package-path": "package_path",
        "--world": "world",
        "--record": "record",
    }
    arguments = [word for flag, name in options.items() if given[name] for word in (flag, given[name])]
    if is_true(given["demo_motion"]):
        arguments.append("--demo-motion")
    view = given["view"]
    if view and view.lower() != "false":
        arguments += ["--view"] if is_true(view) else ["--view", view]
    files = [given["params_file"]] if given["params_file"] else []
    node = Node(
        package=None if given["executable"] else "clearance",
        executable=given["executable"] or "clearance",
        name="clearance",
        namespace=given["namespace"],
        arguments=["node", *arguments],
        parameters=files + ([{"use_sim_time": is_true(given["use_sim_time"])}] if given["use_sim_time"] else []),
        remappings=[(name, given[name]) for name in ("joint_states", *TRANSFORMS)],
        output="screen",
        respawn=is_true(given["respawn"]),
        respawn_delay=2.0,
    )
    return [node, rviz(given)] if is_true(given["rviz"]) else [node]


def generate_launch_description():
    declarations = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declarations, OpaqueFunction(function=start)])
