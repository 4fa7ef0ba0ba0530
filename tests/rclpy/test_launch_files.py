"""Tests of the launch files in launch_scripts: the nodes and arguments that they start; see launching.py."""

import shlex
import subprocess
from contextlib import contextmanager

import pytest
from clearance_msgs.msg import CollisionState
from geometry_msgs.msg import TransformStamped
from moveit_msgs.msg import CollisionObject, PlanningScene, PlanningSceneWorld
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

import scene as scenes
import two_link
from launching import FILES, LaunchFile
from move_group import MoveGroup
from node_process import BINARY, ROOT, environment_of_node
from peer import LATCHED


@contextmanager
def started(command, domain_id):
    process = subprocess.Popen(command, cwd=ROOT, env=environment_of_node(domain_id, {}))
    try:
        yield process
        assert process.poll() is None, f"{command} ended by itself"
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize("name", FILES)
def test_every_argument_is_described_and_without_any_the_installed_program_is_started(name):
    file = LaunchFile(name)
    assert all(argument.description for argument in file.arguments.values())
    ours = [node for node in file.nodes() if node.executable == "clearance"]
    assert ours and all(node.package == "clearance" and node.arguments[0] == "node" for node in ours)
    named = [node for node in file.nodes(executable="/opt/clearance") if node.executable == "/opt/clearance"]
    assert named and all(node.package is None for node in named)


def test_one_robot(peer, domain_id, tmp_path):
    command = LaunchFile("clearance.launch.py").command(
        tmp_path,
        urdf=two_link.URDF,
        namespace="left",
        joint_states="/driver/joint_states",
        params_file="config/clearance.yaml",
    )
    two_link.Driver(peer, "/driver/joint_states")
    states = peer.record(CollisionState, "/left/clearance/state")
    with started(command, domain_id):
        state = states.ever(lambda state: state.status == CollisionState.FREE, "FREE")
        assert state.nearest.distance == pytest.approx(0.7)


def test_what_is_given_reaches_the_node():
    given = {"urdf": "robot.urdf", "srdf": "robot.srdf", "package_path": "packages", "world": "cell.yaml", "record": "day.mcap"}
    file = LaunchFile("clearance.launch.py")
    options = [word for name, value in given.items() for word in (f"--{name.replace('_', '-')}", value)]
    for view, viewed in {"": [], "false": [], "true": ["--view"], "8080": ["--view", "8080"]}.items():
        (node,) = file.nodes(view=view, **given)
        assert node.arguments == ["node", *options, *viewed]
    (node,) = file.nodes(use_sim_time="true", params_file="config/clearance.yaml")
    assert node.arguments == ["node"]
    assert node.parameters == ["config/clearance.yaml", {"use_sim_time": True}]


def test_rviz_shows_what_the_node_of_a_namespace_says():
    ours, rviz = LaunchFile("clearance.launch.py").nodes(rviz="true", namespace="/left", urdf=two_link.URDF, use_sim_time="true")
    assert (ours.executable, rviz.executable) == ("clearance", "rviz2")
    assert rviz.arguments[-2:] == ["-f", "base"]
    assert ("/clearance/markers", "/left/clearance/markers") in rviz.remappings
    assert rviz.parameters == [{"use_sim_time": True}]
    (_, rviz) = LaunchFile("clearance.launch.py").nodes(rviz="true", fixed_frame="map")
    assert rviz.arguments[-2:] == ["-f", "map"]
    assert rviz.remappings == []
    (_, rviz) = LaunchFile("clearance.launch.py").nodes(rviz="true", namespace="left", tf="tf", tf_static="/cell/tf_static")
    assert {("/tf", "/left/tf"), ("/tf_static", "/cell/tf_static")} <= set(rviz.remappings)


