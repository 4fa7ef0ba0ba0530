"""Test helper: changes the world of a node, by topic or by service, and waits until the change is in force."""

from time import monotonic

from clearance_msgs.msg import BodyPair
from diagnostic_msgs.msg import DiagnosticArray
from moveit_msgs.msg import (
    AttachedCollisionObject,
    CollisionObject,
    PlanningScene,
    PlanningSceneComponents,
    PlanningSceneWorld,
)
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene, GetStateValidity
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Empty

# Matches a subscription of either durability.
KEPT = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# [s] after which a cloud is published again.
PATIENCE = 5.0
# Every client of a service hears the answers to all others: see `motions.py`.
BURST = QoSProfile(depth=200)

KINDS = {BodyPair.LINK: "link", BodyPair.OBSTACLE: "obstacle", BodyPair.ATTACHED: "attached"}


def bodies(pair):
    """Both bodies of a pair, each as its kind and name."""
    return {(KINDS[pair.type_a], pair.body_a), (KINDS[pair.type_b], pair.body_b)}


def colliding(state):
    return [bodies(pair) for pair in state.colliding_pairs]


def distances(state):
    """Of all near pairs, by the names of both bodies."""
    return {frozenset((near.pair.body_a, near.pair.body_b)): near.distance for near in state.pair_distances}


def distance(state, a, b):
    """Between two bodies that are near; None if the pair is not among the near ones."""
    return distances(state).get(frozenset((a, b)))


class SceneClient:
    """Says what changes, and waits for the first state with the change in it."""

    def __init__(self, cell):
        self._cell = cell
        self._peer = cell.peer
        self._publishers = {}
        self._clients = {}
        self.complaints = Complaints(cell)

    def world_revision(self):
        """Of a world with all changes that the node has acknowledged."""
        return self._cell.state_now().world_revision

    # By topic

    def topic(self, kind, name, qos=KEPT):
        """A publisher to a relative topic of the node, once it has been met."""
        if name not in self._publishers:
            publisher = self._peer.node.create_publisher(kind, self._cell.node.relative(name), qos)
            self._peer.wait_for(publisher.get_subscription_count, f"a subscription of {name}")
            self._publishers[name] = publisher
        return self._publishers[name]

    def publish(self, message, topic=None, qos=KEPT):
        """On the topic of its type."""
        default = {
            PlanningScene: "planning_scene",
            PlanningSceneWorld: "planning_scene_world",
            CollisionObject: "collision_object",
            AttachedCollisionObject: "attached_collision_object",
        }
        self.topic(type(message), topic or default[type(message)], qos).publish(message)

    def change(self, *messages, topic=None):
        """Publishes, and gives the first state of a world that has all these changes. Each must change something."""
        for message in messages:
            state = self._change(message, topic)
        return state

    def _change(self, message, topic):
        before = self._cell.state_now()
        self.publish(message, topic)
        published = monotonic()

        def is_there(state):
            nonlocal published
            # What a node hears best effort may be lost on a busy machine; a sensor would say it again anyway.
            if topic and monotonic() > published + PATIENCE:
                published = monotonic()
                self.publish(message, topic)
            return state.world_revision > before.world_revision

        what = f"a world after revision {before.world_revision}"
        return self._cell.states.wait_for(is_there, what, after=before)

    def rejected(self, message, *words, topic=None):
        """Publishes what must be refused: it is complained about with these words, and the world stays as it was."""
        before = self.world_revision()
        self.complaints.forget()
        self.publish(message, topic)
        complaint = self.complaints.wait_for(*words)
        assert self.world_revision() == before
        return complaint

    # By service

    def service(self, kind, name):
        if name not in self._clients:
            client = self._peer.node.create_client(kind, self._cell.node.relative(name), qos_profile=BURST)
            self._peer.wait_for(client.service_is_ready, name)
            self._clients[name] = client
        return self._clients[name]

    def request(self, kind, name, request):
        """Asks without waiting for the answer."""
        return self.service(kind, name).call_async(request)

    def call(self, kind, name, request):
        return self._peer.result(self.request(kind, name, request), f"an answer of {name}")

    def apply(self, scene):
        """Whether it was taken."""
        return self.call(ApplyPlanningScene, "apply_planning_scene", ApplyPlanningScene.Request(scene=scene)).success

    def get(self, *components):
        """These components of the scene, by name; without any, everything."""
        wanted = sum(getattr(PlanningSceneComponents, component) for component in components)
        request = GetPlanningScene.Request(components=PlanningSceneComponents(components=wanted))
        return self.call(GetPlanningScene, "get_planning_scene", request).scene

    def obstacles(self):
        """The obstacles of the world by name."""
        return {item.id: item for item in self.get("WORLD_OBJECT_GEOMETRY").world.collision_objects}

    def clear_octomap(self):
        self.call(Empty, "clear_octomap", Empty.Request())

    def validity(self, *state, **request):
        """`check_state_validity` of these joint positions by name; those that are not named are the current ones."""
        return self._peer.result(self.ask_validity(*state, **request), "an answer of check_state_validity")

    def ask_validity(self, joints=None, group="", attached=(), is_diff=True, **request):
        request = GetStateValidity.Request(group_name=group, **request)
        request.robot_state.is_diff = is_diff
        request.robot_state.joint_state.name = list(joints or {})
        request.robot_state.joint_state.position = [float(position) for position in (joints or {}).values()]
        request.robot_state.attached_collision_objects = list(attached)
        return self.request(GetStateValidity, "check_state_validity", request)


class Complaints:
    """What a node warns of: in its states, in its diagnostics or in the log."""

    def __init__(self, cell):
        self._cell = cell
        self._diagnostics = cell.peer.record(DiagnosticArray, "/diagnostics")
        self._log = cell.peer.record(Log, "/rosout")
        self.forget()

    def forget(self):
        """Only what is published from now on counts."""
        self._start = self._cell.peer.now()
        self._printed = len(self._cell.node.output())

    def texts(self):
        for state in self._cell.states.after(self._start):
            yield from state.warnings
            yield state.reason
        for array in self._diagnostics.after(self._start):
            for status in array.status:
                yield status.message
                yield from (item.value for item in status.values)
        for entry in self._log.published_since(self._start):
            if entry.level >= Log.WARN:
                yield entry.msg
        printed = self._cell.node.output()[self._printed :].splitlines()
        yield from (line for line in printed if "WARN" in line or "ERROR" in line)

    def wait_for(self, *words):
        """The first that holds all these words."""

        def search():
            return next((text for text in self.texts() if all(word in text for word in words)), None)

        return self._cell.peer.wait_for(search, f"a complaint about {', '.join(words)}")

    def none_about(self, word):
        assert not [text for text in self.texts() if word in text]
