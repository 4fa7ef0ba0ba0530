"""Tests of the node's process: exit codes on signals, restarts, duplicate names, bad command lines."""

import os
import signal
import subprocess

import pytest
from clearance_msgs.msg import CollisionState

import two_link
from cell import Cell
from node_process import BINARY, EXIT_DEADLINE


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_the_node_ends_cleanly_when_asked(cell, by):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    assert cell.node.stop(by) == 0
    names = cell.peer.node.get_node_names_and_namespaces
    cell.peer.wait_for(lambda: (cell.node.name, cell.node.namespace) not in names(), "the node to leave the graph")


@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_a_node_without_a_model_ends_cleanly_too(start, by):
    cell = start(urdf=None)
    cell.unknown("no_model")
    assert cell.node.stop(by) == 0


@pytest.mark.parametrize("end", ["asked", "crashed"])
def test_a_subscriber_receives_messages_again_after_a_restart(cell, end):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.node.stop() if end == "asked" else cell.node.kill()

    cell.restart_node()
    state = cell.evaluate(joint1=0, joint2=0)
    assert state.model_revision == 1


def test_the_node_receives_from_a_driver_again_after_its_restart(cell):
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
    cell.grows_old()
    cell.driver.disconnect()
    cell.unknown("stale")

    cell.driver = two_link.Driver(cell.peer, cell.node.relative("joint_states"))
    assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE


def test_two_nodes_of_one_name_say_so(start):
    first = start(name="twin", namespace="/twins")
    second = start(name="twin", namespace="/twins")
    for cell in first, second:
        cell.peer.wait_for(lambda cell=cell: "another node is named /twins/twin" in cell.node.output(), "a word of the other")


def test_a_change_of_status_is_logged_with_the_pair(cell):
    cell.evaluate(joint1=0, joint2=0)
    cell.evaluate(joint1=0, joint2=3.14)
    said = cell.node.output
    cell.peer.wait_for(lambda: "COLLIDING: base and tip touch" in said(), "the line about the collision")
    assert "FREE: nearest: base and tip, " in said()


def test_a_node_that_was_suspended_ends_and_says_why(peer):
    """As by Ctrl-Z and `fg`, or a debugger: RustDDS hears no more then, and a node that looks alive would mislead."""
    with Cell(peer) as cell:
        assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE

        def ended():
            if cell.node.exit_code is None:
                os.kill(cell.node.process_id, signal.SIGSTOP)
                os.kill(cell.node.process_id, signal.SIGCONT)
            return cell.node.exit_code is not None

        peer.wait_for(ended, "the end of a node that was suspended")
        assert cell.node.ended() == 3
        assert "suspended" in cell.node.output()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--urdf", "nowhere.urdf"], "nowhere.urdf"),
        (["--ros-args", "-p", "heartbeat_rate:=-1.0"], "heartbeat_rate"),
        (["--ros-args", "-p", "hartbeat_rate:=10.0"], "hartbeat_rate"),
        (["--ros-args", "--params-file", "nowhere.yaml"], "nowhere.yaml"),
        (["--ros-args", "-r", "__node:=not a name"], "not a name"),
    ],
)
def test_bad_input_on_the_command_line_ends_with_2_and_is_named(arguments, named):
    result = subprocess.run([BINARY, "node", *arguments], capture_output=True, text=True, timeout=EXIT_DEADLINE)
    assert result.returncode == 2
    assert named in result.stderr
    assert result.stdout == ""
