"""The node `clearance` for one robot.

    ros2 launch clearance clearance.launch.py                              the robot of the topic robot_description
    ros2 launch clearance clearance.launch.py urdf:=ur5e.urdf srdf:=ur5e.srdf world:=cell.yaml
    ros2 launch clearance clearance.launch.py namespace:=left joint_states:=/left/joint_states

Without an installed package, by path: ros2 launch launch_scripts/clearance.launch.py executable:=target/release/clearance
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "namespace": ("", "namespace of the node and of the relative topics"),
    "urdf": ("", "the robot; without it the topic robot_description is awaited"),
    "srdf": ("", "its SRDF: the pairs of links that need no check"),
    "package_path": ("", "where package://NAME/path is looked up, as DIR/NAME/path"),
    "world": ("", "obstacles: the YAML of a moveit_msgs/PlanningScene"),
    "params_file": ("", "a parameter file, such as config/clearance.yaml"),
    "record": ("", "an MCAP file to record inputs and answers to"),
    "joint_states": ("joint_states", "the topic with the joint states"),
    "use_sim_time": ("false", "whether time is read from /clock"),
    "executable": ("", "the program, if it is not that of the installed package"),
}


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
    files = [given["params_file"]] if given["params_file"] else []
    return [
        Node(
            package=None if given["executable"] else "clearance",
            executable=given["executable"] or "clearance",
            name="clearance",
            namespace=given["namespace"],
            arguments=["node", *arguments],
            parameters=[*files, {"use_sim_time": given["use_sim_time"].lower() == "true"}],
            remappings=[("joint_states", given["joint_states"])],
            output="screen",
        )
    ]


def generate_launch_description():
    declarations = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declarations, OpaqueFunction(function=start)])
