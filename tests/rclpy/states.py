"""Test helper: client of `~/check_states` and `~/get_distances`."""

from clearance_msgs.srv import CheckStates, GetDistances

import two_link
from motions import BURST


class States:
    """Asks the services, and waits for their answers. `terms` are the other fields of the requests, by name."""

    def __init__(self, peer, node):
        self._peer = peer
        self._states = peer.node.create_client(CheckStates, node.private("check_states"), qos_profile=BURST)
        self._distances = peer.node.create_client(GetDistances, node.private("get_distances"), qos_profile=BURST)
        for client in (self._states, self._distances):
            peer.wait_for(client.service_is_ready, client.srv_name)

    def ask(self, states, joints=two_link.JOINTS, **terms):
        """Like `check`, but gives the future of the answer."""
        request = CheckStates.Request(joint_names=list(joints), **terms)
        request.positions = [float(position) for state in states for position in state]
        return self._states.call_async(request)

    def check(self, states, **terms):
        return self.response(self.ask(states, **terms))

    def ask_distances(self, state=(), joints=two_link.JOINTS, **terms):
        """Like `distances`, but gives the future of the answer."""
        names = list(joints) if state else []
        request = GetDistances.Request(joint_names=names, positions=[float(position) for position in state], **terms)
        return self._distances.call_async(request)

    def distances(self, state=(), **terms):
        return self.response(self.ask_distances(state, **terms))

    def response(self, future):
        """The answer to what was asked before."""
        return self._peer.result(future, "an answer about states")


def pair_of(response, i):
    """The names of the bodies that are told of a state; none is an empty set."""
    return {response.bodies[index] for index in (response.pair_a[i], response.pair_b[i]) if index >= 0}
