"""Two robots, each in a namespace of its own with a node `clearance` beside it.

    ros2 launch clearance two_robots.launch.py                            the robots of /left/robot_description and /right/robot_description
    ros2 launch clearance two_robots.launch.py left_urdf:=ur5e.urdf right_urdf:=ur10e.urdf left_world:=cell.yaml
    ros2 launch clearance two_robots.launch.py left:=picker right:=packer other namespaces

Each node listens to joint_states, robot_description and the topics about the world in its own namespace, and to all transforms on /tf
and /tf_static, where links of the same name have to be told apart (frame_prefix of robot_state_publisher, link_prefix of the node). They say
/left/clearance/state and /right/clearance/state. The robots do not see each other: where their spaces overlap, describe both in one URDF, with
prefixed names, and start one node (clearance.launch.py) for both; their drivers may share the topic joint_states.
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
    "_urdf": ("", "the {side} robot; without it the topic robot_description of its namespace is awaited"),
    "_srdf": ("", "its SRDF: the pairs of links that need no check"),
    "_world": ("", "obstacles in the {side} robot's root frame, as for clearance.launch.py"),
}
OF_BOTH = {
    "tf": ("/tf", "the topic with the transforms; tf: one in each namespace"),
    "tf_static": ("/tf_static", "the topic with the transforms that never change; tf_static: one in each namespace"),
    "package_path": ("", "where package://NAME/path is looked up, as DIR/NAME/path"),
    "params_file": ("", "a parameter file, such as config/clearance.yaml; /left/clearance and /right/clearance may have sections of their own"),
    "use_sim_time": ("", "true or false: whether time is read from /clock; without it params_file says so"),
    "respawn": ("false", "whether a node is started again when it ends; it has only the obstacles of its files then"),
    "executable": ("", "the program, if it is not that of the installed package"),
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