def transform(child):
    """A frame where the ball of the tip is, with both joints at zero."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = "base"
    message.transform.translation.x = 2.0
    message.transform.rotation.w = 1.0
    return TFMessage(transforms=[message])


# Where the transforms of a namespace are, and how that is asked for.
TRANSFORMS = {"/": {}, "/left/": {"tf": "tf", "tf_static": "tf_static"}}


@pytest.mark.parametrize("where", TRANSFORMS)
@pytest.mark.parametrize("name", ["clearance.launch.py", "two_robots.launch.py"])
def test_in_a_namespace_transforms_are_received_where_they_are_published(peer, domain_id, tmp_path, name, where):
    robots = {"clearance.launch.py": {"urdf": two_link.URDF, "namespace": "left"}, "two_robots.launch.py": {"left_urdf": two_link.URDF}}
    command = LaunchFile(name).commands(tmp_path, **robots[name], **TRANSFORMS[where])[0]
    two_link.Driver(peer, "/left/joint_states")
    states = peer.record(CollisionState, "/left/clearance/state")
    objects = peer.node.create_publisher(CollisionObject, "/left/collision_object", 10)
    moving = peer.node.create_publisher(TFMessage, f"{where}tf", 10)
    fixed = peer.node.create_publisher(TFMessage, f"{where}tf_static", LATCHED)
    fixed.publish(transform("table"))

    def touching():
        moving.publish(transform("cart"))
        for frame in ("table", "cart"):
            objects.publish(scenes.ball(f"on_{frame}", 0, frame=frame))
        touched = ({body for pair in state.colliding_pairs for body in (pair.body_a, pair.body_b)} for state in states.all())
        return any({"on_table", "on_cart"} <= bodies for bodies in touched)

    with started(command, domain_id):
        peer.wait_for(touching, "both balls at the tip")


@pytest.mark.parametrize("name", [name for name in FILES if name != "demo.launch.py"])
def test_a_node_that_ends_is_started_again_on_request(name):
    file = LaunchFile(name)
    assert not any(node.respawn for node in file.nodes())
    assert all(node.respawn and node.respawn_delay > 0 for node in file.nodes(respawn="true"))


def test_two_robots(peer, domain_id, tmp_path):
    world = tmp_path / "right.yaml"
    world.write_text("collision_objects: [{id: ball, pose: {position: [2, 0, 0]}, primitives: [{type: sphere, dimensions: [0.1]}]}]")
    of_both = {"params_file": "config/clearance.yaml", "left_urdf": two_link.URDF, "right_urdf": two_link.URDF}
    left, right = LaunchFile("two_robots.launch.py").commands(tmp_path, right_world=world, **of_both)
    for side in ("left", "right"):
        two_link.Driver(peer, f"/{side}/joint_states")
    states = {side: peer.record(CollisionState, f"/{side}/clearance/state") for side in ("left", "right")}
    with started(left, domain_id), started(right, domain_id):
        states["left"].ever(lambda state: state.status == CollisionState.FREE, "FREE on the left")
        state = states["right"].ever(lambda state: state.status == CollisionState.COLLIDING, "the ball on the right")
        assert "ball" in (state.colliding_pairs[0].body_a, state.colliding_pairs[0].body_b)


def test_the_demo(peer, domain_id, tmp_path):
    command = LaunchFile("demo.launch.py").command(tmp_path, urdf=two_link.URDF)
    states = peer.record(CollisionState, "/clearance/state")
    with started(command, domain_id):
        states.ever(lambda state: state.status != CollisionState.UNKNOWN, "a judgement")


def test_the_demo_of_any_robot():
    given = {"urdf": "tests/rclpy/rover.urdf", "srdf": "rover.srdf", "package_path": "packages", "world": "hall.yaml"}
    ours, rviz, show = LaunchFile("demo.launch.py").nodes(rviz="true", **given)
    options = [word for name, value in given.items() for word in (f"--{name.replace('_', '-')}", value)]
    assert ours.arguments == ["node", *options, "--demo-motion"]
    assert rviz.arguments[-2:] == ["-f", "odom"]
    assert show.executable == "robot_state_publisher"


def test_beside_moveit(peer, domain_id, tmp_path):
    command = LaunchFile("moveit.launch.py").command(tmp_path)
    two_link.Driver(peer, "/joint_states")
    peer.latch(String(data=two_link.description()), "/robot_description")
    states = peer.record(CollisionState, "/clearance/state")
    scene = PlanningScene(is_diff=False, world=PlanningSceneWorld(collision_objects=[scenes.ball("ball", x=2.0)]))
    assert scene.world.collision_objects[0].operation == CollisionObject.ADD
    with started(command, domain_id), MoveGroup(domain_id, "/get_planning_scene", scenes.full()) as asked:
        states.ever(lambda state: state.status == CollisionState.FREE, "FREE")
        peer.wait_for(asked.changes.get_subscription_count, "a subscription of MoveIt's scene")
        asked.changes.publish(scene)
        state = states.ever(lambda state: state.status == CollisionState.COLLIDING, "the ball of MoveIt's scene")
        assert "ball" in (state.colliding_pairs[0].body_a, state.colliding_pairs[0].body_b)
        names = dict(peer.node.get_service_names_and_types_by_node("clearance", "/"))
        assert "/clearance/get_planning_scene" in names and "/get_planning_scene" not in names
        # what is said to MoveIt comes by its scene alone
        for name in ("collision_object", "attached_collision_object", "planning_scene_world", "octomap_binary", "octomap_full"):
            peer.wait_for(lambda name=name: peer.node.count_subscribers(f"/clearance/{name}"), f"/clearance/{name}")
            assert peer.node.count_subscribers(f"/{name}") == 0


def test_beside_moveit_by_hand(peer, domain_id):
    """As the manual says it."""
    manual = (ROOT / "docs/operate/moveit.md").read_text()
    words = shlex.split(manual.split("```sh\n")[1].split("```")[0].replace("\\\n", " "))
    assert words[:2] == ["clearance", "node"]
    two_link.Driver(peer, "/joint_states")
    states = peer.record(CollisionState, "/clearance/state")
    command = [BINARY, "node", "--urdf", two_link.URDF, *words[2:]]
    with started(command, domain_id), MoveGroup(domain_id, "/get_planning_scene", scenes.full(scenes.ball("a", x=9.0))) as asked:
        states.ever(lambda state: state.status == CollisionState.FREE, "FREE")
        peer.wait_for(asked.changes.get_subscription_count, "a subscription of MoveIt's scene")
        asked.changes.publish(scenes.diff(scenes.ball("ball", x=2.0)))
        states.ever(lambda state: state.status == CollisionState.COLLIDING, "what has changed in MoveIt's scene")
        own = dict(peer.node.get_service_names_and_types_by_node("clearance", "/"))
        assert not {name for name in own if name.count("/") == 1}, "all services are in its own namespace"


@pytest.mark.parametrize(
    ("given", "asked"),
    [
        ({}, ["/get_planning_scene"]),
        ({"scene": "/arm/monitored_planning_scene"}, ["/arm/get_planning_scene"]),
        ({"scene_service": "/cell/get_planning_scene"}, ["/cell/get_planning_scene"]),
        ({"scene_service": "none"}, []),
    ],
)
def test_move_group_is_asked_by_the_service_beside_its_topic(given, asked):
    (node,) = LaunchFile("moveit.launch.py").nodes(**given)
    parameters = [group for group in node.parameters if isinstance(group, dict)]
    assert [group["planning_scene_service"] for group in parameters if "planning_scene_service" in group] == asked


def test_the_service_of_systemd_is_one(tmp_path):
    """Where systemd is there to ask."""
    unit = (ROOT / "launch_scripts/clearance.service").read_text()
    file = tmp_path / "clearance.service"
    file.write_text(unit.replace("/usr/local/bin/clearance", "/bin/true"))
    try:
        verified = subprocess.run(["systemd-analyze", "verify", "--man=no", file], capture_output=True, text=True)
    except FileNotFoundError:
        pytest.skip("there is no systemd-analyze")
    assert (verified.returncode, verified.stderr) == (0, "")
