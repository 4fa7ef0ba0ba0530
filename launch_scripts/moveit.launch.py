"""The node `clearance` next to a running MoveIt: it monitors the same robot in the same scene.

    ros2 launch clearance moveit.launch.py
    ros2 launch clearance moveit.launch.py scene:=/arm/monitored_planning_scene params_file:=cell.yaml

The node receives URDF and SRDF from robot_description and robot_description_semantic: start move_group with
publish_robot_description and publish_robot_description_semantic. It receives changes of the scene from monitored_planning_scene, which
is remapped to planning_scene. move_group publishes the whole scene there only once, when it starts. Therefore the node requests the
whole scene from the service get_planning_scene, whichever of the two starts later. Until the response arrives, the status is UNKNOWN.

The node receives no other messages about the scene. Applications send collision_object, attached_collision_object and
planning_scene_world to MoveIt. If the node received them as well, each change would arrive twice, in an undefined order, and the node
would apply changes that move_group rejects. octomap_binary would replace the octomap of the scene. Therefore these topics and the scene
services of the node are remapped into its own namespace. MoveIt's names are unchanged. To send an object to the node only, publish it on
/clearance/collision_object.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "scene": ("/monitored_planning_scene", "topic on which move_group publishes its scene"),
    "scene_service": (
        "",
        "service of move_group for its whole scene; if empty, get_planning_scene in the namespace of the topic 'scene'; none: the scene is not requested. It has priority over params_file",
    ),
    "description": ("/robot_description", "topic of the URDF"),
    "semantic": ("/robot_description_semantic", "topic of the SRDF"),
    "joint_states": ("/joint_states", "topic of the joint states"),
    "package_path": ("", "folder for package://NAME/path, in addition to the sourced workspaces"),
    "params_file": ("", "parameter file, such as config/clearance.yaml"),
    "use_sim_time": ("", "true or false: whether time is read from /clock; if empty, params_file decides"),
    "respawn": ("false", "whether the node is restarted when it ends"),
    "executable": ("", "path of the program, if it is not the one of the installed package"),
}

# Names that MoveIt uses as well: those of this node are remapped into its own namespace.
SERVICES = ["get_planning_scene", "apply_planning_scene", "clear_octomap", "check_state_validity"]
SUBSCRIPTIONS = ["planning_scene_world", "collision_object", "attached_collision_object", "octomap_binary", "octomap_full"]
PUBLISHERS = ["monitored_planning_scene"]


def start(context):
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    path = ["--package-path", given["package_path"]] if given["package_path"] else []
    files = [given["params_file"]] if given["params_file"] else []
    default_service = f"{given['scene'].rpartition('/')[0]}/get_planning_scene"
    service = given["scene_service"] or default_service
    scene_service = [] if service == "none" else [{"planning_scene_service": service}]
    simulated = [{"use_sim_time": given["use_sim_time"].lower() == "true"}] if given["use_sim_time"] else []
    own = [(name, f"/clearance/{name}") for name in SERVICES + SUBSCRIPTIONS + PUBLISHERS]
    return [
        Node(
            package=None if given["executable"] else "clearance",
            executable=given["executable"] or "clearance",
            name="clearance",
            arguments=["node", *path],
            parameters=files + scene_service + simulated,
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
