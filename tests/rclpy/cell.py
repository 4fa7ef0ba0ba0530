"""Test helper: a node, the driver of its two-link robot, and recorders of the states that the node publishes."""

import itertools
from functools import cached_property
from time import monotonic

from clearance_msgs.msg import CollisionState
from std_msgs.msg import Bool, Float64

import two_link
from node_process import NodeProcess
from parameters import Parameters

# Nothing grows old by accident on a loaded machine.
QUICK = {"heartbeat_rate": 20.0, "stale_after": 3600.0}
PATIENCE = 5.0  # [s] after which a joint state is published again
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

    def evaluate(self, **positions):
        """The first state evaluated of these joint positions, which the driver reports from now on."""
        stamp = self.driver.report(**positions)
        return self.states.ever(two_link.judged_since(stamp), f"a state of {positions}")

    def moving(self, positions, velocities):
        """The first state evaluated of these joint positions and velocities, which the driver reports from now on."""
        self.driver.velocities = velocities
        return self.evaluate(**positions)

    def evaluated(self, positions, stamp=None):
        """The state evaluated of exactly this joint state. The driver falls silent, and this is its last one."""
        self.driver.pause()
        sent = []  # stamps and times [s] of publishing

        def publish():
            sent.append((stamp or self.peer.now(), monotonic()))
            self.driver.publish(positions, sent[-1][0])

        def responded():
            # what the node receives best effort may be lost on a busy machine
            if not sent or monotonic() > sent[-1][1] + PATIENCE:
                publish()
            return next(filter(two_link.evaluated_of(sent[-1][0]), self.states.all()), None)

        return self.peer.wait_for(responded, f"a state of {positions}")

    def falls_silent(self):
        """The driver stops, and its last joint state is evaluated: gives that state."""
        return self.evaluated(self.driver.positions)

    def state_now(self):
        """A state whose evaluation began after this call: of all that the node has acknowledged."""
        return self.states.wait_for(lambda _: True, "a state evaluated from now on", after=self.peer.now())

    def grows_old(self):
        """From now on joint states are soon stale."""
        self.parameters.succeed(stale_after=STALE_AFTER)

    def has_model(self, revision=1):
        """Waits until this model is in force."""
        return self.states.ever(lambda state: state.model_revision == revision, f"model revision {revision}")

    def becomes(self, status, what, after=None):
        """The first state of this status that follows `after`: a state, or a moment; without one, this moment."""
        return self.states.wait_for(lambda state: state.status == status, what, after or self.peer.now())

    def unknown(self, reason_code, after=None):
        """The first state that is UNKNOWN for this reason and follows `after`, as in `becomes`."""
        return self.states.wait_for(
            lambda state: state.status == CollisionState.UNKNOWN and state.reason_code == reason_code,
            f"UNKNOWN for the reason {reason_code}",
            after or self.peer.now(),
        )


class Companions:
    """What the node publishes beside `~/state` on topics of standard types, which carry no stamp.

    It publishes one message on each of them with every state, so that equal sequence numbers are about the same state.
    """

    KINDS = {
        "is_free": Bool,
        "distance": Float64,
        "self_distance": Float64,
        "world_distance": Float64,
        "speed_scale": Float64,
    }

    def __init__(self, cell, kinds=KINDS):
        self._states = cell.states
        self._recorders = {name: cell.peer.record(kind, cell.node.private(name)) for name, kind in kinds.items()}
        # a message published before both sides have met is lost
        for name, recorder in self._recorders.items():
            recorder.ever(lambda _: True, f"the first message of {name}")

    def of(self, state):
        """The values published with a state that came after this was made, by topic.

        Where one of them was lost on its way, those published with the next state that says the same.
        """
        while (said := self._with(state)) is None:
            state = self._states.wait_for(repeats(state), "the same state once more", after=state)
        return said

    def _with(self, state):
        number = self._states.number(state)
        messages = {name: recorder.numbered(number) for name, recorder in self._recorders.items()}
        lost = None in messages.values()
        return None if lost else {name: message.data for name, message in messages.items()}


def repeats(state):
    """Accepts states that say the same as this one."""

    def said(state):
        # by their text: NaN is unequal to itself
        nearest = state.nearest, state.distance_known, state.self_distance, state.world_distance
        return repr((state.status, state.reason_code, nearest, state.time_to_contact))

    expected = said(state)
    return lambda later: said(later) == expected
