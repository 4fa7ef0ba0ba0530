"""Two robots, each with a node `clearance` in its own namespace.

    ros2 launch clearance two_robots.launch.py                            robots from /left/robot_description and /right/robot_description
    ros2 launch clearance two_robots.launch.py left_urdf:=ur5e.urdf right_urdf:=ur10e.urdf left_world:=cell.yaml
    ros2 launch clearance two_robots.launch.py left:=picker right:=packer  other namespaces

Each node subscribes to joint_states, robot_description and the scene topics in its own namespace, and to /tf and /tf_static. Links of
both robots need different names on tf (frame_prefix of robot_state_publisher, link_prefix of the node). The nodes publish
/left/clearance/state and /right/clearance/state. They do not check the robots against each other. If the workspaces overlap, describe
both robots in one URDF with prefixed names, and start one node (clearance.launch.py); the drivers may share the topic joint_states.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, OpaqueFunction
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

ONE_ROBOT = str(Path(__file__).with_name("clearance.launch.py"))

SIDES = ("left", "right")
OF_EACH = {
    "": ("{side}", "namespace of the {side} robot"),
    "_urdf": ("", "URDF file of the {side} robot; if empty, the URDF is received from robot_description in its namespace"),
    "_srdf": ("", "SRDF file: link pairs that are not checked"),
    "_world": ("", "obstacles in the {side} robot's root frame, as for clearance.launch.py"),
}
OF_BOTH = {
    "tf": ("/tf", "topic of the transforms; tf: one in each namespace"),
    "tf_static": ("/tf_static", "topic of the static transforms; tf_static: one in each namespace"),
    "package_path": ("", "folder for package://NAME/path, which is read from DIR/NAME/path"),
    "params_file": ("", "parameter file, such as config/clearance.yaml; /left/clearance and /right/clearance may have their own sections"),
    "use_sim_time": ("", "true or false: whether time is read from /clock; if empty, params_file decides"),
    "respawn": ("false", "whether a node is restarted when it ends; it then has only the obstacles of its files"),
    "executable": ("", "path of the program, if it is not the one of the installed package"),
}


def start(context):
    def value(name):
        return LaunchConfiguration(name).perform(context)

    def one(side):
        of_side = {name: value(f"{side}_{name}") for name in ("urdf", "srdf", "world")}
        of_both = {name: value(name) for name in OF_BOTH}
        arguments = of_side | of_both | {"namespace": value(side), "joint_states": "joint_states"}
        return IncludeLaunchDescription(PythonLaunchDescriptionSource(ONE_ROBOT), launch_arguments=arguments.items())

    return [one(side) for side in SIDES]


def generate_launch_description():
    of_each = {
        side + suffix: (default.format(side=side), description.format(side=side))
        for side in SIDES
        for suffix, (default, description) in OF_EACH.items()
    }
    declarations = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in (of_each | OF_BOTH).items()
    ]
    return LaunchDescription([*declarations, OpaqueFunction(function=start)])
