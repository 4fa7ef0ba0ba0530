"""What the files of launch_scripts start, works; by stand-ins for `launch`: see launching.py."""

import subprocess
from contextlib import contextmanager

import pytest
from clearance_msgs.msg import CollisionState
from moveit_msgs.msg import CollisionObject, PlanningScene, PlanningSceneWorld
from std_msgs.msg import String

import scene as scenes
import two_link
from launching import FILES, LaunchFile
from node_process import ROOT, environment_of_node


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
        state = states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE")
        assert state.nearest.distance == pytest.approx(0.7)


def test_the_demo(peer, domain_id, tmp_path):
    command = LaunchFile("demo.launch.py").command(tmp_path, urdf=two_link.URDF)
    states = peer.record(CollisionState, "/clearance/state")
    with started(command, domain_id):
        states.wait_for(lambda state: state.status != CollisionState.UNKNOWN, "a judgement")


def test_beside_moveit(peer, domain_id, tmp_path):
    command = LaunchFile("moveit.launch.py").command(tmp_path)
    two_link.Driver(peer, "/joint_states")
    peer.latch(String(data=two_link.description()), "/robot_description")
    states = peer.record(CollisionState, "/clearance/state")
    scene = PlanningScene(is_diff=False, world=PlanningSceneWorld(collision_objects=[scenes.ball("ball", x=2.0)]))
    assert scene.world.collision_objects[0].operation == CollisionObject.ADD
    with started(command, domain_id):
        states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE")
        # in the role of move_group
        move_group = peer.node.create_publisher(PlanningScene, "/monitored_planning_scene", 10)
        peer.wait_for(move_group.get_subscription_count, "a subscription of MoveIt's scene")
        move_group.publish(scene)
        state = states.wait_for(lambda state: state.status == CollisionState.COLLIDING, "the ball of MoveIt's scene")
        assert "ball" in (state.colliding_pairs[0].body_a, state.colliding_pairs[0].body_b)
        names = dict(peer.node.get_service_names_and_types())
        assert "/clearance/get_planning_scene" in names and "/get_planning_scene" not in names


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
