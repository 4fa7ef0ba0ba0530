"""Test helper: stand-in for `move_group`, a node that returns its planning scene by a service."""

from moveit_msgs.msg import PlanningScene
from moveit_msgs.srv import GetPlanningScene

from peer import Peer


class MoveGroup:
    """A participant of its own; `before_answering` is called with it for each question."""

    def __init__(self, domain_id, service, scene, before_answering=lambda asked: None):
        self.scene = scene
        self.calls = 0
        self._before_answering = before_answering
        self._peer = Peer(domain_id)
        self.changes = self._peer.node.create_publisher(PlanningScene, "/monitored_planning_scene", 10)
        self._peer.node.create_service(GetPlanningScene, service, self._respond)

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._peer.__exit__(*error)

    def _respond(self, request, response):
        assert request.components.components, "what is asked for is named"
        response.scene = self.scene
        response.scene.robot_model_name = response.scene.robot_model_name or "two_link"
        self.calls += 1
        self._before_answering(self)
        return response
