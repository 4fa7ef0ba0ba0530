"""The node `clearance` beside a running MoveIt: it watches the same robot in the same scene.

    ros2 launch clearance moveit.launch.py
    ros2 launch clearance moveit.launch.py scene:=/arm/monitored_planning_scene params_file:=cell.yaml

Robot and SRDF come on robot_description and robot_description_semantic: start move_group with
publish_robot_description and publish_robot_description_semantic. What changes in its scene comes on monitored_planning_scene, which
the node hears as planning_scene. move_group tells the whole scene there only once, when it starts: so the node asks its service
get_planning_scene for it, whichever of the two starts later. Until the answer has come, the status is UNKNOWN.

That is all that the node hears of the scene. What applications send to MoveIt (collision_object, attached_collision_object, planning_scene_world) it
would hear twice otherwise, in an order that nobody knows, and also what move_group refuses: an object could stay that MoveIt has removed. The
scene's octomap would be replaced by that of octomap_binary. So these topics, and the node's own scene services, stand in its own namespace: MoveIt's keep
their names, and whoever wants to tell the node alone says /clearance/collision_object.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "scene": ("/monitored_planning_scene", "the topic on which move_group tells its scene"),
    "scene_service": (
        "",
        "the service by which move_group tells its whole scene, if it is not get_planning_scene beside the topic 'scene'; none: it is not asked. It wins over params_file",
    ),
    "description": ("/robot_description", "the topic with the URDF"),
    "semantic": ("/robot_description_semantic", "the topic with the SRDF"),
    "joint_states": ("/joint_states", "the topic with the joint states"),
    "package_path": ("", "where package://NAME/path is looked up, if not in the sourced workspaces"),
    "params_file": ("", "a parameter file, such as config/clearance.yaml"),
    "use_sim_time": ("", "true or false: whether time is read from /clock; without it params_file says so"),
    "respawn": ("false", "whether the node is started again when it ends"),
    "executable": ("", "the program, if it is not that of the installed package"),
}

# Where MoveIt has names of its own, those of this node are moved into its own namespace.
SERVICES = ["get_planning_scene", "apply_planning_scene", "clear_octomap", "check_state_validity"]
HEARD = ["planning_scene_world", "collision_object", "attached_collision_object", "octomap_binary", "octomap_full"]
SAID = ["monitored_planning_scene"]


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    path = ["--package-path", given["package_path"]] if given["package_path"] else []
    files = [given["params_file"]] if given["params_file"] else []
    beside = f"{given['scene'].rpartition('/')[0]}/get_planning_scene"
    service = given["scene_service"] or beside
    asked = [] if service == "none" else [{"planning_scene_service": service}]
    simulated = [{"use_sim_time": given["use_sim_time"].lower() == "true"}] if given["use_sim_time"] else []
    own = [(name, f"/clearance/{name}") for name in SERVICES + HEARD + SAID]
    return [
        Node(
            package=None if given["executable"] else "clearance",
            executable=given["executable"] or "clearance",
            name="clearance",
            arguments=["node", *path],
            parameters=files + asked + simulated,
            remappings=[
                ("planning_scene", given["scene"]),
                ("robot_description", given["description"]),
                ("robot_description_semantic", given["semantic"]),
                ("joint_states", given["joint_states"]),
                *own,
            ],
            output="screen",
            respawn=given["respawn"].lower() == "true",
            respawn_delay=2.0,
        )
    ]


def generate_launch_description():
    declarations = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declarations, OpaqueFunction(function=start)])
