"""Tests of `memory_limit`: a node that takes more memory reports it and ends."""

from clearance_msgs.msg import CollisionState

from fail_safe import OUT_OF_MEMORY
from scene import fine_mesh, obstacle, pose
from scene_client import SceneClient
from node_process import NodeProcess
from test_termination import MEBIBYTE, chain, resident_memory

PATIENCE = 60.0  # [s]


def test_a_world_that_grows_too_large_ends_the_node_and_is_named(cell):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    scene = SceneClient(cell)
    scene.topic(type(obstacle("first")), "collision_object")
    limit = resident_memory(cell.node) // MEBIBYTE + 40
    cell.parameters.succeed(memory_limit=float(limit))
    number = 0

    def grows():
        nonlocal number
        number += 1
        scene.publish(obstacle(f"mesh_{number}", fine_mesh(20_000), at=pose(9.0 + number)))
        return cell.node.exit_code is not None

    cell.peer.wait_for(grows, "the end of the node", PATIENCE)
    assert cell.node.ended() == OUT_OF_MEMORY
    state = cell.states.ever(lambda state: state.reason_code == "memory", "UNKNOWN for lack of memory")
    assert state.status == CollisionState.UNKNOWN
    assert f"memory_limit is {limit} MiB" in state.reason
    (line,) = [line for line in cell.node.output().splitlines() if "grown since the robot was loaded" in line]
    assert f"memory_limit is {limit} MiB" in line
    for component in ("bounding volumes of robot and world by", "other data of the world) by", "recording queue by 0 MiB"):
        assert component in line


def test_a_robot_of_the_command_line_that_takes_too_much_ends_the_node(peer, tmp_path):
    (tmp_path / "chain.urdf").write_text(chain(2500))
    limit = {"memory_limit": 40.0}
    with NodeProcess("--urdf", tmp_path / "chain.urdf", domain_id=peer.domain_id, parameters=limit) as node:
        assert node.ended() == OUT_OF_MEMORY
        output = node.output()
    assert "memory_limit is 40 MiB" in output and "while it starts" in output
    assert "listens to" not in output


def test_the_default_leaves_a_node_alone(cell):
    assert cell.parameters.get("memory_limit") == [0.0]
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.states.more(20, cell.state_now())
    assert cell.node.exit_code is None
