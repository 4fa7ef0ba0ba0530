"""A simulated robot with a demonstration motion, monitored by the node `clearance`, to be shown in RViz.

    ros2 launch clearance demo.launch.py                                  demo arm
    ros2 launch clearance demo.launch.py rviz:=true                       with RViz, which shows the results
    ros2 launch clearance demo.launch.py urdf:=ur5e.urdf world:=cell.yaml another robot; each joint moves back and forth

Started without arguments, the program `clearance` shows the demo arm with a trajectory in a world with obstacles.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

# the folders config and urdf are next to this folder, in the repository and in an installed package
ROOT = Path(__file__).resolve().parents[1]
ONE_ROBOT = str(Path(__file__).with_name("clearance.launch.py"))

ARGUMENTS = {
    "urdf": (str(ROOT / "urdf/demo_arm/demo_arm.urdf"), "URDF file of the robot"),
    "srdf": ("", "SRDF file: link pairs that are not checked"),
    "package_path": ("", "folder for package://NAME/path, which is read from DIR/NAME/path"),
    "world": ("", "obstacles: the YAML of a moveit_msgs/PlanningScene, MoveIt's .scene text, an octree (.bt, .ot) or a cloud (.pcd, .ply)"),
    "executable": ("", "path of the program, if it is not the one of the installed package"),
    "view": ("", "true, or PORT or IP:PORT: a live view for web browsers"),
    "rviz": ("false", "whether RViz is started, with clearance.rviz"),
    "fixed_frame": ("", "fixed frame of RViz; if empty, the robot's root link"),
}


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    arguments = given | {"demo_motion": "true"}
    watch = IncludeLaunchDescription(PythonLaunchDescriptionSource(ONE_ROBOT), launch_arguments=arguments.items())
    # a string, which must not be parsed as YAML
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
