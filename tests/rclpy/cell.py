"""A robot cell: a node, the driver of a two-link robot beside it, and the record of what the node says."""

import itertools
from functools import cached_property

from clearance_msgs.msg import CollisionState

import two_link
from node_process import NodeProcess
from parameters import Parameters

# Nothing grows old by accident on a loaded machine.
QUICK = {"heartbeat_rate": 20.0, "stale_after": 3600.0}
# Soon enough for a test to see it.
STALE_AFTER = 1.0  # [s]

_numbers = itertools.count(1)


class Cell:
    def __init__(self, peer, *arguments, urdf=two_link.URDF, parameters=None, driving=True, **options):
        number = next(_numbers)
        names = {"name": f"clearance_{number}", "namespace": f"/cell_{number}"}
        self._arguments = (("--urdf", urdf) if urdf else ()) + arguments
        self._options = names | options | {"parameters": QUICK | (parameters or {}), "domain_id": peer.domain_id}

        self.peer = peer
        self.node = NodeProcess(*self._arguments, **self._options)
        self.driver = two_link.Driver(peer, self.node.relative("joint_states"), driving)
        self.states = peer.record(CollisionState, self.node.private("state"))

    def __enter__(self):
        self.node.__enter__()
        return self

    def __exit__(self, *error):
        self.node.__exit__(*error)

    def restart_node(self):
        """Starts the same node once more, after it has ended."""
        self.node.__exit__(None, None, None)
        self.node = NodeProcess(*self._arguments, **self._options).__enter__()

    @cached_property
    def parameters(self):
        return Parameters(self.peer, self.node)

    def judged(self, **positions):
        """The first state judged of these joint positions, which the driver now reports."""
        stamp = self.driver.report(**positions)
        return self.states.wait_for(two_link.judged_since(stamp), f"a judgement of {positions}")

    def moving(self, positions, velocities):
        """The first state judged of these joint positions and velocities, which the driver now reports."""
        self.driver.velocities = velocities
        return self.judged(**positions)

    def grows_old(self):
        """From now on joint states are soon stale."""
        self.parameters.succeed(stale_after=STALE_AFTER)

    def has_model(self, revision=1):
        """Waits until this model is in force."""
        self.states.wait_for(lambda state: state.model_revision == revision, f"model revision {revision}")

    def unknown(self, reason_code, after=0):
        """The first state that is UNKNOWN for this reason, of those after the first `after` ones."""
        return self.states.wait_for(
            lambda state: state.status == CollisionState.UNKNOWN and state.reason_code == reason_code,
            f"UNKNOWN for the reason {reason_code}",
            after,
        )
