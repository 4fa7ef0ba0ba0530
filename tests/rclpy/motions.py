"""Test helper: client of `~/check_motion` and `~/check_trajectory`."""

import json

from clearance_msgs.srv import CheckMotion, CheckTrajectory
from rclpy.qos import QoSProfile
from std_msgs.msg import String
from visualization_msgs.msg import Marker, MarkerArray

import two_link

# Every client of a service hears the answers to all others and passes them over; with the usual depth of 10, a burst of more
# answers pushes its own out of its memory.
BURST = QoSProfile(depth=200)


class Motions:
    """Asks the services, and waits for their answers. `terms` are the other fields of the requests, by name."""

    def __init__(self, peer, node):
        self._peer = peer
        self._motions = peer.node.create_client(CheckMotion, node.private("check_motion"), qos_profile=BURST)
        self._trajectories = peer.node.create_client(
            CheckTrajectory, node.private("check_trajectory"), qos_profile=BURST
        )
        self._certificates = peer.record(String, node.private("certificates"))
        self._swept_volumes = peer.record(MarkerArray, node.private("swept_volume"))
        for client in (self._motions, self._trajectories):
            peer.wait_for(client.service_is_ready, client.srv_name)
        for topic in ("certificates", "swept_volume"):
            peer.wait_for(lambda: peer.node.count_publishers(node.private(topic)) == 1, f"the topic {topic}")

    def ask(self, start, goal, joints=two_link.JOINTS, **terms):
        """Like `check`, but gives the future of the answer."""
        request = CheckMotion.Request(joint_names=list(joints), **terms)
        request.start = [float(position) for position in start]
        request.goal = [float(position) for position in goal]
        return self._motions.call_async(request)

    def check(self, start, goal, **terms):
        return self._peer.result(self.ask(start, goal, **terms), "an answer of check_motion")

    def ask_to_follow(self, trajectory, **terms):
        """Like `follow`, but gives the future of the answer."""
        return self._trajectories.call_async(CheckTrajectory.Request(trajectory=trajectory, **terms))

    def follow(self, trajectory, **terms):
        return self._peer.result(self.ask_to_follow(trajectory, **terms), "an answer of check_trajectory")

    def certificate(self, response):
        """The certificate of an answer; the same is published on its topic."""
        assert response.certificate_digest
        message = self._certificates.ever(
            lambda message: json.loads(message.data)["digest"] == response.certificate_digest, "the certificate"
        )
        assert response.certificate == message.data
        return message.data

    def with_swept_volume(self, ask):
        """What `ask()` gives, and the markers that are published meanwhile, without the one that takes away all others."""
        start = self._peer.now()
        response = ask()
        # volumes of earlier requests were published before their responses
        first, *markers = self._swept_volumes.event(lambda _: True, "a swept volume", since=start).markers
        assert first.action == Marker.DELETEALL
        return response, markers
