"""Test helper: restarts node, driver, client or description publisher, and waits until all results are back."""

import time
from contextlib import ExitStack
from itertools import count

from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckMotion

import two_link
from another_participant import Describer, call_of_another_client
from cell import STALE_AFTER, Cell
from joint_state_source import Source

JOINTS = {"joint1": (-0.5, 0.5), "joint2": (-0.5, 0.5)}  # free wherever they are
RATE = 50.0  # [Hz]


class Restarts:
    """A node, a driver and a publisher of the description, each a process of its own, and `peer`, which receives what they publish.

    In one process, rclpy crashes now and then when a participant is destroyed while another one spins.
    """

    def __init__(self, peer):
        self._peer = peer
        self._cell = Cell(peer, urdf=None, driving=False, parameters={"stale_after": STALE_AFTER})
        self._cubes = (0.4 + 0.001 * number for number in count(1))
        self._stack = ExitStack()
        self._describer = self._source = None

    def __enter__(self):
        with ExitStack() as stack:
            stack.enter_context(self._cell)
            stack.callback(lambda: self._describer and self._describer.kill())
            stack.callback(lambda: self._source and self._source.kill())
            self._describe()
            self._drive()
            self._free(self._peer.now())
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *error):
        self._stack.__exit__(*error)

    def joint_state_publisher(self):
        """It crashes; that it is silent is noticed before the next one speaks."""
        self._source.kill()
        self._cell.unknown("stale")
        start, since = time.monotonic(), self._peer.now()
        self._drive()
        self._free(since)
        return time.monotonic() - start

    def node(self, crash=False):
        """It is asked to end, or crashes; the next one has to meet everyone anew."""
        self._cell.node.kill() if crash else self._cell.node.stop()
        start, since = time.monotonic(), self._peer.now()
        self._cell.restart_node()
        self._free(since)
        return time.monotonic() - start

    def crashed_node(self):
        return self.node(crash=True)

    def client(self):
        """Another one comes, asks, and goes."""
        verdict, seconds = call_of_another_client(self._cell.node.path, self._peer.domain_id)
        assert verdict == CheckMotion.Response.FREE, verdict
        return seconds

    def description_publisher(self):
        """Another one comes with another robot, which has to come into force."""
        before = self._cell.state_now().model_revision
        self._describer.kill()
        start = time.monotonic()
        self._describe()
        self._free(self._peer.now(), lambda state: state.model_revision > before)
        return time.monotonic() - start

    ALL = (joint_state_publisher, node, crashed_node, client, description_publisher)

    def _describe(self):
        text = two_link.description_with_cube(next(self._cubes))
        topic = self._cell.node.relative("robot_description")
        self._describer = Describer(topic, text, self._peer.domain_id)

    def _drive(self):
        self._source = Source(self._cell.node.relative("joint_states"), RATE, JOINTS, self._peer.domain_id)

    def _free(self, since, accept=lambda state: True):
        evaluate = two_link.judged_since(since)
        self._cell.states.ever(
            lambda state: state.status == CollisionState.FREE and evaluate(state) and accept(state),
            f"FREE from a joint state after {since}",
        )
