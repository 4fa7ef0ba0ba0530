"""Tests of a node restricted to localhost: local peers discover it, and no packet leaves on another interface."""

import subprocess
import sys
from pathlib import Path

import pytest
from clearance_msgs.msg import CollisionState

from cell import Cell
from peer import Peer

LOCALHOST_ONLY = {"ROS_LOCALHOST_ONLY": "1"}
DISCOVERY_RANGE = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


def name(environment):
    return next(iter(environment), "anywhere")


@pytest.mark.parametrize("of_node", [LOCALHOST_ONLY, DISCOVERY_RANGE], ids=name)
@pytest.mark.parametrize("of_peer", [{}, DISCOVERY_RANGE], ids=name)
def test_node_and_peer_meet_on_localhost(monkeypatch, domain_id, of_node, of_peer):
    for variable, value in of_peer.items():
        monkeypatch.setenv(variable, value)
    not_of_node = dict.fromkeys(of_peer)

    with Peer(domain_id) as peer, Cell(peer, environment=not_of_node | of_node) as cell:
        assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE


def packets_beyond_localhost(domain_id, of_node):
    probe = Path(__file__).with_name("localhost_probe.py")
    assignments = [f"{variable}={value}" for variable, value in of_node.items()]
    result = subprocess.run(
        ["unshare", "--net", sys.executable, "-B", probe, str(domain_id), *assignments], capture_output=True, text=True
    )
    assert result.returncode == 0, result.stdout + result.stderr
    return int(result.stdout.split()[-1])


@pytest.mark.parametrize("of_node", [LOCALHOST_ONLY, DISCOVERY_RANGE], ids=name)
def test_nothing_leaves_the_machine(domain_id, of_node):
    assert packets_beyond_localhost(domain_id, of_node) == 0


def test_the_packets_of_an_ordinary_node_are_counted(domain_id):
    assert packets_beyond_localhost(domain_id, {}) > 0
