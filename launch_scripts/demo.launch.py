"""A robot that moves by itself, watched by the node `clearance`: something to look at in RViz.

    ros2 launch clearance demo.launch.py                                  the demo arm
    ros2 launch clearance demo.launch.py rviz:=true                       and RViz, which shows what the node finds
    ros2 launch clearance demo.launch.py urdf:=ur5e.urdf world:=cell.yaml any other robot, each joint to and fro

The demo arm in its own world plays a motion of its own when the program is started without arguments: `clearance`.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

# beside this folder stand config and urdf, in the repository as in an installed package
ROOT = Path(__file__).resolve().parents[1]
RVIZ_CONFIG = Path(__file__).resolve().with_name("clearance.rviz")

ARGUMENTS = {
    "urdf": (str(ROOT / "urdf/demo_arm/demo_arm.urdf"), "the robot"),
    "world": ("", "obstacles: the YAML of a moveit_msgs/PlanningScene, MoveIt's .scene text, an octree (.bt, .ot) or a cloud (.pcd, .ply)"),
    "executable": ("", "the program, if it is not that of the installed package"),
    "rviz": ("false", "whether RViz is started, with clearance.rviz"),
    "fixed_frame": ("base", "the fixed frame of RViz: the robot's root link"),
}


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    world = ["--world", given["world"]] if given["world"] else []
    watch = Node(
        package=None if given["executable"] else "clearance",
        executable=given["executable"] or "clearance",
        name="clearance",
        arguments=["node", "--urdf", given["urdf"], *world, "--demo-motion"],
        output="screen",
    )
    show = Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        parameters=[{"robot_description": Path(given["urdf"]).read_text()}],
    )
    if given["rviz"].lower() != "true":
        return [watch, show]
    rviz = Node(package="rviz2", executable="rviz2", arguments=["-d", str(RVIZ_CONFIG), "-f", given["fixed_frame"]])
    return [watch, show, rviz]


def generate_launch_description():
    declarations = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declarations, OpaqueFunction(function=start)])
