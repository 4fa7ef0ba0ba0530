"""Benchmark of the node: time from process start to the first FREE or COLLIDING state that a subscriber receives."""

import time

from clearance_msgs.msg import CollisionState

from joint_state_source import Source
from node_process import NodeProcess
from peer import Peer
from rows import Row

RATE = 100.0  # [Hz]
PATIENCE = 60.0  # [s]


def measure(robot, times, domain_id, limit):
    with Peer(domain_id) as peer, Source("/joint_states", RATE, robot.joints, domain_id):
        peer.wait_for(lambda: peer.node.count_publishers("/joint_states"), "the driver")
        seconds = sorted(first_answer(robot, number, peer) for number in range(times))
    return Row(
        f"start to first answer, {robot.name}",
        f"{limit:g} s",
        f"{seconds[-1]:.2f} s",
        seconds[-1] <= limit,
        f"the longest of {times} starts; the shortest {seconds[0]:.2f} s",
    )


def first_answer(robot, number, peer):
    name = f"clearance_{number}"
    states = peer.record(CollisionState, f"/{name}/state")
    start = time.monotonic()
    with NodeProcess(*robot.arguments, domain_id=peer.domain_id, name=name) as node:

        def responded():
            assert node.exit_code is None, f"the node ended: {node.output()}"
            return any(state.status != CollisionState.UNKNOWN for state in states.all())

        peer.wait_for(responded, "an answer", PATIENCE)
        return time.monotonic() - start
