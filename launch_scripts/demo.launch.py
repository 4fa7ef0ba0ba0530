"""A robot that moves by itself, watched by the node `clearance`: something to look at in RViz.

    ros2 launch clearance demo.launch.py                                  the demo arm
    ros2 launch clearance demo.launch.py rviz:=true                       and RViz, which shows what the node finds
    ros2 launch clearance demo.launch.py urdf:=ur5e.urdf world:=cell.yaml any other robot, each joint to and fro

The demo arm in its own world plays a motion of its own when the program is started without arguments: `clearance`.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# beside this folder stand config and urdf, in the repository as in an installed package
ROOT = Path(__file__).resolve().parents[1]
ONE_ROBOT = str(Path(__file__).with_name("clearance.launch.py"))

ARGUMENTS = {
    "urdf": (str(ROOT / "urdf/demo_arm/demo_arm.urdf"), "the robot"),
    "srdf": ("", "its SRDF: the pairs of links that need no check"),
    "package_path": ("", "where package://NAME/path is looked up, as DIR/NAME/path"),
    "world": ("", "obstacles: the YAML of a moveit_msgs/PlanningScene, MoveIt's .scene text, an octree (.bt, .ot) or a cloud (.pcd, .ply)"),
    "executable": ("", "the program, if it is not that of the installed package"),
    "view": ("", "true, or PORT or IP:PORT: a live view for web browsers"),
    "rviz": ("false", "whether RViz is started, with clearance.rviz"),
    "fixed_frame": ("", "the fixed frame of RViz; without it the robot's root link"),
}


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    arguments = given | {"demo_motion": "true"}
    watch = IncludeLaunchDescription(PythonLaunchDescriptionSource(ONE_ROBOT), launch_arguments=arguments.items())
    # a text that is not to be read as YAML
    description = ParameterValue(Path(given["urdf"]).read_text(), value_type=str)
    show = Node(
        package="robot_state_publisher",
        executable="robot_state_publisher",
        parameters=[{"robot_description": description}],
    )
    return [watch, show]


def generate_launch_description():
    declarations = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declarations, OpaqueFunction(function=start)])
